// The next threshold ε and when to stop. Pure functions of what the rounds reported, so that the
// same reports give the same thresholds.
//
// Multigridding: ε falls by a factor of up to 16 a round, by more the further the error is above
// what was asked, as the fit of the run's own rounds has it (common/scene/forecast.h). Budgets of
// links and memory are used up in steps that server/link_budget.h predicts from the errors of the
// links; a time budget keeps what the next round and the gather should take.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/shard_data.h"
#include "common/scene/solve_options.h"

namespace isolux {

struct ScheduleInput {
  SolveOptions options;
  double emitted_w = 0;                  // over the channels
  double amplification = 1;              // see AmplificationIn
  std::span<const RoundSummary> rounds;  // so far
  ErrorHistogram histogram;              // of the links as they are, over all workers
  double seconds = 0;                    // since the start of the job
  uint64_t memory_limit_bytes = 0;       // guard whatever the options say; 0: none
  bool finish = false;                   // the user asked for what there is
};

struct ScheduleDecision {
  bool stop = false;
  EndReason reason = EndReason::kAccuracy;  // when stopping
  double epsilon = 0;                       // W, of the next round
  double accuracy = 0;                      // that its solver works to
};

ScheduleDecision DecideNext(const ScheduleInput& input);

// Of a job whose rounds are over: the time that its budget leaves for the gather over what that
// should take at most; 1 where there is no such budget or nothing is left.
double TimeForGather(const ScheduleInput& input);

// About what arrives over what is emitted: 1/(1 − ρ̄) over all sides that take part, of the channel
// in which each reflects most; at most 1e6.
double AmplificationIn(const Hierarchy& hierarchy);

}  // namespace isolux
