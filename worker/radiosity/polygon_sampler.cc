#include "worker/radiosity/polygon_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isolux {

double InsideShare(const ConvexPolygon& polygon, const Vec3& centre, double noise_m) {
  const double margin_m = 2 * noise_m;
  double least2 = std::numeric_limits<double>::infinity();  // squared, from the centre to a side
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 along = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    const Vec3 cross = glm::cross(along, centre - polygon.v[i]);
    least2 = std::min(least2, glm::dot(cross, cross) / std::max(glm::dot(along, along), 1e-300));
  }
  constexpr double kMost = 0.25;
  return margin_m * margin_m >= kMost * kMost * least2 ? kMost : margin_m / std::sqrt(least2);
}

ConvexPolygon DrawnIn(const ConvexPolygon& polygon, const Vec3& centre, double noise_m) {
  const double share = InsideShare(polygon, centre, noise_m);
  ConvexPolygon result = polygon;
  for (int i = 0; i < polygon.count; ++i) result.v[i] += share * (centre - polygon.v[i]);
  return result;
}

Vec3 SamplePolygon(const ConvexPolygon& polygon, double u, double v) {
  int first = 1;
  if (polygon.count == 4) {
    // Pick one of the two triangles by area, and stretch u over it.
    const double one =
        glm::length(glm::cross(polygon.v[1] - polygon.v[0], polygon.v[2] - polygon.v[0]));
    const double two =
        glm::length(glm::cross(polygon.v[2] - polygon.v[0], polygon.v[3] - polygon.v[0]));
    const double share = one / (one + two);
    if (u < share) {
      u /= share;
    } else {
      u = (u - share) / (1 - share);
      first = 2;
    }
  }
  const double root = std::sqrt(std::clamp(u, 1e-9, 1 - 1e-9));
  v = std::clamp(v, 1e-5, 1 - 1e-5);
  return polygon.v[0] + root * ((1 - v) * (polygon.v[first] - polygon.v[0]) +
                                v * (polygon.v[first + 1] - polygon.v[0]));
}

PolygonSampler::PolygonSampler(const ConvexPolygon& polygon) {
  const auto side = [&](int k, std::array<float, 3>& to) {
    for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(polygon.v[k][c] - polygon.v[0][c]);
  };
  for (int c = 0; c < 3; ++c) corner_[c] = static_cast<float>(polygon.v[0][c]);
  side(1, triangles_[0].first);
  side(2, triangles_[0].second);
  if (polygon.count == 3) return;
  side(2, triangles_[1].first);
  side(3, triangles_[1].second);
  const Vec3 diagonal = polygon.v[2] - polygon.v[0];
  const double one = glm::length(glm::cross(polygon.v[1] - polygon.v[0], diagonal));
  const double two = glm::length(glm::cross(diagonal, polygon.v[3] - polygon.v[0]));
  if (two > 0) first_share_ = static_cast<float>(one / (one + two));
}

FloatPoints PolygonSampler::At(FloatLanes u, FloatLanes v) const {
  const Int32Lanes second = u >= first_share_;
  const float rest = std::max(1 - first_share_, 1e-30F);
  u = Select(second, (u - first_share_) / rest, u / std::max(first_share_, 1e-30F));
  const FloatLanes root = SquareRoot(Minimum(Maximum(u, SplatFloat(1e-9F)), SplatFloat(1)));
  v = Minimum(Maximum(v, SplatFloat(1e-5F)), SplatFloat(1 - 1e-5F));
  const FloatLanes along_first = root * (1 - v), along_second = root * v;
  FloatPoints points;
  for (int c = 0; c < 3; ++c) {
    const FloatLanes first =
        Select(second, SplatFloat(triangles_[1].first[c]), SplatFloat(triangles_[0].first[c]));
    const FloatLanes other =
        Select(second, SplatFloat(triangles_[1].second[c]), SplatFloat(triangles_[0].second[c]));
    points[c] = corner_[c] + (along_first * first + along_second * other);
  }
  return points;
}

}  // namespace isolux
