// Elements of the output with what was gathered at their corners.
#pragma once

#include <array>

#include "common/hierarchy/element.h"

namespace isolux {

using Channels = std::array<float, 3>;

struct OutputElement {
  NodeId id;
  uint32_t leaf = 0;  // place in the snapshot
  std::array<Channels, 4> irradiance{};
};

// A polygon with a value at each corner, interpolated as it is cut.
struct Field {
  ConvexPolygon shape;
  std::array<Channels, 4> value{};
};

// As Subdivide does it.
std::array<Field, 2> Cut(const Field& field);

}  // namespace isolux
