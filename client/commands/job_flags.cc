#include "client/commands/job_flags.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>

#include "client/import/import.h"
#include "client/progress.h"
#include "common/rpc/server_address.h"

namespace isolux {
namespace {

constexpr const char* kSolving = "Solving";  // heading in the help

}  // namespace

void AddServerFlag(CLI::App& command, std::string* server) {
  *server = kDefaultServer;
  command.add_option("--server", *server, "HOST:PORT of the coordinator")
      ->envname(kServerVariable)
      ->capture_default_str();
}

void AddSolveFlags(CLI::App& command, SolveOptions* options) {
  command
      .add_option("--accuracy", options->accuracy,
                  "mean error of the irradiance over its mean, in (0, 1]")
      ->group(kSolving)
      ->capture_default_str();
  AddEffortFlags(command, options);
  command
      .add_option("--epsilons", options->epsilons,
                  "thresholds of the rounds, W, separated by commas, instead of the schedule's")
      ->group(kSolving)
      ->delimiter(',');
}

void AddEffortFlags(CLI::App& command, SolveOptions* options) {
  const auto add = [&](const char* name, auto& value, const char* help) {
    return command.add_option(name, value, help)->group(kSolving)->capture_default_str();
  };
  add("--max-seconds", options->max_seconds, "time budget; 0: none");
  add("--max-links", options->max_links, "link budget over all workers; 0: none");
  add("--max-memory", options->max_memory_bytes,
      "memory budget for links and nodes over all workers, bytes or with K, M, G; 0: none")
      ->transform(CLI::AsSizeValue(/*kb_is_1000=*/false));
  add("--max-rounds", options->max_rounds, "most rounds");
  add("--cut-size", options->cut_size, "pieces that the tree is divided into for the workers");
  const std::map<std::string, Distribution> distributions = {{"octree", Distribution::kOctree},
                                                             {"random", Distribution::kRandom},
                                                             {"input", Distribution::kInput},
                                                             {"balanced", Distribution::kBalanced}};
  command
      .add_option("--distribution", options->distribution,
                  "of the pieces at the start: octree|random|input|balanced [octree]")
      ->group(kSolving)
      ->transform(CLI::CheckedTransformer(distributions).description(""));
  const std::map<std::string, BalanceStrategy> strategies = {
      {"none", BalanceStrategy::kNone},
      {"rotate", BalanceStrategy::kRotate},
      {"greedy-refine", BalanceStrategy::kGreedyRefine}};
  command
      .add_option("--balance", options->balance,
                  "between rounds: none|rotate|greedy-refine [greedy-refine]")
      ->group(kSolving)
      ->transform(CLI::CheckedTransformer(strategies).description(""));
  add("--balance-threshold", options->balance_threshold,
      "max/mean of the predicted load above which pieces move");
  add("--seed", options->seed, "of the sampling");
  std::map<std::string, SolverMethod> methods;
  for (int m = 0; m <= static_cast<int>(SolverMethod::kSouthwell); ++m)
    methods[ToText(static_cast<SolverMethod>(m))] = static_cast<SolverMethod>(m);
  command
      .add_option(
          "--solver", options->solver,
          "of each round: cg|jacobi|gauss-seidel|chebyshev|southwell; all but the first are "
          "for study [cg]")
      ->group(kSolving)
      ->transform(CLI::CheckedTransformer(methods).description(""));
  AddEffectsFlag(command, &options->effects);
  // For tests: hidden.
  command.add_option("--forced-splits", options->forced_splits)->group("");
}

void AddClusterFlags(CLI::App& command, LocalCluster::Options* options) {
  command.add_option("--workers", options->workers, "worker processes")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command
      .add_option("--threads", options->threads,
                  "threads of each worker; 0: the cores shared out among them")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command.add_option("--log-level", options->log_level, "of the child processes")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
}

int Fail(const char* command, const Status& status) {
  std::fprintf(stderr, "isolux %s: %s\n", command, status.message().c_str());
  switch (status.code()) {
    case StatusCode::kInvalidArgument:
    case StatusCode::kNotFound:
    case StatusCode::kOutOfRange:
    case StatusCode::kAlreadyExists:
      return kExitUsage;
    default:
      return kExitFailed;
  }
}

int ExitCode(const JobInfo& job) { return job.state == JobState::kDone ? 0 : kExitFailed; }

Result<Client::Submission> Prepare(const std::string& path, const ImportOptions& import,
                                   const SolveOptions& options) {
  RETURN_IF_ERROR(options.Validate());
  Result<Scene> scene = ImportScene(path, import);
  // Whatever is wrong with a scene is bad input.
  if (!scene) return Error(StatusCode::kInvalidArgument, "{}", scene.error().message());
  if (const std::string repairs = DescribeRepairs(scene->repairs); !repairs.empty()) {
    std::fprintf(stderr, "mended in %s:\n%s", path.c_str(), repairs.c_str());
  }
  Client::Submission submission;
  submission.name = std::filesystem::path(path).filename().string();
  submission.options = options;
  submission.polygons = scene->polygons.size();
  submission.repairs = std::move(scene->repairs);
  submission.encoded_scene = Encode(*scene);
  return submission;
}

Interruption::Interruption() {
  BlockTerminationSignals();
  signals_.emplace([this](int count) {
    if (count > 1) ::_exit(kExitInterrupted);
    std::lock_guard lock(mutex_);
    happened_ = true;
    if (action_) action_();
  });
}

void Interruption::Set(std::function<void()> action) {
  std::lock_guard lock(mutex_);
  action_ = std::move(action);
  if (happened_ && action_) action_();
}

Result<JobInfo> WatchWithProgress(Client& client, uint64_t job, double accuracy) {
  ProgressView view(accuracy);
  Client::Watcher watcher;
  watcher.on_round = [&](const RoundSummary& round) { view.Show(round); };
  watcher.on_activity = [&](const Activity& activity) { view.Show(activity); };
  watcher.on_trouble = [&](const std::string& why) { view.Say("trying again: " + why); };
  return client.Watch(job, watcher);
}

}  // namespace isolux
