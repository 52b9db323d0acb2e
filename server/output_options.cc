#include "server/output_options.h"

#include <algorithm>
#include <cmath>

namespace isolux {

OutputMeshOptions OutputOptionsOf(const RoundSummary& last, const SolveOptions& asked,
                                  const Hierarchy& hierarchy, const EffectsPlan& plan,
                                  uint64_t leaves, const OutputMeshOptions& limits) {
  OutputMeshOptions output = limits;
  output.sheets = TranslucentSheets(hierarchy, plan);
  output.fluorescence = Fluorescence(hierarchy, plan);
  output.keep_points = plan.bands;
  // No finer than what a budget has left of the accuracy asked for. Where it is one of time, that
  // is better spent on rounds than on an output that is finer than the solution.
  const double reached = (asked.max_seconds > 0 ? 1 : 0.5) * last.error_estimate;
  output.accuracy = std::isfinite(reached)
                        ? std::clamp(reached, asked.accuracy, std::max(asked.accuracy, 0.2))
                        : asked.accuracy;
  output.point_accuracy = output.accuracy;
  // A scene of many leaves is fine enough as it is; a coarse one deserves a smooth picture.
  constexpr uint64_t kEnough = 1 << 16;
  output.max_elements = std::min(output.max_elements, std::max<uint64_t>(2 * leaves, kEnough));
  return output;
}

double PointAccuracyWithin(double times_as_long, double accuracy) {
  constexpr double kFinest = 1.0 / 3, kPower = 0.8;
  const double share = std::clamp(std::pow(times_as_long, -kPower), kFinest, 1.0);
  return share < 1 ? share * std::min(accuracy, kCoarsestOfPoints) : accuracy;
}

}  // namespace isolux
