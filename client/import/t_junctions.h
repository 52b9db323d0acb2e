// Corners of polygons that lie inside a side of another: cracks where a renderer interpolates, and
// neighbours that do not know of each other.
#pragma once

#include <cstdint>

#include "common/scene/scene.h"

namespace isolux {

struct TJunctions {
  uint64_t count = 0;          // pairs of a vertex and a side
  uint32_t first_polygon = 0;  // file number of the first with such a side
};

// Vertices within the contact tolerance (common/hierarchy/planes.h) of sides that no second polygon
// has. Only ends of such sides count: nothing else can end at a side.
TJunctions CountTJunctions(const Scene& scene);

}  // namespace isolux
