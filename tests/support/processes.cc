#include "tests/support/processes.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <thread>

namespace isolux::testing {
namespace {

namespace fs = std::filesystem;

constexpr double kLongS = 300;  // far beyond what anything here takes

TemporaryDirectory MakeFolder() {
  auto folder = TemporaryDirectory::Make("isolux-cluster-test-");
  EXPECT_TRUE(folder.has_value());
  return std::move(*folder);
}

std::string Program(const std::string& name) { return std::string(ISOLUX_BIN_DIR "/") + name; }

std::string Contents(const std::string& path) { return ReadFile(path).value_or(std::string()); }

}  // namespace

Programs::Programs() : folder_(MakeFolder()) {
  fs::create_directory(Path("tmp"));
  ::setenv("TMPDIR", Path("tmp").c_str(), 1);
  ::setenv("HOME", folder_.path().c_str(), 1);
  ::unsetenv("ISOLUX_SERVER");
}

Programs::~Programs() {
  client_.reset();
  workers_.clear();
  server_.clear();
  ::unsetenv("TMPDIR");
  if (!::testing::Test::HasFailure()) return;
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    if (entry.path().extension() != ".log") continue;
    std::cerr << "---- " << entry.path().filename() << "\n" << Contents(entry.path()) << "\n";
  }
}

std::vector<std::string> Programs::TemporaryFiles() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(Path("tmp"))) {
    names.push_back(entry.path().filename());
  }
  return names;
}

void Programs::StartServer(const std::vector<std::string>& extra, const std::string& listen) {
  std::vector<std::string> arguments = {
      Program("isolux-server"), "--listen", listen, "--port-file", "-", "--data-dir", Path("data")};
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  ChildProcess::Options options;
  options.pipe_output = true;
  options.error_file = Path("server.log");
  auto server = ChildProcess::Start(arguments, options);
  ASSERT_TRUE(server.has_value()) << server.error().message();
  server_.push_back(std::move(*server));
  const auto port = server_.back().ReadLine(kLongS);
  ASSERT_TRUE(port.has_value()) << port.error().message() << ServerLog();
  address_ = fmt::format("127.0.0.1:{}", *port);
  client_ = std::move(*Client::Make(address_));
}

std::string Programs::ServerLog() const { return Contents(Path("server.log")); }

ChildProcess& Programs::StartWorker(int threads) {
  const std::string name = fmt::format("w{}", workers_.size() + 1);
  const auto before = client_->CountWorkers();
  EXPECT_TRUE(before.has_value());
  workers_.push_back(Start(
      {"isolux-worker", "--server", address_, "--threads", std::to_string(threads), "--name", name},
      name + ".log"));
  WaitForWorkers(*before + 1);
  return workers_.back();
}

void Programs::WaitForWorkers(uint32_t count) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kLongS);
  Result<uint32_t> connected = 0u;
  while (std::chrono::steady_clock::now() < end) {
    connected = client_->CountWorkers();
    if (connected && *connected == count) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  FAIL() << "not " << count << " workers are connected";
}

ChildProcess Programs::Start(const std::vector<std::string>& arguments, const std::string& log) {
  std::vector<std::string> all = arguments;
  all[0] = Program(all[0]);
  ChildProcess::Options options;
  options.error_file = Path(log);
  options.output_file = Path(log + ".out");
  auto child = ChildProcess::Start(all, options);
  EXPECT_TRUE(child.has_value()) << child.error().message();
  return std::move(*child);
}

CommandResult Programs::Run(const std::vector<std::string>& arguments) {
  const std::string log = fmt::format("command-{}.log", ++runs_);
  ChildProcess child = Start(arguments, log);
  EXPECT_TRUE(child.Wait(kLongS)) << arguments[0] << " hangs";
  return {child.exit_code(), Contents(Path(log + ".out")), Contents(Path(log))};
}

CommandResult Programs::Isolux(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "isolux");
  arguments.insert(arguments.end(), {"--server", address_});
  return Run(arguments);
}

JobInfo Programs::WaitForRounds(uint64_t job, size_t rounds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kLongS);
  while (std::chrono::steady_clock::now() < end) {
    const auto info = client_->Get(job);
    EXPECT_TRUE(info.has_value()) << info.error().message();
    if (!info) break;
    if (HasEnded(info->state) || info->summary.rounds.size() >= rounds) return *info;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  ADD_FAILURE() << "job " << job << " tells no " << rounds << " rounds";
  return {};
}

JobInfo Programs::WaitForEnd(uint64_t job) { return WaitForRounds(job, ~size_t{0}); }

std::string ScenePath(const std::string& name) {
  return std::string(ISOLUX_SOURCE_DIR "/scenes/") + name;
}

std::string Physics(const std::string& path) {
  const std::string bytes = Contents(path);
  const std::string mark = "end_header\n";
  const size_t end = bytes.find(mark);
  EXPECT_NE(end, std::string::npos) << path << " is no patch file";
  std::istringstream header(bytes.substr(0, end));
  std::string kept;
  for (std::string line; std::getline(header, line);) {
    if (!line.starts_with("comment ")) kept += line + "\n";
  }
  return kept + bytes.substr(end);
}

}  // namespace isolux::testing
