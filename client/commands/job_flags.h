// What the commands that talk to a coordinator have in common: flags, interruption, exit codes.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "client/client.h"
#include "client/commands/import_flags.h"
#include "client/local_cluster.h"
#include "common/scene/solve_options.h"
#include "common/util/signals.h"
#include "common/util/status.h"

namespace CLI {
class App;
}

namespace isolux {

inline constexpr int kExitFailed = 1, kExitUsage = 2, kExitInterrupted = 130;

// --server, with ISOLUX_SERVER and the usual address behind it.
void AddServerFlag(CLI::App& command, std::string* server);

// Every field of SolveOptions, by its name.
void AddSolveFlags(CLI::App& command, SolveOptions* options);
// The same but for what says how fine the solution is to be: --accuracy and --epsilons.
void AddEffortFlags(CLI::App& command, SolveOptions* options);

// --workers, --threads and --log-level of a cluster of one's own.
void AddClusterFlags(CLI::App& command, LocalCluster::Options* options);

// Says what went wrong, "isolux COMMAND: …", and gives the exit code.
int Fail(const char* command, const Status& status);

// Of a job that has ended: 0 where it is done.
int ExitCode(const JobInfo& job);

// The scene of a file as it is handed in. `strict` and the like are the importer's business.
Result<Client::Submission> Prepare(const std::string& path, const ImportOptions& import,
                                   const SolveOptions& options);

// From its making on, the first Ctrl-C or SIGTERM calls `action` (on another thread) instead of
// ending the program; the second ends it. Make it before any other thread is started.
class Interruption {
 public:
  Interruption();
  void Set(std::function<void()> action);
  bool happened() const { return happened_; }

 private:
  std::mutex mutex_;
  std::function<void()> action_;  // guarded by mutex_
  std::atomic<bool> happened_{false};
  std::optional<SignalWatcher> signals_;
};

// Watches a job to its end, showing its progress.
Result<JobInfo> WatchWithProgress(Client& client, uint64_t job, double accuracy);

}  // namespace isolux
