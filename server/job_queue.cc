#include "server/job_queue.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/rpc/convert_options.h"
#include "common/util/log.h"

namespace isolux {
namespace {

constexpr size_t kMaxNameBytes = 128;

int64_t NowMs() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

bool SameOptions(const SolveOptions& a, const SolveOptions& b) {
  return ToProto(a).SerializeAsString() == ToProto(b).SerializeAsString();
}

Status Stopping() {
  return MakeStatus(StatusCode::kUnavailable,
                    "the coordinator is stopping: try again when it is back");
}

Status NoSuchJob(uint64_t job) {
  return MakeStatus(StatusCode::kNotFound,
                    "there is no job {}: `isolux jobs` lists those there are", job);
}

}  // namespace

Status Validate(const JobRequest& request) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  const std::string& id = request.request_id;
  if (id.empty() || id.size() > kMaxNameBytes || !std::all_of(id.begin(), id.end(), allowed)) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "a request id has 1 to {} characters of A-Z a-z 0-9 . _ -", kMaxNameBytes);
  }
  if (request.name.size() > kMaxNameBytes) {
    return MakeStatus(StatusCode::kInvalidArgument, "the name of a job has at most {} bytes",
                      kMaxNameBytes);
  }
  const auto is_hex = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (request.digest.size() != 32 ||
      !std::all_of(request.digest.begin(), request.digest.end(), is_hex)) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "the digest of a scene has 32 hexadecimal digits");
  }
  return request.options.Validate();
}

Result<JobEvent> JobWatch::Next() { return queue_->NextEvent(*this); }

void JobWatch::Close() {
  std::lock_guard lock(mutex_);
  on_news_ = nullptr;
}

void JobWatch::Notify() {
  std::lock_guard lock(mutex_);
  if (on_news_) on_news_();
}

JobQueue::JobQueue(Store* store, RunJob run, Limits limits)
    : store_(store), run_(std::move(run)), limits_(limits) {}

JobQueue::~JobQueue() { Stop(); }

Status JobQueue::Start() {
  ASSIGN_OR_RETURN(auto jobs, store_->LoadJobs());
  for (JobInfo& job : jobs) {
    if (!HasEnded(job.state)) {
      job.state = JobState::kQueued;
      LogInfo("job {} ('{}') had not ended: queued again after round {}", job.id, job.name,
              job.summary.rounds.size());
    }
    const uint64_t id = job.id;
    std::lock_guard lock(mutex_);
    by_request_[job.request_id] = id;
    jobs_[id].info = std::move(job);
  }
  runner_ = std::thread([this] { RunJobs(); });
  return {};
}

void JobQueue::Stop() {
  std::vector<std::shared_ptr<JobWatch>> watches;
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
    for (auto& [id, entry] : jobs_) {
      for (const auto& watch : entry.watches) {
        if (auto live = watch.lock()) watches.push_back(std::move(live));
      }
    }
  }
  changed_.notify_all();
  for (const auto& watch : watches) watch->Notify();
  if (runner_.joinable()) runner_.join();
}

Result<std::optional<uint64_t>> JobQueue::FindRequest(const JobRequest& request) const {
  const auto found = by_request_.find(request.request_id);
  if (found == by_request_.end()) return std::optional<uint64_t>();
  const JobInfo& job = jobs_.at(found->second).info;
  if (job.digest == request.digest && SameOptions(job.options, request.options)) {
    return std::optional<uint64_t>(job.id);
  }
  return Error(StatusCode::kAlreadyExists,
               "request id '{}' belongs to job {}, which has {}: use a new request id",
               request.request_id, job.id,
               job.digest == request.digest ? "other options" : "another scene");
}

