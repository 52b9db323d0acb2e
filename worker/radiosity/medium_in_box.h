// A medium in the box around a scene, for light that comes from outside.
#pragma once

#include <algorithm>
#include <limits>

#include "common/scene/medium.h"
#include "common/vec.h"

namespace isolux {

struct MediumInBox {
  Medium medium;
  Bounds3 box;

  // What is left of light that comes to `point` from `towards` (of length 1), from where it enters
  // the box. The point may lie outside if the ray meets the box.
  Rgb FromOutside(const Vec3& point, const Vec3& towards) const {
    double way_m = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      if (towards[i] == 0) continue;
      way_m =
          std::min(way_m, ((towards[i] > 0 ? box.high[i] : box.low[i]) - point[i]) / towards[i]);
    }
    return medium.Along(std::max(way_m, 0.0));
  }
};

}  // namespace isolux
