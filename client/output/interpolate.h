// Values inside a face from its vertices, and faces cut into triangles, for pictures and
// comparisons. Faces are convex; T-vertices stand in the vertex list, on straight sides.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/vec.h"

namespace isolux {

// Mean value coordinates of `point` in the polygon: weights of its vertices with sum 1. They are
// linear along every side between two vertices, T-vertices included, so that values meet without a
// jump across sides; smooth inside; exact for linear fields; barycentric in a triangle. A point in
// the polygon gets weights in [0, 1].
// Source: [Floater03], with tan(α/2) = sin α / (1 + cos α).
void MeanValueWeights(std::span<const Vec3> polygon, const Vec3& point, std::span<double> weights);

// Triangles (places in the polygon) that cover it and use every vertex, none without area where
// that is possible: ears are cut off, the roundest first.
std::vector<std::array<uint32_t, 3>> Triangulate(std::span<const Vec3> polygon);

}  // namespace isolux
