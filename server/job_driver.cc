#include "server/job_driver.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "common/util/log.h"
#include "server/latest.h"

namespace isolux {
namespace {

// Runs in a row that lost every worker without finishing a round: then the job itself is what kills
// them.
constexpr int kMaxFruitlessRuns = 5;
constexpr double kPollS = 0.2;

Status Cancelled() { return MakeStatus(StatusCode::kCancelled, "cancelled"); }

}  // namespace

Result<JobInput> JobDriver::Load(const JobInfo& job) const {
  JobInput input;
  input.job = job.id;
  input.name = job.name;
  input.scene_hash = job.digest;
  input.options = job.options;
  ASSIGN_OR_RETURN(auto encoded, store_->ReadScene(job.digest));
  if (HashOf(encoded) != job.digest) {
    return Error(StatusCode::kDataLoss,
                 "its scene was damaged on the coordinator's disk: submit "
                 "it again");
  }
  ASSIGN_OR_RETURN(auto scene, Decode(encoded));
  scene.repairs = job.repairs;  // which the encoded scene leaves out
  input.scene = std::make_shared<const Scene>(std::move(scene));
  input.encoded_scene = std::make_shared<const std::string>(std::move(encoded));

  ASSIGN_OR_RETURN(const auto snapshots, store_->LoadSnapshots(job.id));
  const size_t rounds = std::min(snapshots.size(), job.summary.rounds.size());
  for (size_t i = 0; i < rounds; ++i) {
    Result<Snapshot> snapshot = DecodeSnapshot(snapshots[i]);
    if (!snapshot) {
      LogWarn("snapshot {} is damaged ({}): it goes on from the one before", i + 1,
              snapshot.error().message());
      break;
    }
    input.snapshots.push_back(std::move(*snapshot));
    input.rounds.push_back(job.summary.rounds[i]);
  }
  if (!input.rounds.empty()) input.seconds_before = input.rounds.back().seconds;
  return input;
}

Result<std::string> JobDriver::Latest(const JobInfo& job) const {
  if (job.summary.rounds.empty()) {
    return Error(StatusCode::kFailedPrecondition,
                 "job {} is {}: its first round is not done yet, try again in a while", job.id,
                 ToText(job.state));
  }
  ASSIGN_OR_RETURN(const std::string encoded, store_->ReadScene(job.digest));
  ASSIGN_OR_RETURN(const Scene scene, Decode(encoded));
  ASSIGN_OR_RETURN(const std::string bytes,
                   store_->LoadSnapshot(job.id, job.summary.rounds.back().round));
  ASSIGN_OR_RETURN(const Snapshot snapshot, DecodeSnapshot(bytes));
  ASSIGN_OR_RETURN(const PatchFile patch, BuildLatest(scene, snapshot, job));
  return Encode(patch);
}

JobCallbacks JobDriver::CallbacksFor(const JobInfo& job, const JobHooks& hooks) {
  JobCallbacks callbacks;
  callbacks.workers = [this] {
    std::vector<WorkerSlot> slots;
    for (ConnectedWorker& worker : sessions_->Connected()) {
      slots.push_back({worker.id, std::move(worker.name), std::move(worker.port)});
    }
    return slots;
  };
  callbacks.next_epoch = [this] { return ++epoch_; };
  callbacks.on_round = hooks.on_round;
  callbacks.on_progress = [&hooks](const JobProgress& progress) {
    hooks.on_activity({ToText(progress), progress.round, progress.workers, progress.seconds});
  };
  callbacks.on_snapshot = [this, id = job.id](const Snapshot& snapshot) {
    return store_->SaveSnapshot(id, snapshot.round, Encode(snapshot));
  };
  callbacks.on_lost = [this](const WorkerSlot& worker, const Status& why) {
    LogWarn("worker '{}' ({}) is lost: {}", worker.name, worker.id, why.message());
    sessions_->Drop(worker.id, why);
  };
  callbacks.on_released = [this](const WorkerSlot& worker) {
    LogInfo("worker '{}' ({}) has handed over its work", worker.name, worker.id);
    sessions_->Release(worker.id);
  };
  callbacks.cancelled = hooks.cancelled;
  callbacks.finish = hooks.finish;
  return callbacks;
}

Result<JobOutcome> JobDriver::Run(const JobInfo& job, const JobHooks& hooks) {
  const auto start = std::chrono::steady_clock::now();
  ASSIGN_OR_RETURN(auto input, Load(job));
  input.seconds_before +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  JobHooks counting = hooks;
  int fruitless = 0;
  counting.on_round = [&](const RoundSummary& round) {
    fruitless = 0;
    hooks.on_round(round);
  };
  JobRunner runner(std::move(input), CallbacksFor(job, counting), limits_);
  while (true) {
    while (!sessions_->WaitForWorker(kPollS)) {
      if (hooks.cancelled()) return tl::unexpected<Status>(Cancelled());
      hooks.on_activity({"waiting for workers", 0, 0, 0});
    }
    if (hooks.cancelled()) return tl::unexpected<Status>(Cancelled());
    Result<SolveResult> result = runner.Run();
    if (result) return JobOutcome{Encode(result->patch), std::move(result->summary)};
    if (result.error().code() != StatusCode::kUnavailable || hooks.cancelled()) {
      return tl::unexpected<Status>(result.error());
    }
    if (++fruitless == kMaxFruitlessRuns) {
      return Error(StatusCode::kAborted, "all workers were lost {} times in one round: {}",
                   fruitless, result.error().message());
    }
    LogWarn("no worker is left: {}", result.error().message());
  }
}

}  // namespace isolux
