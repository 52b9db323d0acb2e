#include "common/hierarchy/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/hierarchy/element.h"
#include "common/hierarchy/planes.h"
#include "common/scene/translucency.h"
#include "common/util/check.h"

namespace isolux {
namespace {

constexpr int kMaxDepth = 32;  // of octree cells; deeper cells hold coincident centroids

// Divides polygons into octree cells. A polygon larger than half a cell would blow up the bounds of
// whatever small things share its cell, so such polygons form a child of their own, divided by
// centroid alone.
class OctreeBuilder {
 public:
  OctreeBuilder(const Scene& scene, std::vector<Cluster>* clusters)
      : clusters_(clusters), bounds_(scene.polygons.size()) {
    Bounds3 all;
    for (uint32_t p = 0; p < bounds_.size(); ++p) {
      bounds_[p] = BoundsOf(scene, p);
      all.Add(bounds_[p]);
    }
    std::vector<uint32_t> polygons(bounds_.size());
    std::iota(polygons.begin(), polygons.end(), 0U);
    const Vec3 extent = all.Extent();
    const double size = std::max({extent.x, extent.y, extent.z, 1e-300});
    clusters_->push_back({});
    members_.emplace_back();
    Divide(0, std::move(polygons), {all.Centre(), 0.5 * size}, 0, true);
  }

  // Polygons directly in each lowest cluster, in order.
  std::vector<std::vector<uint32_t>>& members() { return members_; }
  const Bounds3& bounds(uint32_t polygon) const { return bounds_[polygon]; }

 private:
  struct Cell {
    Vec3 centre;
    double half = 0;
  };

  Vec3 Centre(uint32_t polygon) const { return bounds_[polygon].Centre(); }

