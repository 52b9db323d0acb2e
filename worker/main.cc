// isolux-worker: flags, connect, serve, connect again, drain on SIGTERM.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>

#include "common/util/build_info.h"
#include "common/util/log.h"
#include "common/util/signals.h"
#include "worker/serve.h"
#include "worker/session.h"

namespace isolux {
namespace {

constexpr int kUsage = 2;                                 // bad usage or bad input
constexpr double kConnectS = 10;                          // waited for a welcome
constexpr double kFirstPauseS = 0.1, kLongestPauseS = 5;  // between attempts to connect

struct Flags {
  ChannelOptions channel;
  WorkerOptions worker;
  std::string name;
  std::string log_level = "info";
  bool wait = false;
};

void AddFlags(CLI::App& app, Flags& flags) {
  app.set_version_flag("--version", BuildId());
  app.add_option("--server", flags.channel.server, "HOST:PORT of the coordinator")
      ->envname(kServerVariable)
      ->capture_default_str();
  app.add_option("--threads", flags.worker.threads, "that compute; 0: one a core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--name", flags.name, "for logs and reports");
  app.add_flag("--wait", flags.wait, "wait for a coordinator that does not answer yet");
  app.add_option("--log-level", flags.log_level, "debug|info|warn|error|off")
      ->capture_default_str();
}

// The first signal asks to drain, the second ends the process at once.
class Leave {
 public:
  explicit Leave(WorkerState* state)
      : signals_([this, state](int count) {
          if (count > 1) ::_exit(1);
          LogInfo("asked to leave: handing over first; a second signal ends at once");
          std::lock_guard lock(mutex_);
          state->drain = true;
          asked_ = true;
          changed_.notify_all();
        }) {}
  bool asked() const {
    std::lock_guard lock(mutex_);
    return asked_;
  }
  // False when asked to leave meanwhile.
  bool Pause(double seconds) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return asked_; });
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool asked_ = false;
  SignalWatcher signals_;
};

// Whether another attempt may succeed.
bool MayComeBack(const Status& status) {
  return status.code() == StatusCode::kUnavailable ||
         status.code() == StatusCode::kDeadlineExceeded ||
         status.code() == StatusCode::kResourceExhausted;
}

Status Serve(const Flags& flags) {
  WorkerState state(flags.worker);
  Leave leave(&state);
  const WorkerIdentity identity{flags.name, static_cast<uint32_t>(state.pool.thread_count())};
  double pause_s = kFirstPauseS;
  bool connected_before = flags.wait;
  while (!leave.asked()) {
    auto session = WorkerSession::Connect(flags.channel, identity, kConnectS);
    if (session) {
      LogInfo("connected to {} as number {}", flags.channel.server, (*session)->id());
      connected_before = true;
      pause_s = kFirstPauseS;
      const Status served = ServeJobs((*session)->port(), flags.worker, state);
      if (served.ok()) break;
      if (leave.asked()) break;  // the coordinator went away first: nobody waits for us
      LogWarn("{}: connecting again", served.message());
    } else {
      if (!connected_before || !MayComeBack(session.error())) return session.error();
      LogDebug("{}", session.error().message());
    }
    if (!leave.Pause(pause_s)) break;
    pause_s = std::min(2 * pause_s, kLongestPauseS);
  }
  LogInfo("left");
  return {};
}

int Main(int argc, char** argv) {
  BlockTerminationSignals();
  Flags flags;
  CLI::App app("A worker of Isolux: computes its part of the jobs of a coordinator.",
               "isolux-worker");
  AddFlags(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  const Result<LogLevel> level = ParseLogLevel(flags.log_level);
  Status status = CheckProcessor();
  if (status.ok() && !level) status = level.error();
  if (status.ok()) status = flags.channel.Validate();
  if (status.ok()) {
    StartLog(flags.name.empty() ? "isolux-worker" : "isolux-worker " + flags.name, *level);
    status = Serve(flags);
  }
  if (status.ok()) return 0;
  std::fprintf(stderr, "isolux-worker: %s\n", status.message().c_str());
  return status.code() == StatusCode::kInvalidArgument ? kUsage : 1;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) { return isolux::Main(argc, argv); }
