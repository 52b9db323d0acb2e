// One job from scene to patch file: starts it on the workers, drives the rounds, relays what the
// workers tell each other, merges, balances, gathers, and starts again without a worker that is
// lost. Knows ports, not the network; the coordinator's service and the tests drive it alike.
//
// One thread calls Run(); the callbacks are called by that thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/hierarchy/snapshot.h"
#include "common/rpc/message_port.h"
#include "common/scene/patch_file.h"
#include "common/scene/scene.h"
#include "common/scene/solve_options.h"
#include "common/util/status.h"
#include "server/job_progress.h"
#include "server/output_mesh.h"
#include "server/traffic.h"

namespace isolux {

// A live worker. Nobody else receives from its port while the job runs.
struct WorkerSlot {
  uint64_t id = 0;   // of the connection: a worker that comes back has another
  std::string name;  // for messages
  std::shared_ptr<MessagePort> port;
};

struct JobInput {
  uint64_t job = 0;
  std::string name;                                  // for people: of the scene's file
  std::shared_ptr<const Scene> scene;                // validated
  std::shared_ptr<const std::string> encoded_scene;  // what workers fetch
  std::string scene_hash;
  SolveOptions options;
  // To resume: snapshots S_1 … S_k and what their rounds reported, as the callbacks gave them.
  std::vector<Snapshot> snapshots;
  std::vector<RoundSummary> rounds;
  double seconds_before = 0;  // spent before; counts against max_seconds
};

struct JobLimits {
  double lease_s = 10;              // without a sign of life after which a worker counts as lost
  double step_limit_s = 4 * 3600;   // longest wait for one answer of a living worker
  double start_lease_s = 120;       // lease while it builds the scene
  uint64_t memory_share_bytes = 0;  // of links and nodes; guards whatever the options say; 0:
                                    // derived from the machine's memory
  uint32_t gather_batch = 65536;    // elements asked for at once
  OutputMeshOptions output;         // its accuracy is taken from the job
};

// All but `workers` and `next_epoch` may be empty.
struct JobCallbacks {
  // Workers alive now; asked at the start and after a loss. Lost ones may still be among them.
  std::function<std::vector<WorkerSlot>()> workers;
  // A number greater than any given before to any job: the epoch of a membership.
  std::function<uint32_t()> next_epoch;
  // The last round is told again where the gather of the sources has found more error.
  std::function<void(const RoundSummary&)> on_round;
  std::function<void(const JobProgress&)> on_progress;
  // To store; an error fails the job. Called before on_round of the same round.
  std::function<Status(const Snapshot&)> on_snapshot;
  // A worker that counts as lost (its connection should be ended), and one that drained and was
  // released.
  std::function<void(const WorkerSlot&, const Status& why)> on_lost;
  std::function<void(const WorkerSlot&)> on_released;
  std::function<bool()> cancelled;  // ends the job with kCancelled
  std::function<bool()> finish;     // ends the rounds and gathers what there is
};

struct SolveResult {
  PatchFile patch;
  SolveSummary summary;
};

class JobRunner {
 public:
  JobRunner(JobInput input, JobCallbacks callbacks, JobLimits limits = {});
  ~JobRunner();
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;

  // kUnavailable when no worker is left: call again once there are some, it goes on from the last
  // snapshot. Any other error is final.
  Result<SolveResult> Run();

  // Payload bytes per worker and phase, and counts for tests and the report.
  const Traffic& traffic() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isolux
