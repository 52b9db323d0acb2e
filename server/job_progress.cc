#include "server/job_progress.h"

namespace isolux {

const char* ToText(JobProgress::Stage stage) {
  switch (stage) {
    case JobProgress::Stage::kStarting:
      return "starting";
    case JobProgress::Stage::kRefining:
      return "refining";
    case JobProgress::Stage::kSolving:
      return "solving";
    case JobProgress::Stage::kSnapshot:
      return "snapshot";
    case JobProgress::Stage::kBalancing:
      return "balancing";
    case JobProgress::Stage::kReplaying:
      return "replaying";
    case JobProgress::Stage::kGathering:
      return "gathering";
  }
  return "unknown";
}

}  // namespace isolux
