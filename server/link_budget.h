// How many links a threshold makes, from the errors of the links that there are: this chooses the
// thresholds of runs with a budget of links or memory. Pure functions.
//
// Links within ε stay. One whose error is r times ε becomes κ r^q: κ is measured in every round
// (links_per_split), q is the run's own law, links ~ ε^-q. The smaller the steps, the more κ alone
// decides and the better it is known, so a budget is approached in steps that leave room for what
// is uncertain.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/hierarchy/shard_data.h"
#include "common/scene/solve_options.h"

namespace isolux {

// Links at `epsilon` (W), for κ and q as above.
double PredictLinks(const ErrorHistogram& histogram, double epsilon, double links_per_split,
                    double power);

// κ of a round: links with errors `before` were refined to `epsilon` and became `links`. 0 where no
// link was divided.
double MeasureLinksPerSplit(const ErrorHistogram& before, double epsilon, uint64_t links,
                            double power);

// What is used of something that grows with the links, and how much of it there is.
struct Budget {
  double used = 0, limit = 0;
  double per_link = 1;  // what one more link takes
};
inline constexpr double kBudgetUsed = 0.9;  // share of the limit at which a budget counts as used

// The smallest threshold, not below `wanted`, that should keep within the budget; nothing where it
// is used, or where the last step has hardly used more of it. `histogram`: of the links as they
// are; at least one round.
std::optional<double> StepWithin(const Budget& budget, const ErrorHistogram& histogram,
                                 std::span<const RoundSummary> rounds, double wanted, double power);

}  // namespace isolux
