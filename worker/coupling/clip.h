// Cutting a convex polygon by a plane: what of one polygon can be seen from another. For the
// coupling of two polygons and for form factors from points.
#pragma once

#include <array>
#include <span>

#include "common/scene/scene.h"

namespace isolux {

// A convex polygon cut by a half-space: up to five corners.
struct ClippedPolygon {
  int count = 0;
  std::array<Vec3, 5> v{};

  double Area() const;
  std::span<const Vec3> corners() const { return {v.data(), static_cast<size_t>(count)}; }
};

// The part of `polygon` in front of the plane through `point` with this normal; corners within
// `tolerance_m` of the plane count as on it. Empty (count 0) where nothing is in front.
ClippedPolygon ClipToFront(const ConvexPolygon& polygon, const Vec3& point, const Vec3& normal,
                           double tolerance_m);

}  // namespace isolux
