#include <algorithm>
#include <numbers>

#include "common/util/check.h"
#include "worker/coupling/coupling.h"
#include "worker/coupling/facing.h"
#include "worker/coupling/lanes.h"
#include "worker/coupling/rules.h"

namespace isolux {
namespace {

// Four ends side by side.
struct Ends {
  Vec3x4 centre, normal;
  Lanes area, radius;

  template <typename EndOf>
  explicit Ends(const EndOf& end_of) {
    for (int i = 0; i < 4; ++i) {
      const CouplingEnd& end = end_of(i);
      centre.x[i] = end.centre.x;
      centre.y[i] = end.centre.y;
      centre.z[i] = end.centre.z;
      normal.x[i] = end.normal.x;
      normal.y[i] = end.normal.y;
      normal.z[i] = end.normal.z;
      area[i] = end.area_m2;
      radius[i] = end.radius_m;
    }
  }
};

Lanes LargestOf(const Vec3x4& v) {
  return Maximum(Maximum(Absolute(v.x), Absolute(v.y)), Absolute(v.z));
}

}  // namespace

void CoupleFar(std::span<const FarPair> pairs, std::span<PairCoupling> results) {
  CHECK_EQ(pairs.size(), results.size());
  for (size_t from = 0; from < pairs.size(); from += 4) {
    const size_t last = pairs.size() - 1;
    const auto pair = [&](int i) -> const FarPair& { return pairs[std::min(from + i, last)]; };
    const Ends p([&](int i) -> const CouplingEnd& { return *pair(i).p; });
    const Ends q([&](int i) -> const CouplingEnd& { return *pair(i).q; });
    const Lanes tolerance{pair(0).tolerance_m2, pair(1).tolerance_m2, pair(2).tolerance_m2,
                          pair(3).tolerance_m2};
    // The steps are those of FacingOf and TryKernelRules.
    const Vec3x4 d = q.centre - p.centre;
    const Lanes plane =
        1e-12 * (LargestOf(d) + p.radius + q.radius) + 1e-15 * LargestOf(q.centre + p.centre);
    const Lanes height_q = Dot(p.normal, d), height_p = -Dot(q.normal, d);
    const LaneMask behind = (height_q < -q.radius - plane) | (height_p < -p.radius - plane);
    const LaneMask front = (height_q > q.radius + plane) & (height_p > p.radius + plane);
    const Lanes d2 = Dot(d, d);
    const Lanes reach = p.radius + q.radius;
    const Lanes kappa2 = reach * reach / d2;
    const Lanes even = p.area * q.area / (std::numbers::pi * d2);
    const Lanes bound = Minimum(Minimum(p.area, q.area), even);
    const Lanes cosines = Maximum(Splat(0.0), height_q) * Maximum(Splat(0.0), height_p);
    const Lanes midpoint = Minimum(even * cosines / d2, bound);
    const LaneMask negligible =
        front & (kappa2 < kNegligibleKappa * kNegligibleKappa) & (bound <= tolerance);
    const Lanes midpoint_error = kMidpointError * kappa2 * even;
    const LaneMask middle =
        front & (kappa2 < kKernelKappa * kKernelKappa) & (midpoint_error <= tolerance);
    for (size_t i = 0; i < std::min<size_t>(4, pairs.size() - from); ++i) {
      PairCoupling& result = results[from + i];
      if (behind[i] != 0) {
        result = {};
      } else if (negligible[i] != 0) {
        result = {midpoint[i], bound[i], Regime::kNegligible};
      } else if (middle[i] != 0) {
        result = {midpoint[i], midpoint_error[i], Regime::kMidpoint};
      } else {
        result = {0, 0, Regime::kUndecided};
      }
    }
  }
}

}  // namespace isolux
