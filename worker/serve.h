// The worker's command loop: what the coordinator says over a MessagePort, done by a Shard. Without
// gRPC: a session over the network is one port, a queue in the same process another.
//
// Threads: the caller's runs the shard, a reader takes messages from the port (so that CancelJob
// and a newer epoch are noticed in the midst of work), a third says Progress while there is a job.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "common/rpc/message_port.h"
#include "common/scene/scene.h"
#include "common/util/parallel.h"
#include "common/util/status.h"
#include "worker/scene_cache.h"

namespace isolux {

struct WorkerOptions {
  int threads = 0;                          // 0: one a core
  uint64_t scene_cache_bytes = 1ULL << 30;  // encoded size of the scenes kept
  double heartbeat_s = 2;                   // between two Progress messages during a job
  double reply_limit_s = 4 * 3600;          // longest wait for the others in a collective
  SceneLimits scene_limits;
};

// What outlives one connection to the coordinator.
struct WorkerState {
  explicit WorkerState(const WorkerOptions& options)
      : pool(options.threads), scenes(options.scene_cache_bytes) {}

  ThreadPool pool;
  SceneCache scenes;
  std::atomic<bool> drain{false};           // set (by a signal handler, say) to leave in order
  std::atomic<uint64_t> stale_messages{0};  // of an old epoch, dropped
  std::atomic<uint64_t> jobs{0};            // started
};

// Serves jobs until the worker is drained (OK: between jobs at once, in a job when the coordinator
// releases it) or the port fails (its Status; the caller connects again and calls again). Closes
// the port in either case. What goes wrong in a job is told to the coordinator and ends only the
// job.
Status ServeJobs(MessagePort& port, const WorkerOptions& options, WorkerState& state);

}  // namespace isolux
