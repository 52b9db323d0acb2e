// How much the form factor to a polygon varies over another: what a refinement judges by.
#pragma once

#include "worker/coupling/coupling.h"

namespace isolux {

struct FormFactorVariation {
  double over_p = 0;  // largest minus smallest F(x→q) over points x of p
  double over_q = 0;  // largest minus smallest F(y→p) over points y of q
};

// The range over the corners, drawn in by a tenth, the mean (`coupling_m2` over the area) and,
// where the ends are near for their size, the points closest to the other's centre and corners.
FormFactorVariation VariationOver(const CouplingEnd& p, const CouplingEnd& q, double coupling_m2);

}  // namespace isolux
