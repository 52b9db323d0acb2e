// Partly hidden pairs whose coupling is known to 15 digits: parallel rectangles with parallel
// occluders, by ∫∫ Wx(u) Wy(v) h² / (π (u² + v² + h²)²) du dv with piecewise linear overlaps W, and
// walls and obstacles of one height over segments in plan, by a double integral over the plan.
#pragma once

#include <string>
#include <vector>

#include "tests/support/polygons.h"

namespace isolux::testing {

struct OccludedCase {
  std::string name;
  ConvexPolygon p, q;
  std::vector<ConvexPolygon> occluders;
  double coupling_m2 = 0;
  double unobstructed_m2 = 0;
};

inline std::vector<OccludedCase> OccludedCases() {
  const ConvexPolygon low = AxisRectangle(2, 0, 0, 1, 0, 1, true);
  const ConvexPolygon high = AxisRectangle(2, 1, 0, 1, 0, 1, false);
  const double whole = 0.1998248956983874;
  const auto sheet = [](double u0, double u1, double v0, double v1, double z = 0.5) {
    return AxisRectangle(2, z, u0, u1, v0, v1, true);
  };
  std::vector<OccludedCase> cases{
      {"half-size square midway",
       low,
       high,
       {sheet(.25, .75, .25, .75)},
       0.09950629459898479,
       whole},
      {"strip across", low, high, {sheet(-1, 2, .4, .6)}, 0.1367388107541274, whole},
      {"all covered", low, high, {sheet(-.01, 1.01, -.01, 1.01)}, 0, whole},
      {"hole in a wall",
       low,
       high,
       {sheet(-50, .25, -50, 50), sheet(.75, 50, -50, 50), sheet(.25, .75, -50, .25),
        sheet(.25, .75, .75, 50)},
       0.1003186010994026,
       whole},
      {"two strips",
       low,
       high,
       {sheet(.1, .4, .1, .9), sheet(.6, .9, .1, .9)},
       0.07926074770117361,
       whole},
      {"cover 1e-9 over the emitter",
       low,
       high,
       {sheet(.25, .75, .25, .75, 1e-9)},
       0.1427096886977442,
       whole},
  };
  // An L-shaped room of height 1, in plan (0,0) (2,0) (2,3) (1,3) (1,1) (0,1).
  const ConvexPolygon end = AxisRectangle(0, 0, 0, 1, 0, 1, true);
  const std::vector<ConvexPolygon> corner{AxisRectangle(0, 1, 1, 3, 0, 1, true),
                                          AxisRectangle(1, 1, 0, 1, 0, 1, true)};
  cases.push_back({"L-shaped room, its ends", end, AxisRectangle(1, 3, 0, 1, 1, 2, false), corner,
                   0, 0.01588388899276754});
  cases.push_back({"L-shaped room, end and side", end, AxisRectangle(0, 2, 0, 3, 0, 1, false),
                   corner, 0.09262164031108767, 0.1372629695024481});
  return cases;
}

}  // namespace isolux::testing