Result<std::optional<uint64_t>> JobQueue::BeginUpload(const JobRequest& request) {
  RETURN_IF_ERROR(Validate(request));
  const auto too_much = [](const char* what, uint64_t value, uint64_t limit) {
    return Error(StatusCode::kResourceExhausted,
                 "the scene has {} {}; the limit of this coordinator is {}", value, what, limit);
  };
  const SceneLimits& scene = limits_.scene;
  if (request.total_bytes > scene.bytes) return too_much("bytes", request.total_bytes, scene.bytes);
  if (request.polygons > scene.polygons) {
    return too_much("polygons", request.polygons, scene.polygons);
  }
  const uint64_t free_bytes = store_->FreeBytes();
  std::lock_guard lock(mutex_);
  if (stopping_) return tl::unexpected<Status>(Stopping());
  ASSIGN_OR_RETURN(auto existing, FindRequest(request));
  if (existing) return existing;
  uint32_t unfinished = 0;
  for (const auto& [id, entry] : jobs_) unfinished += HasEnded(entry.info.state) ? 0 : 1;
  if (unfinished + uploads_ >= limits_.unfinished_jobs) {
    return Error(StatusCode::kResourceExhausted,
                 "{} jobs are queued, the limit: wait for one to end, or cancel one", unfinished);
  }
  if (uploads_ >= limits_.uploads) {
    return Error(StatusCode::kResourceExhausted,
                 "{} uploads are under way, the limit: try again later", uploads_);
  }
  if (free_bytes < request.total_bytes + limits_.spare_disk_bytes) {
    return Error(StatusCode::kResourceExhausted,
                 "the coordinator has {} bytes of disk left, too little for the scene's {}",
                 free_bytes, request.total_bytes);
  }
  ++uploads_;
  return std::optional<uint64_t>();
}

void JobQueue::EndUpload() {
  std::lock_guard lock(mutex_);
  --uploads_;
}

Result<JobQueue::Submitted> JobQueue::Submit(const JobRequest& request) {
  std::lock_guard submit_lock(submit_mutex_);
  JobInfo job;
  {
    std::lock_guard lock(mutex_);
    if (stopping_) return tl::unexpected<Status>(Stopping());
    ASSIGN_OR_RETURN(auto existing, FindRequest(request));
    if (existing) return Submitted{*existing, true};
    job.id = jobs_.empty() ? 1 : jobs_.rbegin()->first + 1;
  }
  job.name = request.name;
  job.request_id = request.request_id;
  job.options = request.options;
  job.digest = request.digest;
  job.scene_bytes = request.total_bytes;
  job.polygons = request.polygons;
  job.repairs = request.repairs;
  job.submitted_ms = NowMs();
  RETURN_IF_ERROR(store_->SaveJob(job));
  LogInfo("job {} ('{}') queued: {} polygons, accuracy {}", job.id, job.name, job.polygons,
          job.options.accuracy);
  const uint64_t id = job.id;
  {
    std::lock_guard lock(mutex_);
    by_request_[job.request_id] = id;
    jobs_[id].info = std::move(job);
  }
  changed_.notify_all();
  return Submitted{id, false};
}

Result<JobInfo> JobQueue::Get(uint64_t job) const {
  std::lock_guard lock(mutex_);
  const auto entry = jobs_.find(job);
  if (entry == jobs_.end()) return tl::unexpected<Status>(NoSuchJob(job));
  return entry->second.info;
}

std::vector<JobInfo> JobQueue::List(uint32_t limit, uint64_t before) const {
  std::lock_guard lock(mutex_);
  std::vector<JobInfo> jobs;
  auto entry = before == 0 ? jobs_.end() : jobs_.lower_bound(before);
  while (entry != jobs_.begin() && jobs.size() < limit) jobs.push_back((--entry)->second.info);
  return jobs;
}

Result<JobState> JobQueue::Cancel(uint64_t job) {
  // Keeps the runner from taking it up meanwhile.
  bool was_queued = false;
  JobState state;
  {
    std::lock_guard lock(mutex_);
    const auto entry = jobs_.find(job);
    if (entry == jobs_.end()) return tl::unexpected<Status>(NoSuchJob(job));
    state = entry->second.info.state;
    if (HasEnded(state)) return state;
    entry->second.cancel_requested = true;
    was_queued = state == JobState::kQueued;
    if (was_queued) entry->second.info.state = JobState::kCancelled;
  }
  LogInfo("job {} is to be cancelled", job);
  if (!was_queued) return state;
  RETURN_IF_ERROR(Update(
      job,
      [](Entry& entry) {
        entry.info.message = "cancelled before it began";
        entry.info.finished_ms = NowMs();
      },
      /*durable=*/true));
  store_->DropSnapshots(job);
  return JobState::kCancelled;
}

