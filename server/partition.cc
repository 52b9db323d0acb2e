#include "server/partition.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>

#include "common/hierarchy/element.h"
#include "common/util/random.h"

namespace isolux {
namespace {

// First leaf at or after `id` in the order of a walk.
std::vector<LeafRecord>::const_iterator LowerBound(const Snapshot& snapshot, const NodeId& id) {
  return std::lower_bound(snapshot.leaves.begin(), snapshot.leaves.end(), id,
                          [](const LeafRecord& leaf, const NodeId& key) { return leaf.id < key; });
}

uint64_t CountElementLeaves(const Snapshot& snapshot, const NodeId& node) {
  uint64_t count = 0;
  for (auto leaf = LowerBound(snapshot, node);
       leaf != snapshot.leaves.end() && Contains(node, leaf->id); ++leaf) {
    ++count;
  }
  return count;
}

class Weigher {
 public:
  explicit Weigher(const Hierarchy& hierarchy) : hierarchy_(hierarchy) {
    const Cluster& root = hierarchy.clusters()[0];
    area_m2_ = std::max(root.area_m2, 1e-300);
    surfaces_ = std::max<double>(1.0, root.surface_count);
  }
  double operator()(const NodeId& node) const {
    const double surfaces =
        node.is_cluster() ? hierarchy_.clusters()[node.path].surface_count : 1.0;
    return 0.5 * AreaOf(hierarchy_, node) / area_m2_ + 0.5 * surfaces / surfaces_;
  }

 private:
  const Hierarchy& hierarchy_;
  double area_m2_, surfaces_;
};

// Consecutive pieces of nearly equal weight; none is empty while there are nodes enough.
void HandOutInOrder(std::span<const uint32_t> order, std::span<const double> weight,
                    uint32_t worker_count, std::span<uint32_t> home) {
  const double total = std::accumulate(weight.begin(), weight.end(), 0.0);
  double before = 0;
  uint32_t worker = 0;
  size_t in_piece = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    const double middle = before + 0.5 * weight[order[i]];
    const size_t left = order.size() - i;
    const bool full = middle >= total * (worker + 1) / worker_count;
    const bool scarce = left <= worker_count - 1 - worker;  // one each for the rest
    if (in_piece > 0 && worker + 1 < worker_count && (full || scarce)) {
      ++worker;
      in_piece = 0;
    }
    home[order[i]] = worker;
    ++in_piece;
    before += weight[order[i]];
  }
}

void HandOutHeaviestFirst(std::span<const double> weight, uint32_t worker_count,
                          std::span<uint32_t> home) {
  std::vector<uint32_t> order(weight.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return weight[a] > weight[b]; });
  std::vector<double> load(worker_count, 0.0);
  for (const uint32_t i : order) {
    const auto lightest = std::min_element(load.begin(), load.end());
    home[i] = static_cast<uint32_t>(lightest - load.begin());
    *lightest += weight[i];
  }
}

}  // namespace

uint32_t CutTarget(const SolveOptions& options, uint32_t worker_count) {
  return std::max(options.cut_size, kCutNodesPerWorker * worker_count);
}

std::vector<NodeId> ChildrenOf(const Hierarchy& hierarchy, const Snapshot* snapshot,
                               const NodeId& node) {
  if (!node.is_cluster()) {
    if (snapshot == nullptr) return {};
    const auto leaf = LowerBound(*snapshot, node);
    const bool deeper =
        leaf != snapshot->leaves.end() && leaf->id != node && Contains(node, leaf->id);
    if (!deeper) return {};
    return {node.Child(0), node.Child(1)};
  }
  const Cluster& cluster = hierarchy.clusters()[node.path];
  std::vector<NodeId> children;
  for (uint32_t i = 0; i < cluster.child_count; ++i) {
    const uint32_t child = cluster.first_child + i;
    // Clusters of polygons that take no part hold nothing.
    if (hierarchy.clusters()[child].surface_count > 0)
      children.push_back({NodeId::kCluster, child});
  }
  if (cluster.child_count == 0) {
    for (uint32_t i = 0; i < cluster.surface_count; ++i) {
      children.push_back({hierarchy.surface_order()[cluster.first_surface + i], 1});
    }
    std::sort(children.begin(), children.end());
  }
  return children;
}

