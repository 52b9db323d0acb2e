// Glass as scenes have it.
#pragma once

#include "common/scene/glazing.h"

namespace isolux::testing {

// Of which the inside leaves so much straight on.
inline Glass GlassOf(const Rgb& inside, double index) {
  Glass glass;
  for (int c = 0; c < 3; ++c) glass.optical_depth[c] = OpticalDepthOf(inside[c]);
  glass.index = index;
  return glass;
}

}  // namespace isolux::testing