Result<JobState> JobQueue::Finish(uint64_t job) {
  {
    std::lock_guard lock(mutex_);
    const auto entry = jobs_.find(job);
    if (entry == jobs_.end()) return tl::unexpected<Status>(NoSuchJob(job));
    const JobInfo& info = entry->second.info;
    if (HasEnded(info.state) || info.finishing) return info.state;
    if (info.state == JobState::kQueued && info.summary.rounds.empty()) {
      return Error(StatusCode::kFailedPrecondition,
                   "job {} is queued: there is nothing of it yet; `isolux cancel {}` takes it away",
                   job, job);
    }
  }
  LogInfo("job {} is to finish", job);
  JobState state{};
  RETURN_IF_ERROR(Update(
      job,
      [&](Entry& entry) {
        entry.info.finishing = true;
        state = entry.info.state;
      },
      /*durable=*/true));
  return state;
}

Result<std::shared_ptr<JobWatch>> JobQueue::Watch(uint64_t job, uint64_t after_sequence,
                                                  std::function<void()> on_news) {
  std::lock_guard lock(mutex_);
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) return tl::unexpected<Status>(NoSuchJob(job));
  if (stopping_) return tl::unexpected<Status>(Stopping());
  Entry& entry = found->second;
  std::erase_if(entry.watches, [](const auto& watch) { return watch.expired(); });
  if (entry.watches.size() >= limits_.watches) {
    return Error(StatusCode::kResourceExhausted, "job {} is watched by {}, the limit", job,
                 entry.watches.size());
  }
  std::shared_ptr<JobWatch> watch(new JobWatch(this, job, std::move(on_news)));
  watch->rounds_told_ = std::min<uint64_t>(after_sequence, entry.info.summary.rounds.size());
  entry.watches.push_back(watch);
  return watch;
}

Result<JobEvent> JobQueue::NextEvent(JobWatch& watch) {
  std::lock_guard lock(mutex_);
  const Entry& entry = jobs_.at(watch.job_);
  const std::vector<RoundSummary>& rounds = entry.info.summary.rounds;
  JobEvent event;
  event.sequence = watch.rounds_told_;
  if (watch.rounds_told_ < rounds.size()) {
    event.kind = JobEvent::Kind::kRound;
    event.round = rounds[watch.rounds_told_];
    event.sequence = ++watch.rounds_told_;
  } else if (HasEnded(entry.info.state)) {
    // An ended job is told as such once what is kept of it is complete.
    if (watch.end_told_ || entry.info.finished_ms == 0) return event;
    watch.end_told_ = true;
    event.kind = JobEvent::Kind::kEnd;
    event.job = entry.info;
    ++event.sequence;
  } else if (stopping_) {
    return tl::unexpected<Status>(Stopping());
  } else if (watch.activity_told_ < entry.activity_version) {
    watch.activity_told_ = entry.activity_version;
    event.kind = JobEvent::Kind::kActivity;
    event.activity = entry.info.activity;
  }
  return event;
}

Status JobQueue::Update(uint64_t job, const std::function<void(Entry&)>& change, bool durable) {
  JobInfo info;
  std::vector<std::shared_ptr<JobWatch>> watches;
  {
    std::lock_guard lock(mutex_);
    Entry& entry = jobs_.at(job);
    change(entry);
    if (durable) info = entry.info;
    for (const auto& watch : entry.watches) {
      if (auto live = watch.lock()) watches.push_back(std::move(live));
    }
  }
  Status status = durable ? store_->SaveJob(info) : Status();
  for (const auto& watch : watches) watch->Notify();
  return status;
}

