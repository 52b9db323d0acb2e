// isolux-server: the coordinator. Flags, start, signals; all else is in the libraries.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <mutex>

#include "common/util/build_info.h"
#include "common/util/file.h"
#include "common/util/log.h"
#include "common/util/signals.h"
#include "server/coordinator.h"

namespace isolux {
namespace {

struct Flags {
  CoordinatorOptions coordinator;
  std::string port_file;
  std::string log_level = "info";
  bool temporary = false;
};

constexpr int kUsage = 2;  // bad usage or bad input

void AddFlags(CLI::App& app, Flags& flags) {
  app.set_version_flag("--version", BuildId());
  app.add_option("--listen", flags.coordinator.server.listen, "HOST:PORT; port 0: a free one")
      ->capture_default_str();
  app.add_option("--port-file", flags.port_file,
                 "file that the port is written to once calls are answered; -: standard output");
  app.add_option("--data-dir", flags.coordinator.data_dir,
                 "folder for jobs, scenes and results [~/.local/share/isolux]");
  app.add_flag("--temporary", flags.temporary,
               "remove the folder at the end; without --data-dir it is a temporary one");
  app.add_flag("--insecure", flags.coordinator.server.insecure,
               "allow an address that others can reach, without credentials");
  app.add_option("--log-level", flags.log_level, "debug|info|warn|error|off")
      ->capture_default_str();
  app.add_option("--lease", flags.coordinator.sessions.lease_s,
                 "seconds of silence after which a worker is given up")
      ->check(CLI::Range(0.2, 3600.0))
      ->capture_default_str();
  app.add_option("--max-scene-bytes", flags.coordinator.queue.scene.bytes,
                 "largest scene that is taken, bytes")
      ->capture_default_str();
  app.add_option("--max-polygons", flags.coordinator.queue.scene.polygons,
                 "most polygons of a scene that is taken")
      ->capture_default_str();
  app.add_option("--max-jobs", flags.coordinator.queue.unfinished_jobs,
                 "most jobs that are queued or running")
      ->capture_default_str();
}

Result<std::string> DefaultDataDir() {
  if (const char* xdg = std::getenv("XDG_DATA_HOME"); xdg != nullptr && *xdg != '\0') {
    return std::string(xdg) + "/isolux";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return std::string(home) + "/.local/share/isolux";
  }
  return Error(StatusCode::kInvalidArgument, "HOME is not set: give a folder with --data-dir");
}

// Waits for SIGTERM or SIGINT. A second one ends the process at once, unless there is a folder to
// remove: the death of a parent with several threads can be told twice.
class StopRequest {
 public:
  explicit StopRequest(bool patient)
      : signals_([this, patient](int count) {
          if (count > 1 && !patient) ::_exit(1);
          std::lock_guard lock(mutex_);
          requested_ = true;
          changed_.notify_all();
        }) {}
  void Wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return requested_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool requested_ = false;
  SignalWatcher signals_;
};

// The folder that is removed at the end, where one is asked for.
struct RemovedAtTheEnd {
  std::string path;
  ~RemovedAtTheEnd() {
    std::error_code ignored;  // nothing more can be done about it
    if (!path.empty()) std::filesystem::remove_all(path, ignored);
  }
};

Status TellPort(const std::string& port_file, int port) {
  if (port_file.empty()) return {};
  if (port_file != "-") return WriteFileDurably(port_file, std::to_string(port) + "\n");
  std::printf("%d\n", port);
  std::fflush(stdout);
  return {};
}

Status Serve(Flags& flags, StopRequest& stop) {
  RemovedAtTheEnd removed;
  std::string& data_dir = flags.coordinator.data_dir;
  if (data_dir.empty() && flags.temporary) {
    ASSIGN_OR_RETURN(auto temporary, TemporaryDirectory::Make("isolux-server-"));
    data_dir = temporary.Keep();
  } else if (data_dir.empty()) {
    ASSIGN_OR_RETURN(data_dir, DefaultDataDir());
  }
  flags.coordinator.sessions.heartbeat_s = flags.coordinator.sessions.lease_s / 5;
  flags.coordinator.job.lease_s = flags.coordinator.sessions.lease_s;
  ASSIGN_OR_RETURN(auto coordinator, Coordinator::Start(flags.coordinator));
  // Only now is the folder surely ours.
  if (flags.temporary) removed.path = data_dir;
  RETURN_IF_ERROR(TellPort(flags.port_file, coordinator->port()));
  LogInfo("{} listens on {}, data in {}", BuildId(), coordinator->address(), data_dir);
  stop.Wait();
  LogInfo("stopping");
  coordinator->Stop();
  LogInfo("stopped");
  return {};
}

int Main(int argc, char** argv) {
  BlockTerminationSignals();
  Flags flags;
  CLI::App app("The coordinator of Isolux: takes scenes, runs jobs on the workers that connect.",
               "isolux-server");
  AddFlags(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  const Result<LogLevel> level = ParseLogLevel(flags.log_level);
  Status status = CheckProcessor();
  if (status.ok() && !level) status = level.error();
  if (status.ok()) {
    StartLog("isolux-server", *level);
    StopRequest stop(flags.temporary);
    status = Serve(flags, stop);
  }
  if (status.ok()) return 0;
  std::fprintf(stderr, "isolux-server: %s\n", status.message().c_str());
  return status.code() == StatusCode::kInvalidArgument ? kUsage : 1;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) { return isolux::Main(argc, argv); }
