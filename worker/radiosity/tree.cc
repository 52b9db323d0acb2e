#include "worker/radiosity/tree.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/element.h"
#include "common/util/check.h"

namespace isolux {

Tree::Tree(const Hierarchy& hierarchy)
    : hierarchy_(&hierarchy),
      cluster_count_(static_cast<uint32_t>(hierarchy.clusters().size())),
      facing_(hierarchy) {
  normals_.reserve(hierarchy.surfaces().size());
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    normals_.push_back(hierarchy.geometry(s).Normal());
  }
  Reset();
}

void Tree::Reset() {
  nodes_.clear();
  values_.clear();
  area_m2_.clear();
  polygons_.clear();
  centres_.clear();
  radius_m_.clear();
  first_leaf_.clear();
  for (uint32_t c = 0; c < cluster_count_; ++c) {
    const Cluster& cluster = hierarchy_->clusters()[c];
    nodes_.push_back({{NodeId::kCluster, c},
                      cluster.parent,
                      cluster.child_count > 0 ? cluster.first_child : kNoNode});
    values_.emplace_back();
    area_m2_.push_back(cluster.area_m2);
  }
  for (uint32_t s = 0; s < hierarchy_->surfaces().size(); ++s) {
    Append({s, 1}, hierarchy_->cluster_of(s), hierarchy_->geometry(s));
  }
}

uint32_t Tree::Append(const NodeId& id, uint32_t parent, const ConvexPolygon& polygon) {
  nodes_.push_back({id, parent, kNoNode});
  values_.emplace_back();
  const CouplingEnd end = MakeCouplingEnd(polygon);
  area_m2_.push_back(end.area_m2);
  polygons_.push_back(polygon);
  centres_.push_back(end.centre);
  radius_m_.push_back(end.radius_m);
  return static_cast<uint32_t>(nodes_.size() - 1);
}

uint32_t Tree::FindNearest(const NodeId& id) const {
  uint32_t index = SurfaceIndex(id.surface);
  for (int level = id.level() - 1; level >= 0; --level) {
    const uint32_t child = nodes_[index].first_child;
    if (child == kNoNode) break;
    index = child + static_cast<uint32_t>((id.path >> level) & 1);
  }
  return index;
}

uint32_t Tree::Find(const NodeId& id) const {
  if (id.is_cluster()) return id.path < cluster_count_ ? static_cast<uint32_t>(id.path) : kNoNode;
  if (id.surface >= normals_.size()) return kNoNode;
  const uint32_t index = FindNearest(id);
  return nodes_[index].id == id ? index : kNoNode;
}

uint32_t Tree::FindOrMake(const NodeId& id) {
  uint32_t index = FindNearest(id);
  for (int below = id.level() - nodes_[index].id.level() - 1; below >= 0; --below) {
    index = MakeChildren(index) + static_cast<uint32_t>((id.path >> below) & 1);
  }
  return index;
}

uint32_t Tree::MakeChildren(uint32_t element) {
  if (nodes_[element].first_child != kNoNode) return nodes_[element].first_child;
  const NodeId id = nodes_[element].id;
  CHECK_LT(id.level(), kMaxLevel);
  const auto parts = Subdivide(polygon(element));
  const uint32_t first = Append(id.Child(0), element, parts[0]);
  Append(id.Child(1), element, parts[1]);
  constexpr float kPerLevel = 0.70710678F;
  NodeValues values = values_[element];
  values.spread *= kPerLevel;
  values.deviation *= kPerLevel;
  values_[first] = values_[first + 1] = values;
  nodes_[element].first_child = first;
  return first;
}

