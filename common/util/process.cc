#include "common/util/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include "common/util/signals.h"

namespace isolux {
namespace {

constexpr size_t kMaxLine = 4096;

struct ChildPlan {
  std::vector<char*> arguments;
  int death_signal;
  int output, error;  // -1: inherit
  int report;         // errno of a failed start goes here
  pid_t parent;
};

// Between fork and exec only calls that are safe there.
[[noreturn]] void RunChild(const ChildPlan& plan) {
  ::setpgid(0, 0);
  if (plan.death_signal != 0) ::prctl(PR_SET_PDEATHSIG, plan.death_signal);
  UnblockTerminationSignals();
  std::signal(SIGPIPE, SIG_DFL);
  // The parent may have ended before the request above.
  if (::getppid() != plan.parent) ::_exit(1);
  if (plan.error >= 0) ::dup2(plan.error, STDERR_FILENO);
  ::dup2(plan.output >= 0 ? plan.output : STDERR_FILENO, STDOUT_FILENO);
  ::execvp(plan.arguments[0], plan.arguments.data());
  const int reason = errno;
  [[maybe_unused]] const ssize_t wrote = ::write(plan.report, &reason, sizeof reason);
  ::_exit(127);
}

int OpenForWriting(const std::string& path) {
  if (path.empty()) return -1;
  return ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
}

void CloseIfOpen(int descriptor) {
  if (descriptor >= 0) ::close(descriptor);
}

}  // namespace

Result<ChildProcess> ChildProcess::Start(const std::vector<std::string>& arguments,
                                         const Options& options) {
  int report[2], output[2] = {-1, -1};
  if (::pipe2(report, O_CLOEXEC) != 0) {
    return Error(StatusCode::kResourceExhausted, "no pipe: {}", std::strerror(errno));
  }
  if (options.pipe_output && ::pipe2(output, O_CLOEXEC) != 0) {
    CloseIfOpen(report[0]);
    CloseIfOpen(report[1]);
    return Error(StatusCode::kResourceExhausted, "no pipe: {}", std::strerror(errno));
  }
  ChildPlan plan;
  for (const std::string& argument : arguments) {
    plan.arguments.push_back(const_cast<char*>(argument.c_str()));
  }
  plan.arguments.push_back(nullptr);
  plan.death_signal = options.death_signal;
  plan.output = options.pipe_output ? output[1] : OpenForWriting(options.output_file);
  plan.error = OpenForWriting(options.error_file);
  plan.report = report[1];
  plan.parent = ::getpid();

  ChildProcess child;
  child.id_ = ::fork();
  if (child.id_ == 0) RunChild(plan);
  CloseIfOpen(plan.output);
  CloseIfOpen(plan.error);
  CloseIfOpen(report[1]);
  child.output_ = output[0];
  int reason = 0;
  if (child.id_ < 0) reason = errno;
  // Ends without a byte when exec has closed the child's end.
  const ssize_t got = child.id_ < 0 ? 0 : ::read(report[0], &reason, sizeof reason);
  CloseIfOpen(report[0]);
  if (child.id_ < 0 || got > 0) {
    return Error(StatusCode::kNotFound, "{}: cannot be started: {}", arguments[0],
                 std::strerror(reason));
  }
  return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept { *this = std::move(other); }

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(exit_code_, other.exit_code_);
  std::swap(output_, other.output_);
  return *this;
}

ChildProcess::~ChildProcess() {
  CloseIfOpen(output_);
  if (!Running()) return;
  ::kill(-id_, SIGKILL);  // its group: what it has started, too
  ::waitpid(id_, nullptr, 0);
}

bool ChildProcess::Running() {
  if (id_ < 0) return false;
  int status = 0;
  if (::waitpid(id_, &status, WNOHANG) != id_) return true;
  id_ = -1;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return false;
}

void ChildProcess::Signal(int signal) {
  if (Running()) ::kill(id_, signal);
}

bool ChildProcess::Wait(double timeout_s) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  while (Running()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

Result<std::string> ChildProcess::ReadLine(double timeout_s) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  std::string line;
  while (line.size() < kMaxLine) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    pollfd wait{output_, POLLIN, 0};
    if (left.count() <= 0 || ::poll(&wait, 1, static_cast<int>(left.count())) == 0) {
      return Error(StatusCode::kDeadlineExceeded, "no line came within {} s", timeout_s);
    }
    char c = 0;
    const ssize_t got = ::read(output_, &c, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Error(StatusCode::kUnavailable, "the output has ended");
    if (c == '\n') return line;
    line += c;
  }
  return Error(StatusCode::kResourceExhausted, "a line of more than {} bytes", kMaxLine);
}

std::string ProgramBeside(const std::string& program) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return program;
  const auto beside = self.parent_path() / program;
  return std::filesystem::exists(beside, error) ? beside.string() : program;
}

}  // namespace isolux
