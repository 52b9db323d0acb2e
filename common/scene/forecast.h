// What a run will cost, from what its rounds have cost so far: pure functions of the rounds, for
// the schedule, the progress line and whoever wants to know what an accuracy costs.
//
// Over the threshold ε everything is nearly a power law: error ~ ε^p, links ~ ε^-q, elements,
// memory, and the seconds that gathering the output takes (of which every round measures a sample).
// Each law is a line through the logarithms by weighted least squares, the newest rounds counting
// most, drawn towards the slopes of measured scenes; its uncertainty is that of the line. The
// seconds of a round follow from its links at the rate of the rounds before.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/scene/solve_options.h"

namespace isolux {

// Likely value, and the ends between which four of five outcomes should lie.
struct Range {
  double low = 0, likely = 0, high = 0;
};

// What a run to an accuracy costs.
struct Forecast {
  double accuracy = 0;  // the error estimate to be reached
  double epsilon = 0;   // W, threshold at which it should be
  uint32_t rounds = 0;  // still to come
  Range links, elements, memory_bytes;
  Range output_elements;    // faces of the patch file; 0 where no round has measured them
  Range gather_seconds;     // of the output, wall; likewise
  Range remaining_seconds;  // until the patch file is there; of a run to less than what is reached,
                            // of the gather alone
  Range seconds;            // from the start of the job to the patch file
};

// y over ε in logarithms: y = exp(mean_y + slope (ln ε - mean_x)).
struct PowerLaw {
  double mean_x = 0, mean_y = 0, slope = 0;
  double mean_variance = 0, slope_variance = 0;

  double At(double epsilon) const;          // the value
  double VarianceAt(double epsilon) const;  // of its logarithm
  Range RangeAt(double epsilon, double more_variance = 0) const;
};

// The laws of one run.
class RunFit {
 public:
  // At least one round.
  explicit RunFit(std::span<const RoundSummary> rounds);

  const PowerLaw& error() const { return error_; }
  const PowerLaw& links() const { return links_; }

  // The threshold at which the error should be this: larger than that of the last round where less
  // than what is reached would do. `variance` (may be null): of its logarithm.
  double EpsilonFor(double accuracy, double* variance = nullptr) const;

  // Wall seconds of a round at this threshold, and of gathering its output.
  Range RoundSeconds(double epsilon) const;
  Range GatherSeconds(double epsilon) const;

  // The run to this accuracy, as the schedule would take it: aiming at kAimAt of it, in rounds that
  // lower ε by factors between kLargestStep and kSmallestStep.
  Forecast To(double accuracy) const;

 private:
  Range Spend(double epsilon, double variance, uint32_t* rounds) const;

  std::span<const RoundSummary> rounds_;
  PowerLaw error_, links_, elements_, memory_, output_elements_, gather_;
  double seconds_per_link_ = 0, rate_variance_ = 0;
};

// What ε is multiplied by in a round on the way to an accuracy.
inline constexpr double kSmallestStep = 1.0 / 16, kLargestStep = 0.7;
// Error to aim at, over the accuracy asked for.
inline constexpr double kAimAt = 0.9;

// The cost of an accuracy, whether it is finer or coarser than what the rounds have reached;
// nothing where they tell nothing yet (no round with an error above 0).
std::optional<Forecast> ForecastRun(std::span<const RoundSummary> rounds, double accuracy);

}  // namespace isolux
