// What a job that runs tells between its rounds.
#pragma once

#include <cstdint>
#include <string>

namespace isolux {

// Finer news between rounds.
struct JobProgress {
  enum class Stage {
    kStarting,
    kRefining,
    kSolving,
    kSnapshot,
    kBalancing,
    kReplaying,
    kGathering,
    kBands
  };
  Stage stage = Stage::kStarting;
  uint32_t round = 0;       // from 1
  uint32_t iterations = 0;  // matrix products of this round so far
  double epsilon = 0;       // W
  double seconds = 0;       // since the start of the job
  uint64_t gathered = 0;    // output elements so far
  uint32_t group = 0;       // of spectral bands, from 1; 0: none yet
  uint32_t groups = 0;
  uint32_t workers = 0;
};
const char* ToText(JobProgress::Stage stage);
std::string ToText(const JobProgress& progress);  // "refining", "bands, group 2 of 4"

}  // namespace isolux
