#include "worker/radiosity/cluster_pair.h"

#include <algorithm>

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
