#include "server/job_progress.h"

#include "common/util/status.h"

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
    case JobProgress::Stage::kBands:
      return "bands";
  }
  return "unknown";
}

std::string ToText(const JobProgress& progress) {
  if (progress.group == 0) return ToText(progress.stage);
  return fmt::format("{}, group {} of {}", ToText(progress.stage), progress.group, progress.groups);
}

}  // namespace isolux
