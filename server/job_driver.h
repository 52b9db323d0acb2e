// Runs a job of the queue on the workers that are connected: brings the scene and the snapshots of
// an earlier run from the store, waits for workers where there are none, hands all to JobRunner,
// and stores what it makes on the way.
#pragma once

#include <atomic>
#include <cstdint>

#include "server/job.h"
#include "server/job_queue.h"
#include "server/store.h"
#include "server/worker_sessions.h"

namespace isolux {

class JobDriver {
 public:
  JobDriver(Store* store, WorkerSessions* sessions, JobLimits limits)
      : store_(store), sessions_(sessions), limits_(limits) {}

  // A RunJob of the queue.
  Result<JobOutcome> Run(const JobInfo& job, const JobHooks& hooks);

  // The patch file of the newest snapshot of a job that has rounds and has not ended: see
  // server/latest.h. May be called from any thread.
  Result<std::string> Latest(const JobInfo& job) const;

 private:
  Result<JobInput> Load(const JobInfo& job) const;
  JobCallbacks CallbacksFor(const JobInfo& job, const JobHooks& hooks);

  Store* const store_;
  WorkerSessions* const sessions_;
  const JobLimits limits_;
  std::atomic<uint32_t> epoch_{0};
};

}  // namespace isolux