uint64_t CountLeaves(const Hierarchy& hierarchy, const Snapshot& snapshot, const NodeId& node) {
  if (!node.is_cluster()) return CountElementLeaves(snapshot, node);
  const Cluster& cluster = hierarchy.clusters()[node.path];
  uint64_t count = 0;
  for (uint32_t i = 0; i < cluster.surface_count; ++i) {
    const uint32_t surface = hierarchy.surface_order()[cluster.first_surface + i];
    count += CountElementLeaves(snapshot, {surface, 1});
  }
  return count;
}

double AreaOf(const Hierarchy& hierarchy, const NodeId& node) {
  if (node.is_cluster()) return hierarchy.clusters()[node.path].area_m2;
  if (node.is_surface()) return hierarchy.surface_area_m2(node.surface);
  return ElementGeometry(hierarchy.geometry(node.surface), node.path).Area();
}

std::vector<NodeId> MakeCut(const Hierarchy& hierarchy, uint32_t target) {
  const Weigher weigh(hierarchy);
  const auto lighter = [](const std::pair<double, NodeId>& a, const std::pair<double, NodeId>& b) {
    return a.first != b.first ? a.first < b.first : b.second < a.second;
  };
  std::priority_queue<std::pair<double, NodeId>, std::vector<std::pair<double, NodeId>>,
                      decltype(lighter)>
      splittable(lighter);
  std::vector<NodeId> cut;
  const NodeId root{NodeId::kCluster, 0};
  splittable.push({weigh(root), root});
  while (!splittable.empty() && cut.size() + splittable.size() < target) {
    const NodeId node = splittable.top().second;
    splittable.pop();
    const std::vector<NodeId> children = ChildrenOf(hierarchy, nullptr, node);
    if (children.empty()) cut.push_back(node);
    for (const NodeId& child : children) splittable.push({weigh(child), child});
  }
  for (; !splittable.empty(); splittable.pop()) cut.push_back(splittable.top().second);
  std::sort(cut.begin(), cut.end());
  return cut;
}

std::vector<uint32_t> AssignHomes(const Hierarchy& hierarchy, std::span<const NodeId> cut,
                                  Distribution distribution, uint32_t worker_count, uint64_t seed) {
  const Weigher weigh(hierarchy);
  std::vector<double> weight;
  for (const NodeId& node : cut) weight.push_back(weigh(node));
  std::vector<uint32_t> home(cut.size(), 0);
  if (distribution == Distribution::kBalanced) {
    HandOutHeaviestFirst(weight, worker_count, home);
    return home;
  }
  std::vector<uint32_t> place_of(hierarchy.surfaces().size());  // in the order of the octree
  for (uint32_t i = 0; i < place_of.size(); ++i) place_of[hierarchy.surface_order()[i]] = i;
  const auto surfaces_of = [&](const NodeId& node) {
    if (!node.is_cluster()) return std::span(&hierarchy.surface_order()[place_of[node.surface]], 1);
    const Cluster& cluster = hierarchy.clusters()[node.path];
    return hierarchy.surface_order().subspan(cluster.first_surface, cluster.surface_count);
  };
  const auto key = [&](const NodeId& node) -> uint64_t {
    const auto surfaces = surfaces_of(node);
    switch (distribution) {
      case Distribution::kInput:
        return *std::min_element(surfaces.begin(), surfaces.end());
      case Distribution::kRandom:
        return Hash(seed, node.surface, node.path);
      default:
        return place_of[surfaces.front()];
    }
  };
  std::vector<uint64_t> keys;
  for (const NodeId& node : cut) keys.push_back(key(node));
  std::vector<uint32_t> order(cut.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return keys[a] < keys[b]; });
  HandOutInOrder(order, weight, worker_count, home);
  return home;
}

Assignment Partition(const Hierarchy& hierarchy, const SolveOptions& options,
                     uint32_t worker_count) {
  Assignment assignment;
  assignment.cut = MakeCut(hierarchy, CutTarget(options, worker_count));
  assignment.home =
      AssignHomes(hierarchy, assignment.cut, options.distribution, worker_count, options.seed);
  assignment.worker_count = worker_count;
  return assignment;
}

}  // namespace isolux