  void Divide(uint32_t cluster, std::vector<uint32_t> polygons, Cell cell, int depth,
              bool by_size) {
    if (polygons.size() <= Hierarchy::kLeafPolygons || depth >= kMaxDepth) {
      members_[cluster] = std::move(polygons);
      return;
    }
    std::array<std::vector<uint32_t>, 9> parts;  // eight octants and the large ones
    for (const uint32_t p : polygons) parts[Part(p, cell, by_size)].push_back(p);
    const auto octant = [&](int k) {
      const Vec3 sign((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1);
      return Cell{cell.centre + 0.5 * cell.half * sign, 0.5 * cell.half};
    };
    const auto filled =
        std::count_if(parts.begin(), parts.end(), [](const auto& p) { return !p.empty(); });
    if (filled == 1) {  // one child: the cell itself is skipped
      const int only = static_cast<int>(
          std::find_if(parts.begin(), parts.end(), [](const auto& p) { return !p.empty(); }) -
          parts.begin());
      if (only == 8) return Divide(cluster, std::move(parts[8]), cell, depth, false);
      return Divide(cluster, std::move(parts[only]), octant(only), depth + 1, by_size);
    }
    const auto first = static_cast<uint32_t>(clusters_->size());
    (*clusters_)[cluster].first_child = first;
    (*clusters_)[cluster].child_count = static_cast<uint32_t>(filled);
    clusters_->resize(first + filled);
    members_.resize(first + filled);
    uint32_t next = first;
    for (int k = 0; k < 9; ++k) {
      if (parts[k].empty()) continue;
      (*clusters_)[next].parent = cluster;
      const bool large = k == 8;
      Divide(next++, std::move(parts[k]), large ? cell : octant(k), depth + 1, by_size && !large);
    }
  }

  int Part(uint32_t polygon, const Cell& cell, bool by_size) const {
    if (by_size && bounds_[polygon].Diagonal() > cell.half) return 8;
    const Vec3 c = Centre(polygon);
    return (c.x >= cell.centre.x ? 1 : 0) | (c.y >= cell.centre.y ? 2 : 0) |
           (c.z >= cell.centre.z ? 4 : 0);
  }

  std::vector<Cluster>* clusters_;
  std::vector<Bounds3> bounds_;
  std::vector<std::vector<uint32_t>> members_;
};

// Whether each side that takes part has everything in front of it, or nothing.
bool IsConvex(const Scene& scene, std::span<const ConvexPolygon> surfaces, double extent) {
  const double tolerance = 1e-9 * extent;
  // Planes that are looked at already: the walls of a room may be made of many triangles.
  constexpr size_t kMostPlanes = 256;
  struct Plane {
    Vec3 normal, point;
  };
  std::vector<Plane> planes;
  for (const ConvexPolygon& surface : surfaces) {
    const Vec3 n = surface.Normal();
    const auto is_known = [&](const Plane& plane) {
      if (std::abs(glm::dot(n, plane.normal)) < 1 - 1e-15) return false;
      const auto corners = std::span(surface.v).first(static_cast<size_t>(surface.count));
      return std::ranges::all_of(corners, [&](const Vec3& corner) {
        return std::abs(glm::dot(plane.normal, corner - plane.point)) <= 0.1 * tolerance;
      });
    };
    if (std::ranges::any_of(planes, is_known)) continue;
    if (planes.size() < kMostPlanes) planes.push_back({n, surface.v[0]});
    bool front = false, behind = false;
    for (const Vec3& vertex : scene.vertices) {
      const double height = glm::dot(n, vertex - surface.v[0]);
      front |= height > tolerance;
      behind |= height < -tolerance;
      if (front && behind) return false;
    }
  }
  return true;
}

}  // namespace

Hierarchy::Hierarchy(const Scene& scene)
    : scene_(&scene), maps_(scene), surfaces_(MakeSurfaces(scene)) {
  OctreeBuilder octree(scene, &clusters_);
  const double extent = ExtentOf(scene);
  geometry_.reserve(surfaces_.size());
  area_m2_.reserve(surfaces_.size());
  std::vector<uint32_t> first_of(scene.polygons.size() + 1, 0);
  for (const Surface& surface : surfaces_) {
    geometry_.push_back(SideGeometry(scene, surface.polygon, surface.side));
    if (surface.side == Side::kBack && IsSheet(scene, scene.polygons[surface.polygon])) {
      geometry_.back() = FromBehind(SideGeometry(scene, surface.polygon, Side::kFront));
    }
    area_m2_.push_back(geometry_.back().Area());
    emitted_w_ += area_m2_.back() * surface.exitance;
    ++first_of[surface.polygon + 1];
  }
  std::partial_sum(first_of.begin(), first_of.end(), first_of.begin());

  // Hand out ranges of surfaces to the clusters in depth-first order, so that each cluster's are
  // consecutive.
  cluster_of_.resize(surfaces_.size());
  surface_order_.reserve(surfaces_.size());
  std::vector<uint32_t> stack{0};
  while (!stack.empty()) {
    const uint32_t c = stack.back();
    stack.pop_back();
    Cluster& cluster = clusters_[c];
    cluster.first_surface = static_cast<uint32_t>(surface_order_.size());
    for (uint32_t i = cluster.child_count; i-- > 0;) stack.push_back(cluster.first_child + i);
    for (const uint32_t polygon : octree.members()[c]) {
      cluster.bounds.Add(octree.bounds(polygon));
      for (uint32_t s = first_of[polygon]; s < first_of[polygon + 1]; ++s) {
        surface_order_.push_back(s);
        cluster_of_[s] = c;
        cluster.area_m2 += area_m2_[s];
      }
    }
    cluster.surface_count = static_cast<uint32_t>(surface_order_.size()) - cluster.first_surface;
  }
  for (size_t c = clusters_.size(); c-- > 0;) {
    Cluster& cluster = clusters_[c];
    for (uint32_t i = 0; i < cluster.child_count; ++i) {
      const Cluster& child = clusters_[cluster.first_child + i];
      cluster.bounds.Add(child.bounds);
      cluster.area_m2 += child.area_m2;
      cluster.surface_count += child.surface_count;
    }
  }
  plane_of_ = FindPlanes(scene);
  convex_ = IsConvex(scene, geometry_, extent);
}

void Hierarchy::TakeOptics(const Scene& scene) {
  CHECK_EQ(scene.polygons.size(), scene_->polygons.size());
  scene_ = &scene;
  const bool follow = maps_.follows_reflectance();
  maps_ = SurfaceMaps(scene);
  maps_.FollowReflectance(follow);
  surfaces_ = MakeSurfaces(scene);
  CHECK_EQ(surfaces_.size(), geometry_.size());
  emitted_w_ = Rgb(0.0);
  for (size_t s = 0; s < surfaces_.size(); ++s) emitted_w_ += area_m2_[s] * surfaces_[s].exitance;
}

}  // namespace isolux