void JobQueue::RunJobs() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto next = std::find_if(jobs_.begin(), jobs_.end(), [](const auto& entry) {
      return entry.second.info.state == JobState::kQueued;
    });
    if (next == jobs_.end()) {
      changed_.wait(lock);
      continue;
    }
    const uint64_t job = next->first;
    next->second.info.state = JobState::kRunning;
    lock.unlock();
    RunOne(job);
    lock.lock();
  }
}

void JobQueue::RunOne(uint64_t job) {
  const LogContext context("job " + std::to_string(job));
  const Status stored = Update(
      job,
      [](Entry& entry) {
        if (entry.info.started_ms == 0) entry.info.started_ms = NowMs();
        ++entry.activity_version;
      },
      /*durable=*/true);
  if (!stored.ok()) return EndJob(job, tl::unexpected<Status>(stored));
  const Result<JobInfo> info = Get(job);
  LogInfo("started");
  Result<JobOutcome> outcome = run_(*info, HooksFor(job));
  bool stopped;
  {
    std::lock_guard lock(mutex_);
    const Entry& entry = jobs_.at(job);
    stopped = stopping_ && !entry.cancel_requested && !outcome.has_value();
  }
  if (stopped) {
    LogInfo("stopped; it goes on when the coordinator is back");
    return;
  }
  EndJob(job, std::move(outcome));
}

JobHooks JobQueue::HooksFor(uint64_t job) {
  JobHooks hooks;
  hooks.on_round = [this, job](const RoundSummary& round) {
    const Status stored = Update(
        job,
        [&](Entry& entry) {
          // A run that had to go further back than the last one tells its rounds again.
          std::vector<RoundSummary>& rounds = entry.info.summary.rounds;
          std::erase_if(rounds, [&](const RoundSummary& old) { return old.round >= round.round; });
          rounds.push_back(round);
        },
        /*durable=*/true);
    if (!stored.ok()) LogWarn("round {} is not stored: {}", round.round, stored.message());
    LogInfo("round {}: error {:.4g}, {} links, {} elements, residual {:.3g}, {:.1f} s", round.round,
            round.error_estimate, round.links, round.elements, round.residual, round.seconds);
  };
  hooks.on_activity = [this, job](const Activity& activity) {
    (void)Update(
        job,
        [&](Entry& entry) {
          if (entry.info.activity == activity) return;
          entry.info.activity = activity;
          ++entry.activity_version;
        },
        /*durable=*/false);
  };
  hooks.cancelled = [this, job] {
    std::lock_guard lock(mutex_);
    return stopping_ || jobs_.at(job).cancel_requested;
  };
  hooks.finish = [this, job] {
    std::lock_guard lock(mutex_);
    return jobs_.at(job).info.finishing;
  };
  return hooks;
}

void JobQueue::EndJob(uint64_t job, Result<JobOutcome> outcome) {
  Status error;
  std::string digest;
  if (outcome) {
    error = store_->SaveResult(job, outcome->result);
    Digest of_result;
    of_result.Add(outcome->result);
    digest = of_result.Finish();
  } else {
    error = outcome.error();
  }
  const Status stored = Update(
      job,
      [&](Entry& entry) {
        JobInfo& info = entry.info;
        info.finished_ms = NowMs();
        if (error.ok()) {
          info.state = JobState::kDone;
          info.summary = outcome->summary;
          info.message = ToText(info.summary.end_reason);
          info.result_bytes = outcome->result.size();
          info.result_digest = digest;
          return;
        }
        const bool cancelled = entry.cancel_requested && error.code() == StatusCode::kCancelled;
        info.state = cancelled ? JobState::kCancelled : JobState::kFailed;
        if (cancelled) {
          info.message = "cancelled";
        } else {
          info.error = error;
        }
      },
      /*durable=*/true);
  if (!stored.ok()) LogError("its end is not stored: {}", stored.message());
  store_->DropSnapshots(job);
  const Result<JobInfo> info = Get(job);
  LogInfo("{}: {}", ToText(info->state), info->error.ok() ? info->message : error.message());
}

}  // namespace isolux
