// Glass as scenes have it.
#pragma once

#include "common/scene/scene.h"

namespace isolux::testing {

// Of which the inside leaves so much straight on.
inline Glass GlassOf(const Rgb& inside, double index) {
  Glass glass;
  for (int c = 0; c < 3; ++c) glass.optical_depth[c] = OpticalDepthOf(inside[c]);
  glass.index = index;
  return glass;
}

inline void AddPane(Scene& scene, const ConvexPolygon& shape, const Glass& glass) {
  Pane pane;
  pane.count = static_cast<uint32_t>(shape.count);
  pane.corners = shape.v;
  pane.glass = static_cast<uint32_t>(scene.glazing.glasses.size());
  scene.glazing.glasses.push_back(glass);
  scene.glazing.panes.push_back(pane);
}

}  // namespace isolux::testing
