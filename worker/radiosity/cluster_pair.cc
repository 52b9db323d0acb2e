#include "worker/radiosity/cluster_pair.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isolux {

double SizeOf(const Tree& tree, uint32_t node) {
  if (tree.is_cluster(node)) return tree.cluster(node).bounds.Diagonal();
  return SizeOf(tree.polygon(node));
}

double SizeOf(const ConvexPolygon& polygon) {
  const double one = glm::length(polygon.v[2] - polygon.v[0]);
  return polygon.count == 3 ? std::max({one, glm::length(polygon.v[1] - polygon.v[0]),
                                        glm::length(polygon.v[2] - polygon.v[1])})
                            : std::max(one, glm::length(polygon.v[3] - polygon.v[1]));
}

double ClusterBound(const Tree& tree, uint32_t p, uint32_t q) {
  const double smaller = std::min(tree.area_m2(p), tree.area_m2(q));
  if (p == q) return smaller;
  const auto bounds_of = [&](uint32_t node) {
    if (tree.is_cluster(node)) return tree.cluster(node).bounds;
    Bounds3 bounds;
    const ConvexPolygon& polygon = tree.polygon(node);
    for (int i = 0; i < polygon.count; ++i) bounds.Add(polygon.v[i]);
    return bounds;
  };
  const Bounds3 bounds_p = bounds_of(p);
  const Bounds3 bounds_q = bounds_of(q);
  for (int end = 0; end < 2; ++end) {
    const uint32_t element = end == 0 ? p : q;
    if (tree.is_cluster(element)) continue;
    // Everything of the other behind the element's plane?
    const Bounds3& other = end == 0 ? bounds_q : bounds_p;
    const Vec3 n = tree.normal(element);
    const Vec3 farthest(n.x > 0 ? other.high.x : other.low.x, n.y > 0 ? other.high.y : other.low.y,
                        n.z > 0 ? other.high.z : other.low.z);
    if (glm::dot(n, farthest - tree.polygon(element).v[0]) <= 0) return 0;
  }
  const double distance = Distance(bounds_p, bounds_q);
  if (distance <= 0) return smaller;
  return std::min(smaller,
                  tree.area_m2(p) * tree.area_m2(q) / (std::numbers::pi * distance * distance));
}

double ClusterCoupling(const Tree& tree, uint32_t p, uint32_t q) {
  const Vec3 d = tree.centre(q) - tree.centre(p);
  const double distance2 = glm::dot(d, d);
  if (!(distance2 > 0)) return 0;
  const int direction = NearestDirection(d);
  const auto facing = [&](uint32_t node, int side, double sign) {
    return tree.is_cluster(node)
               ? tree.facing().area_m2(node, side)
               : tree.area_m2(node) * std::max(0.0, sign * glm::dot(tree.normal(node), d)) /
                     std::sqrt(distance2);
  };
  const double seen_p = facing(p, direction, 1), seen_q = facing(q, direction ^ 1, -1);
  // As of a disk of the larger's area: neither receives more than the other sends, however near.
  return seen_p * seen_q / (std::numbers::pi * distance2 + std::max(seen_p, seen_q));
}

Meeting MeetingOf(const Tree& tree, uint32_t p, uint32_t q) {
  if (tree.is_cluster(p) && tree.is_cluster(q)) return tree.facing().OfClusters(p, q);
  const auto [cluster, element] = tree.is_cluster(p) ? std::pair(p, q) : std::pair(q, p);
  return tree.facing().OfClusterAndSurface(cluster, tree.node(element).id.surface);
}

LinkVerdict MixedEnd(const Tree& tree, uint32_t p, uint32_t q) {
  const auto mixed = [&](uint32_t node) {
    return tree.is_cluster(node) && tree.facing().IsMixed(node);
  };
  if (mixed(p) != mixed(q)) return mixed(p) ? LinkVerdict::kSplitP : LinkVerdict::kSplitQ;
  return SizeOf(tree, p) >= SizeOf(tree, q) ? LinkVerdict::kSplitP : LinkVerdict::kSplitQ;
}

}  // namespace isolux
