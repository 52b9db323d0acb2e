// The gather through panes of glass. What they leave of the light of a source is the mean over nine
// of its points, weighted by what they bring, or what its link knows.
#include <algorithm>
#include <bit>
#include <utility>

#include "worker/radiosity/gather_point.h"

namespace isolux {
namespace {

struct Node {
  double at, weight;
};
// Gauss–Legendre with three points on [0, 1].
constexpr std::array<Node, 3> kGauss = {
    {{0.1127016653792583, 5.0 / 18}, {0.5, 8.0 / 18}, {0.8872983346207417, 5.0 / 18}}};

// Sources wholly behind the same panes that are seen smaller than this, radius over distance, count
// with one point.
constexpr double kSmall = 0.15;

// The middle of a polygon and its squared radius about it.
std::pair<Vec3, double> CircleAbout(const ConvexPolygon& polygon) {
  Vec3 middle(0.0);
  for (int i = 0; i < polygon.count; ++i) middle += polygon.v[i] / double(polygon.count);
  double radius2 = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 d = polygon.v[i] - middle;
    radius2 = std::max(radius2, glm::dot(d, d));
  }
  return {middle, radius2};
}

}  // namespace

Rgb PointGather::LeftByPanesOf(const GatherPlace& place, const RayTarget& target) const {
  const ConvexPolygon& polygon = target.polygon;
  const auto [middle, radius2] = CircleAbout(polygon);
  const Vec3 to_middle = middle - place.position;
  if (target.glazed.all && radius2 < kSmall * kSmall * glm::dot(to_middle, to_middle)) {
    return LeftByPanesTo(place.position, middle, target.image);
  }
  const Vec3 &a = polygon.v[0], &b = polygon.v[1], &c = polygon.v[2];
  const Vec3& d = polygon.count == 4 ? polygon.v[3] : polygon.v[0];
  Rgb sum(0.0);
  double weights = 0;
  for (const auto& [v, wv] : kGauss) {
    for (const auto& [u, wu] : kGauss) {
      const Vec3 along_u = (1 - v) * (b - a) + v * (c - d);
      const Vec3 along_v = (1 - u) * (d - a) + u * (c - b);
      const Vec3 y = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d;
      const Vec3 way = y - place.position;
      const double distance2 = glm::dot(way, way);
      const double cosines = std::max(0.0, glm::dot(normal_, way)) *  //
                             std::max(0.0, -glm::dot(target.normal, way));
      if (!(cosines > 0)) continue;
      const double weight =
          wu * wv * glm::length(glm::cross(along_u, along_v)) * cosines / (distance2 * distance2);
      weights += weight;
      sum += weight * LeftByPanesTo(place.position, y, target.image);
    }
  }
  return weights > 0 ? sum / weights : Rgb(1.0);
}

bool PointGather::LeftByPanes(const GatherPlace& place, SourceBlock& block, size_t octet,
                              FloatLanes factor, std::array<FloatLanes, 3>* left) const {
  bool any = false;
  for (int lanes = Bits(factor > 0.0F); lanes != 0; lanes &= lanes - 1) {
    const int lane = std::countr_zero(static_cast<unsigned>(lanes));
    const RayTarget& target = block.target(8 * octet + static_cast<size_t>(lane));
    if (target.glazed.kind == Glazed::Kind::kNot) continue;
    any = true;
    if (target.glazed.kind == Glazed::Kind::kMean) {
      for (int c = 0; c < 3; ++c) (*left)[c][lane] = target.glazed.mean[c];
      continue;
    }
    const Rgb of_point = LeftByPanesOf(place, target);
    for (int c = 0; c < 3; ++c) (*left)[c][lane] = static_cast<float>(of_point[c]);
  }
  return any;
}

}  // namespace isolux
