// The next threshold ε and when to stop. Pure functions of what the rounds reported, so that the
// same reports give the same thresholds.
//
// The error of the output falls about like ε^0.3, the number of links grows about like ε^-0.75
// (both measured on rooms with and without furniture). Multigridding: ε falls by a factor of 2 to
// 16 a round, by more the further the error is above what was asked.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/hierarchy/shard_data.h"
#include "common/scene/solve_options.h"

namespace isolux {

struct ScheduleInput {
  SolveOptions options;
  double emitted_w = 0;                  // over the channels
  std::span<const RoundSummary> rounds;  // so far
  ErrorHistogram histogram;              // of the last round's links, over all workers
  bool has_histogram = false;            // not after a restart of the coordinator
  double seconds = 0;                    // since the start of the job
  uint64_t memory_limit_bytes = 0;       // guard whatever the options say; 0: none
  uint32_t workers = 1;
  bool finish = false;  // the user asked for what there is
};

struct ScheduleDecision {
  bool stop = false;
  EndReason reason = EndReason::kAccuracy;  // when stopping
  double epsilon = 0;                       // W, of the next round
  double accuracy = 0;                      // that its solver works to
};

ScheduleDecision DecideNext(const ScheduleInput& input);

// Links that are to be expected at `epsilon`, where every link of larger error is divided: one
// becomes kChildrenPerSplit for each halving of its error. Errs on the side of too many.
inline constexpr double kChildrenPerSplit = 2.2;
double PredictLinks(const ErrorHistogram& histogram, double epsilon);

// Seconds that gathering the output of so many elements should take.
double PredictGatherSeconds(uint64_t elements, uint32_t workers);

}  // namespace isolux
