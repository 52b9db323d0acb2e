#include "client/commands/cost.h"

#include <chrono>
#include <optional>
#include <thread>

#include "client/client.h"
#include "client/local_cluster.h"

namespace isolux {
namespace {

using Clock = std::chrono::steady_clock;

// Asked for, so that the rounds go on as those of a fine solution do.
constexpr double kFinest = 0.005;
// Rounds are enough when there are so many, or when the next would take too long.
constexpr size_t kLeastRounds = 3, kMostRounds = 6;
constexpr double kEnough_s = 4;
constexpr double kMost_s = 600;  // for the first rounds to come, waiting for other jobs included
constexpr auto kPoll = std::chrono::milliseconds(20);

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Watches the job until its rounds are enough.
Result<JobInfo> AwaitRounds(Client& client, uint64_t id) {
  const Clock::time_point start = Clock::now();
  while (SecondsSince(start) < kMost_s) {
    ASSIGN_OR_RETURN(const JobInfo job, client.Get(id));
    const size_t rounds = job.summary.rounds.size();
    const double seconds = rounds > 0 ? job.summary.rounds.back().seconds : 0;
    if (HasEnded(job.state) || rounds >= kMostRounds) return job;
    // What follows is the output.
    if (rounds >= kLeastRounds && job.summary.rounds.back().error_estimate <= kFinest) return job;
    // A round takes about four times as long as the one before.
    if (rounds >= kLeastRounds && std::max(seconds, SecondsSince(start) / 2) > kEnough_s) {
      return job;
    }
    if (rounds > 0 && SecondsSince(start) > 4 * kEnough_s) return job;
    std::this_thread::sleep_for(kPoll);
  }
  return Error(StatusCode::kDeadlineExceeded,
               "no round was done within {} s; the coordinator may be busy with other jobs (isolux "
               "jobs)",
               kMost_s);
}

Result<CostTable> Measure(Client& client, const Scene& scene, const std::string& name) {
  Client::Submission submission;
  submission.name = name;
  submission.request_id = MakeRequestId();
  submission.options.accuracy = kFinest;
  submission.polygons = scene.polygons.size();
  submission.repairs = scene.repairs;
  submission.encoded_scene = Encode(scene);
  ASSIGN_OR_RETURN(const auto submitted, client.Submit(submission));
  const Result<JobInfo> job = AwaitRounds(client, submitted.job);
  if (!job || !HasEnded(job->state)) (void)client.Cancel(submitted.job);
  if (!job) return tl::unexpected(job.error());
  if (job->state == JobState::kFailed) return tl::unexpected(job->error);
  const std::vector<RoundSummary>& rounds = job->summary.rounds;
  CostTable table;
  table.workers = std::max(job->activity.workers, job->summary.workers);
  table.rounds = static_cast<uint32_t>(rounds.size());
  table.reached = rounds.empty() ? 0 : rounds.back().error_estimate;
  for (const double accuracy : {0.2, 0.1, 0.05, 0.02, 0.01, 0.005}) {
    const std::optional<Forecast> forecast = ForecastRun(rounds, accuracy);
    if (forecast) table.forecasts.push_back(*forecast);
  }
  if (table.forecasts.empty()) {
    return Error(StatusCode::kFailedPrecondition, "{} rounds tell nothing of what finer ones cost",
                 rounds.size());
  }
  return table;
}

}  // namespace

Result<CostTable> MeasureCost(const Scene& scene, const std::string& name,
                              const CostOptions& options) {
  if (!options.server.empty()) {
    ASSIGN_OR_RETURN(const auto client, Client::Make(options.server));
    return Measure(*client, scene, name);
  }
  LocalCluster::Options cluster_options;
  cluster_options.workers = options.workers;
  ASSIGN_OR_RETURN(const auto cluster, LocalCluster::Start(cluster_options));
  return Measure(cluster->client(), scene, name);
}

}  // namespace isolux
