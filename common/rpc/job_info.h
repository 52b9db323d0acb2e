// A job as the coordinator keeps it and the client sees it.
#pragma once

#include <cstdint>
#include <string>

#include "common/scene/scene.h"
#include "common/scene/solve_options.h"
#include "common/util/status.h"

namespace isolux {

enum class JobState { kQueued = 1, kRunning, kDone, kFailed, kCancelled };

const char* ToText(JobState state);  // "queued", "running", "done", "failed", "cancelled"
inline bool HasEnded(JobState state) { return state >= JobState::kDone; }

// What is going on between two rounds.
struct Activity {
  std::string phase;     // "waiting for workers", "refining", ...
  uint32_t round = 0;    // under way; 0 before the first
  uint32_t workers = 0;  // taking part
  double seconds = 0;    // since the start of the job

  bool operator==(const Activity&) const = default;
};

struct JobInfo {
  uint64_t id = 0;  // from 1
  std::string name;
  std::string request_id;
  JobState state = JobState::kQueued;
  Status error;         // of a job that failed
  std::string message;  // why it ended, for people
  SolveOptions options;
  std::string digest;  // of the encoded scene
  uint64_t scene_bytes = 0;
  uint64_t polygons = 0;
  RepairReport repairs;
  int64_t submitted_ms = 0, started_ms = 0, finished_ms = 0;  // Unix time; 0: not yet
  SolveSummary summary;                                       // as far as it has come
  uint64_t result_bytes = 0;
  std::string result_digest;
  Activity activity;       // while it runs
  bool finishing = false;  // somebody has asked it to finish
};

}  // namespace isolux
