// The jobs of a coordinator: handed in, queued, run one after another (each uses all workers),
// ended, kept. Tells those who watch. Survives a restart through the store: what had not ended is
// queued again and goes on from its last snapshot.
//
//   queued ──▶ running ──▶ done | failed | cancelled          queued ──▶ cancelled
//
// May be called from any thread. Get, List, Watch and JobWatch::Next never wait for the disk; the
// others may. How a job is solved is not known here: it is a function given at the start.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/rpc/job_info.h"
#include "common/util/status.h"
#include "server/store.h"

namespace isolux {

struct JobRequest {
  std::string request_id;
  std::string name;
  SolveOptions options;
  uint64_t total_bytes = 0;  // of the encoded scene
  std::string digest;        // of the encoded scene
  uint64_t polygons = 0;
  RepairReport repairs;
};

// What a running job tells, and asks.
struct JobHooks {
  std::function<void(const RoundSummary&)> on_round;
  std::function<void(const Activity&)> on_activity;
  std::function<bool()> cancelled;  // by somebody, or because the coordinator is stopping
  std::function<bool()> finish;     // somebody wants what there is
};

struct JobOutcome {
  std::string result;  // the patch file
  SolveSummary summary;
};

// Solves a job to its end, on the queue's own thread. `job` holds the rounds of an earlier run.
using RunJob = std::function<Result<JobOutcome>(const JobInfo& job, const JobHooks& hooks)>;

struct JobEvent {
  enum class Kind { kNone, kRound, kActivity, kEnd };
  Kind kind = Kind::kNone;  // none: nothing yet
  uint64_t sequence = 0;    // rounds from 1, then the end; that of the event before for an activity
  RoundSummary round;
  Activity activity;
  JobInfo job;  // at the end
};

class JobQueue;

// The events of one job, one after another; made by JobQueue::Watch.
class JobWatch {
 public:
  // The next event; where there is none yet, `on_news` will be called. kUnavailable once the
  // coordinator is stopping. After the job's end there is nothing more.
  Result<JobEvent> Next();
  // `on_news` is not called any more once this has returned.
  void Close();

 private:
  friend class JobQueue;
  JobWatch(JobQueue* queue, uint64_t job, std::function<void()> on_news)
      : queue_(queue), job_(job), on_news_(std::move(on_news)) {}
  void Notify();

  JobQueue* const queue_;
  const uint64_t job_;
  std::mutex mutex_;
  std::function<void()> on_news_;  // guarded by mutex_
  // Guarded by the queue's mutex.
  uint64_t rounds_told_ = 0;
  uint64_t activity_told_ = 0;
  bool end_told_ = false;
};

class JobQueue {
 public:
  struct Limits {
    uint32_t unfinished_jobs = 100;
    uint32_t uploads = 8;  // at the same time
    uint32_t watches = 256;
    uint64_t spare_disk_bytes = 64ULL << 20;  // left free by an upload
    SceneLimits scene;
  };

  JobQueue(Store* store, RunJob run, Limits limits);
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  // Takes up the store's jobs and starts to run those that have not ended. Before all else.
  Status Start();
  // Stops the job that runs (it is queued again at the next start) and tells those who watch.
  void Stop();

  // Before an upload: the number of the job that exists already for this request, or none: then
  // the limits allow it, and a slot is taken until EndUpload.
  Result<std::optional<uint64_t>> BeginUpload(const JobRequest& request);
  void EndUpload();
  // Queues a job whose scene is in the store.
  struct Submitted {
    uint64_t job = 0;
    bool existing = false;
  };
  Result<Submitted> Submit(const JobRequest& request);

  Result<JobInfo> Get(uint64_t job) const;
  // Newest first, those with numbers below `before` (0: all), at most `limit`.
  std::vector<JobInfo> List(uint32_t limit, uint64_t before) const;
  // The state after the call.
  Result<JobState> Cancel(uint64_t job);
  // Lets a job that runs (or has rounds and will run again) end with its next round. The state
  // after the call; kFailedPrecondition where it has nothing yet and waits for others.
  Result<JobState> Finish(uint64_t job);
  // Events after the first `after_sequence`. `on_news` must not wait; it is called from any thread.
  Result<std::shared_ptr<JobWatch>> Watch(uint64_t job, uint64_t after_sequence,
                                          std::function<void()> on_news);

  const Limits& limits() const { return limits_; }

 private:
  friend class JobWatch;
  struct Entry {
    JobInfo info;
    bool cancel_requested = false;
    uint64_t activity_version = 0;
    std::vector<std::weak_ptr<JobWatch>> watches;
  };

  Result<std::optional<uint64_t>> FindRequest(const JobRequest& request) const;  // needs mutex_
  void RunJobs();                                                                // own thread
  void RunOne(uint64_t job);
  void EndJob(uint64_t job, Result<JobOutcome> outcome);
  JobHooks HooksFor(uint64_t job);
  // Changes a job, tells those who watch, and stores it where `durable`.
  Status Update(uint64_t job, const std::function<void(Entry&)>& change, bool durable);
  Result<JobEvent> NextEvent(JobWatch& watch);

  Store* const store_;
  const RunJob run_;
  const Limits limits_;

  std::mutex submit_mutex_;  // held while a job is stored; taken before mutex_
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by mutex_.
  std::map<uint64_t, Entry> jobs_;
  std::map<std::string, uint64_t> by_request_;
  uint32_t uploads_ = 0;
  uint32_t watches_ = 0;
  bool stopping_ = false;

  std::thread runner_;
};

// Of the request's own parts; the queue's limits are another matter.
Status Validate(const JobRequest& request);

}  // namespace isolux
