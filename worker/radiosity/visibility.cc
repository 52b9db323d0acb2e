#include "worker/radiosity/visibility.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "common/util/random.h"

namespace isolux {

NodeSampler::NodeSampler(const Tree& tree) {
  const Hierarchy& hierarchy = tree.hierarchy();
  area_before_.reserve(hierarchy.surfaces().size() + 1);
  double sum = 0;
  for (const uint32_t surface : hierarchy.surface_order()) {
    area_before_.push_back(sum);
    sum += hierarchy.surface_area_m2(surface);
  }
  area_before_.push_back(sum);
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

ConvexPolygon DrawnIn(const ConvexPolygon& polygon, double noise_m) {
  const Vec3 centre = polygon.Centroid();
  const double share = InsideShare(polygon, centre, noise_m);
  ConvexPolygon result = polygon;
  for (int i = 0; i < polygon.count; ++i) result.v[i] += share * (centre - polygon.v[i]);
  return result;
}

NodeSampler::Point NodeSampler::Sample(const Tree& tree, uint32_t node, double u, double v,
                                       double w) const {
  if (!tree.is_cluster(node)) {
    return {SamplePolygon(tree.polygon(node), u, v), tree.normal(node),
            tree.surface_of(node).polygon, tree.node(node).id.surface};
  }
  const Cluster& cluster = tree.cluster(node);
  const auto begin = area_before_.begin() + cluster.first_surface;
  const double target = *begin + w * (begin[cluster.surface_count] - *begin);
  auto place =
      static_cast<uint32_t>(std::upper_bound(begin, begin + cluster.surface_count, target) - begin);
  place = std::clamp<uint32_t>(place, 1, cluster.surface_count) - 1;
  const uint32_t surface = tree.hierarchy().surface_order()[cluster.first_surface + place];
  return Sample(tree, tree.SurfaceIndex(surface), u, v, 0);
}

namespace {

// How samples of an element are kept off its sides, where things may stand; nothing for clusters.
struct Inset {
  Vec3 centre{0.0};
  double share = 0;
};

Inset InsetOf(const Tree& tree, uint32_t node, double noise_m) {
  if (tree.is_cluster(node)) return {};
  const ConvexPolygon& polygon = tree.polygon(node);
  const Vec3 centre = polygon.Centroid();
  return {centre, InsideShare(polygon, centre, noise_m)};
}

bool StandsFor(const Tree& tree, uint32_t node, uint32_t surface) {
  return !tree.is_cluster(node) || tree.facing().StandsFor(node, surface);
}

}  // namespace

SampledVisibility SampleVisibility(const Tree& tree, const NodeSampler& sampler,
                                   const RayScene& rays, uint32_t p, uint32_t q, uint64_t seed) {
  const NodeId& a = tree.node(p).id;
  const NodeId& b = tree.node(q).id;
  Random random(Hash(seed, Hash(a.surface, a.path), Hash(b.surface, b.path)));
  std::array<double, 6> shift;
  for (double& s : shift) s = random.Unit();
  // A rank-1 lattice of eight points, shifted at random: stratified in every coordinate.
  constexpr std::array<int, 6> kGenerator = {1, 3, 5, 7, 3, 5};
  constexpr int kCount = RayScene::kPacket;
  std::array<Segment, kCount> segments;
  std::array<double, kCount> weight{};
  int traced = 0;
  double total = 0;
  const Inset inset_p = InsetOf(tree, p, rays.coordinate_noise_m());
  const Inset inset_q = InsetOf(tree, q, rays.coordinate_noise_m());
  for (int i = 0; i < kCount; ++i) {
    std::array<double, 6> u;
    for (int d = 0; d < 6; ++d) {
      u[d] = shift[d] + (i * kGenerator[d] % kCount) * (1.0 / kCount);
      u[d] -= std::floor(u[d]);
    }
    auto x = sampler.Sample(tree, p, u[0], u[1], u[4]);
    auto y = sampler.Sample(tree, q, u[2], u[3], u[5]);
    x.position += inset_p.share * (inset_p.centre - x.position);
    y.position += inset_q.share * (inset_q.centre - y.position);
    const Vec3 d = y.position - x.position;
    const double d2 = glm::dot(d, d);
    const double cosines =
        std::max(0.0, glm::dot(x.normal, d)) * std::max(0.0, -glm::dot(y.normal, d));
    if (!(cosines > 0) || x.polygon == y.polygon) continue;
    if (!StandsFor(tree, p, x.surface) || !StandsFor(tree, q, y.surface)) continue;
    // The kernel's peak where the ends touch would leave one ray to decide.
    weight[traced] =
        std::min(cosines / (d2 * d2), 1.0 / std::min(tree.area_m2(p), tree.area_m2(q)));
    total += weight[traced];
    segments[traced++] = {x.position, y.position, x.polygon, y.polygon};
  }
  SampledVisibility result;
  result.traced = traced;
  if (traced == 0) return result;
  const uint32_t visible = rays.Visible(segments, traced);
  double passed = 0;
  for (int i = 0; i < traced; ++i) {
    if ((visible >> i & 1) != 0) passed += weight[i];
  }
  result.share = std::clamp(passed / total, 0.0, 1.0);
  // Rays that were not traced say nothing: scale the count to eight.
  result.visible = (std::popcount(visible) * kCount + traced / 2) / traced;
  return result;
}

}  // namespace isolux
