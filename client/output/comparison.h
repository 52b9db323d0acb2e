// The difference between two solutions of one scene, at points uniform over the surfaces.
#pragma once

#include <cstdint>

#include "common/scene/patch_file.h"

namespace isolux {

// e(x) = Σ_c |ΔH|, h(x) = Σ_c H of the second solution, both of the gathered irradiance
// interpolated over the output mesh; means over the area.
struct Comparison {
  double l1_relative = 0;   // mean e / mean h
  double rms_relative = 0;  // √(mean e²) / mean h
  double max_relative = 0;  // largest e / mean h
  double p95_local = 0;     // 95th percentile of e / max(h, 5 % of the mean h)
  uint64_t samples = 0;
  uint64_t unmatched = 0;  // points on surfaces that one of the solutions left out as dark
};

struct ComparisonOptions {
  uint64_t samples = 1 << 18;
  uint64_t seed = 1;
};

// Points are matched by file polygon, side and position. Surfaces that only one solution has count
// as dark in the other. Fails where the second has no irradiance to be relative to.
Result<Comparison> Compare(const PatchFile& a, const PatchFile& b,
                           const ComparisonOptions& options);

}  // namespace isolux
