// How much the form factor to a polygon varies over another: what a refinement judges by.
#pragma once

#include <algorithm>

#include "worker/coupling/coupling.h"

namespace isolux {

struct FormFactorVariation {
  double over_p = 0;  // largest minus smallest F(x→q) over points x of p
  double over_q = 0;  // largest minus smallest F(y→p) over points y of q
};

// Form factors at some points of an end.
struct FormFactorRange {
  double low = 0, high = 0;
  double WidthWith(double mean) const { return std::max(high, mean) - std::min(low, mean); }
};
struct FormFactorRanges {
  FormFactorRange over_p, over_q;
  // Without the means: never more than with them.
  FormFactorVariation Variation() const {
    return {over_p.high - over_p.low, over_q.high - over_q.low};
  }
};

// Over the corners, drawn in by a tenth, and, where the ends are near for their size, the points
// closest to the other's centre and corners.
FormFactorRanges RangesOver(const CouplingEnd& p, const CouplingEnd& q);

// The same with the mean, `coupling_m2` over the area.
FormFactorVariation VariationWith(const FormFactorRanges& ranges, const CouplingEnd& p,
                                  const CouplingEnd& q, double coupling_m2);

}  // namespace isolux
