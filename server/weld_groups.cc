#include "server/weld_groups.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "common/hierarchy/planes.h"
#include "common/scene/box_tree.h"

namespace isolux {
namespace {

struct Edge {
  Vec3 from, to;
  uint32_t polygon = 0;
};

// Of panes of glass, too: light changes abruptly along what they touch.
std::vector<Edge> EdgesOf(const Scene& scene) {
  std::vector<Edge> edges;
  for (uint32_t p = 0; p < scene.polygons.size() + scene.glazing.panes.size(); ++p) {
    const ConvexPolygon shape = ShapeOf(scene, p);
    for (int i = 0; i < shape.count; ++i)
      edges.push_back({shape.v[i], shape.v[(i + 1) % shape.count], p});
  }
  return edges;
}

std::vector<Bounds3> BoxesOf(const std::vector<Edge>& edges) {
  std::vector<Bounds3> boxes(edges.size());
  for (size_t e = 0; e < edges.size(); ++e) {
    boxes[e].Add(edges[e].from);
    boxes[e].Add(edges[e].to);
  }
  return boxes;
}

using Interval = std::pair<double, double>;

double Length(const std::vector<Interval>& disjoint) {
  double sum = 0;
  for (const auto& [low, high] : disjoint) sum += high - low;
  return sum;
}

// The union of intervals as disjoint ones.
std::vector<Interval> Union(std::vector<Interval> intervals) {
  std::sort(intervals.begin(), intervals.end());
  std::vector<Interval> joined;
  for (const Interval& interval : intervals) {
    if (joined.empty() || interval.first > joined.back().second) {
      joined.push_back(interval);
    } else {
      joined.back().second = std::max(joined.back().second, interval.second);
    }
  }
  return joined;
}

class GroupFinder {
 public:
  explicit GroupFinder(const Hierarchy& hierarchy)
      : hierarchy_(hierarchy),
        edges_(EdgesOf(hierarchy.scene())),
        tree_(BoxesOf(edges_)),
        parent_(hierarchy.surfaces().size()),
        surfaces_of_(hierarchy.scene().polygons.size()) {
    std::iota(parent_.begin(), parent_.end(), 0U);
    for (uint32_t s = 0; s < parent_.size(); ++s)
      surfaces_of_[hierarchy.surfaces()[s].polygon].push_back(s);
  }

  std::vector<uint32_t> Run() {
    FindAlike();
    for (const Edge& edge : edges_) {
      if (IsPane(edge)) break;
      for (const uint32_t s : surfaces_of_[edge.polygon]) JoinAcross(s, edge);
    }
    std::map<uint32_t, uint32_t> numbers;
    std::vector<uint32_t> groups(parent_.size());
    for (uint32_t s = 0; s < groups.size(); ++s) {
      const auto next = static_cast<uint32_t>(numbers.size());
      groups[s] = numbers.try_emplace(Find(s), next).first->second;
    }
    return groups;
  }

 private:
  // By plane, side, material, texture coordinates and what they do with light.
  void FindAlike() {
    const std::span<const Surface> surfaces = hierarchy_.surfaces();
    std::map<uint32_t, Vec3> normals;  // of a plane: that of its first surface
    std::map<std::tuple<uint32_t, bool, uint32_t, uint32_t, bool, bool>, uint32_t> numbers;
    alike_.resize(surfaces.size());
    for (uint32_t s = 0; s < surfaces.size(); ++s) {
      const uint32_t plane = hierarchy_.plane_of(surfaces[s].polygon);
      const Vec3 normal = hierarchy_.geometry(s).AreaVector();
      const Vec3& reference = normals.try_emplace(plane, normal).first->second;
      const Polygon& polygon = hierarchy_.scene().polygons[surfaces[s].polygon];
      const auto key = std::make_tuple(plane, glm::dot(normal, reference) > 0, polygon.material,
                                       polygon.coordinates, surfaces[s].exitance != Rgb(0.0),
                                       surfaces[s].reflectance != Rgb(0.0));
      const auto next = static_cast<uint32_t>(numbers.size());
      alike_[s] = numbers.try_emplace(key, next).first->second;
    }
  }

  // Joins a surface with those beyond one of its edges, where some of what they share is free.
  void JoinAcross(uint32_t s, const Edge& edge) {
    const Vec3 normal = hierarchy_.geometry(s).Normal();
    const uint32_t plane = hierarchy_.plane_of(edge.polygon);
    const double length = glm::length(edge.to - edge.from);
    const double tolerance = ContactTolerance(hierarchy_.extent_m(), length);
    Bounds3 box;
    box.Add(edge.from);
    box.Add(edge.to);
    std::vector<Interval> blocked;
    std::vector<std::pair<uint32_t, Interval>> beyond;  // surface, what is shared with it
    tree_.ForEachOverlap(Widened(box, tolerance), [&](uint32_t e) {
      const Edge& other = edges_[e];
      if (other.polygon == edge.polygon) return;
      const Interval shared = Shared(edge, other, length, tolerance);
      if (shared.second - shared.first <= tolerance) return;
      if (IsPane(other) || hierarchy_.plane_of(other.polygon) != plane) {
        const Vec3 centre = ShapeOf(hierarchy_.scene(), other.polygon).Centroid();
        if (glm::dot(normal, centre - edge.from) > tolerance) blocked.push_back(shared);
        return;
      }
      for (const uint32_t t : surfaces_of_[other.polygon]) {
        if (alike_[t] == alike_[s]) beyond.emplace_back(t, shared);
      }
    });
    const double taken = Length(Union(blocked));
    for (const auto& [t, shared] : beyond) {
      std::vector<Interval> with = blocked;
      with.push_back(shared);
      if (Length(Union(std::move(with))) > taken + tolerance) Join(s, t);
    }
  }

  // The part of an edge, in metres from its start, along which another runs; empty where none.
  static Interval Shared(const Edge& edge, const Edge& other, double length, double tolerance) {
    const Vec3 along = (edge.to - edge.from) / length;
    double low = glm::dot(other.from - edge.from, along);
    double high = glm::dot(other.to - edge.from, along);
    Vec3 at_low = other.from, at_high = other.to;
    if (low > high) {
      std::swap(low, high);
      std::swap(at_low, at_high);
    }
    if (!(high - low > tolerance)) return {0, 0};
    const Vec3 slope = (at_high - at_low) / (high - low);
    const Interval shared{std::max(low, 0.0), std::min(high, length)};
    for (const double t : {shared.first, shared.second}) {
      const Vec3 off = at_low + (t - low) * slope - (edge.from + t * along);
      if (glm::length(off) > tolerance) return {0, 0};
    }
    return shared;
  }

  bool IsPane(const Edge& edge) const { return edge.polygon >= hierarchy_.scene().polygons.size(); }

  uint32_t Find(uint32_t s) {
    while (parent_[s] != s) s = parent_[s] = parent_[parent_[s]];
    return s;
  }
  void Join(uint32_t s, uint32_t t) {
    s = Find(s);
    t = Find(t);
    parent_[std::max(s, t)] = std::min(s, t);
  }

  const Hierarchy& hierarchy_;
  std::vector<Edge> edges_;
  BoxTree tree_;
  std::vector<uint32_t> parent_, alike_;  // of surfaces
  std::vector<std::vector<uint32_t>> surfaces_of_;
};

}  // namespace

std::vector<uint32_t> FindWeldGroups(const Hierarchy& hierarchy) {
  return GroupFinder(hierarchy).Run();
}

}  // namespace isolux
