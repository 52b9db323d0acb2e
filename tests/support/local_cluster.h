// A coordinator and its workers in one process: each worker a thread that serves jobs over a pair
// of queues.
#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/rpc/local_port.h"
#include "server/job.h"
#include "worker/serve.h"

namespace isolux::testing {

class LocalCluster {
 public:
  LocalCluster(int workers, int threads, const LocalPortLimits& port_limits = {});
  ~LocalCluster();  // ends the workers

  std::vector<WorkerSlot> slots() const { return slots_; }
  // Starts one more worker.
  void AddWorker();
  // Cuts the worker off, as if its process had died.
  void Kill(size_t worker);
  // Asks it to leave in order, as SIGTERM does.
  void Drain(size_t worker) { workers_[worker]->state.drain = true; }
  // Waits until its loop has ended, and gives what it ended with.
  Status Join(size_t worker);
  const WorkerState& state(size_t worker) const { return workers_[worker]->state; }

 private:
  struct Worker {
    explicit Worker(const WorkerOptions& options) : state(options) {}
    WorkerState state;
    std::unique_ptr<MessagePort> port;
    Status ended;
    std::thread thread;
  };

  WorkerOptions options_;
  LocalPortLimits port_limits_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::vector<WorkerSlot> slots_;
};

// The input of a job for this scene.
JobInput MakeJobInput(const Scene& scene, const SolveOptions& options);

// Runs a job on the cluster. `callbacks.workers` is filled in where it is empty. `traffic` (may be
// null) gets the bytes that went to and fro.
Result<SolveResult> RunJob(LocalCluster& cluster, JobInput input, JobCallbacks callbacks = {},
                           Traffic* traffic = nullptr);

// All in one.
Result<SolveResult> SolveInProcess(const Scene& scene, const SolveOptions& options, int workers,
                                   int threads);

// The patch file without its comments: what must be the same for every number of workers.
std::string BytesWithoutComments(PatchFile patch);

}  // namespace isolux::testing