Status Tree::Install(const Snapshot& snapshot, std::vector<uint32_t>* moved) {
  for (const LeafRecord& leaf : snapshot.leaves) {
    if (leaf.id.surface >= normals_.size()) {
      return MakeStatus(StatusCode::kDataLoss, "snapshot: no surface {}", leaf.id.surface);
    }
  }
  const std::vector<Node> old = std::move(nodes_);
  Reset();
  InsertLeaves(snapshot);
  PullValues(snapshot);
  moved->assign(old.size(), kNoNode);
  const uint32_t fixed = cluster_count_ + static_cast<uint32_t>(normals_.size());
  for (uint32_t i = 0; i < old.size(); ++i) {
    if (i < fixed) {
      (*moved)[i] = i;
      continue;
    }
    const uint32_t parent = (*moved)[old[i].parent];  // parents come first
    if (parent == kNoNode || nodes_[parent].first_child == kNoNode) continue;
    (*moved)[i] = nodes_[parent].first_child + static_cast<uint32_t>(old[i].id.path & 1);
  }
  return {};
}

void Tree::InsertLeaves(const Snapshot& snapshot) {
  for (const LeafRecord& leaf : snapshot.leaves) FindOrMake(leaf.id);
  first_leaf_.assign(nodes_.size(), kNoNode);
  for (uint32_t k = 0; k < snapshot.leaves.size(); ++k) {
    // The leaves come in order: the first below a node is the first met.
    uint32_t index = Find(snapshot.leaves[k].id);
    while (index != kNoNode && !is_cluster(index) && first_leaf_[index] == kNoNode) {
      first_leaf_[index] = k;
      index = nodes_[index].parent;
    }
  }
}

void Tree::PullValues(const Snapshot& snapshot) {
  const size_t count = nodes_.size();
  // Mean, mean of squares, and range, in double and in a fixed order.
  struct Moments {
    double mean = 0, square = 0, low = 0, high = 0;
  };
  std::vector<Moments> moments(count);
  const std::vector<PassedLight> passed = PassedLightOf(snapshot);
  for (size_t k = 0; k < snapshot.leaves.size(); ++k) {
    const LeafRecord& leaf = snapshot.leaves[k];
    const uint32_t node = Find(leaf.id);
    const Optics optics = hierarchy_->maps().Over(surface_of(node), polygon(node));
    double radiosity = 0, reflectance = 0, map = 0;
    for (int c = 0; c < 3; ++c) {
      radiosity += optics.exitance[c] + optics.reflectance[c] * leaf.irradiance[c];
      reflectance = std::max(reflectance, optics.reflectance[c]);
      map += optics.exitance_deviation[c] + optics.reflectance_deviation[c] * leaf.irradiance[c];
    }
    // Half the range of a value that is spread evenly with this deviation.
    double half = 0.5 * reflectance * leaf.spread + std::sqrt(3.0) * map;
    if (!passed.empty()) {
      radiosity += Sum(passed[k].radiosity);
      half += 0.5 * passed[k].spread;
    }
    moments[node] = {radiosity, radiosity * radiosity + half * half / 3,
                     std::max(0.0, radiosity - half), radiosity + half};
  }
  const auto pull = [&](uint32_t i) {
    Moments sum{0, 0, std::numeric_limits<double>::infinity(), 0};
    double area = 0;
    bool any = false;
    ForEachChild(i, [&](uint32_t child) {
      any = true;
      const Moments& m = moments[child];
      sum.mean += area_m2_[child] * m.mean;
      sum.square += area_m2_[child] * m.square;
      sum.low = std::min(sum.low, m.low);
      sum.high = std::max(sum.high, m.high);
      area += area_m2_[child];
    });
    if (any && area > 0) moments[i] = {sum.mean / area, sum.square / area, sum.low, sum.high};
  };
  for (size_t i = count; i-- > cluster_count_;) pull(static_cast<uint32_t>(i));
  for (size_t i = cluster_count_; i-- > 0;) pull(static_cast<uint32_t>(i));
  for (size_t i = 0; i < count; ++i) {
    const Moments& m = moments[i];
    const double variance = std::max(0.0, m.square - m.mean * m.mean);
    values_[i] = {static_cast<float>(m.mean), static_cast<float>(m.high - m.low),
                  static_cast<float>(std::sqrt(variance))};
  }
}

uint64_t Tree::memory_bytes() const {
  return nodes_.size() * (sizeof(Node) + sizeof(NodeValues) + sizeof(double) + sizeof(uint32_t)) +
         polygons_.size() * (sizeof(ConvexPolygon) + sizeof(Vec3) + sizeof(double));
}

}  // namespace isolux
