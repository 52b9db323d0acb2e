// Uniform points of triangles and quads: where rays start and end.
#pragma once

#include <array>

#include "common/scene/scene.h"
#include "worker/coupling/float_lanes.h"

namespace isolux {

// Eight points or vectors, in the scene's coordinates.
using FloatPoints = std::array<FloatLanes, 3>;

// The share of the way to the centroid by which points of a polygon are drawn in, a quarter at
// most, so that none is nearer to a side than twice the noise (RayScene::coordinate_noise_m).
// Things stand along sides, and rays from points within the noise would pass through them.
double InsideShare(const ConvexPolygon& polygon, const Vec3& centre, double noise_m);
// The polygon drawn in by that share.
ConvexPolygon DrawnIn(const ConvexPolygon& polygon, const Vec3& centre, double noise_m);
inline ConvexPolygon DrawnIn(const ConvexPolygon& polygon, double noise_m) {
  return DrawnIn(polygon, polygon.Centroid(), noise_m);
}

// One point, in double; u, v in [0, 1].
Vec3 SamplePolygon(const ConvexPolygon& polygon, double u, double v);

// Eight points.
class PolygonSampler {
 public:
  PolygonSampler() = default;
  explicit PolygonSampler(const ConvexPolygon& polygon);

  // u, v in [0, 1).
  FloatPoints At(FloatLanes u, FloatLanes v) const;

 private:
  // A quad is two triangles with the first corner in common; u picks one of them by area.
  struct Triangle {
    std::array<float, 3> first{}, second{};  // sides from the first corner
  };
  std::array<float, 3> corner_{};
  std::array<Triangle, 2> triangles_;
  float first_share_ = 1;
};

}  // namespace isolux
