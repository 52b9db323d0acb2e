#include "server/output_options.h"

#include <algorithm>
#include <cmath>

namespace isolux {

OutputMeshOptions OutputOptionsOf(const RoundSummary& last, double accuracy,
                                  const Hierarchy& hierarchy, const EffectsPlan& plan,
                                  uint64_t leaves, const OutputMeshOptions& limits) {
  OutputMeshOptions output = limits;
  output.sheets = TranslucentSheets(hierarchy, plan);
  output.fluorescence = Fluorescence(hierarchy, plan);
  output.keep_points = plan.bands;
  // No finer than what a budget has left of the accuracy asked for.
  const double reached = last.error_estimate;
  output.accuracy = std::isfinite(reached)
                        ? std::clamp(0.5 * reached, accuracy, std::max(accuracy, 0.2))
                        : accuracy;
  // A scene of many leaves is fine enough as it is; a coarse one deserves a smooth picture.
  constexpr uint64_t kEnough = 1 << 16;
  output.max_elements = std::min(output.max_elements, std::max<uint64_t>(2 * leaves, kEnough));
  return output;
}

}  // namespace isolux
