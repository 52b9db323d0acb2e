// The fixed upper part of the tree: root cluster → octree clusters → surfaces. Built alike by every
// process from the scene alone. Cells with one child are skipped; the lowest clusters hold
// surfaces, all others hold clusters. Elements below surfaces come and go with the solution and are
// not here.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/node_id.h"
#include "common/scene/scene.h"
#include "common/scene/surface_maps.h"

namespace isolux {

struct Cluster {
  static constexpr uint32_t kNone = 0xffffffffu;

  Bounds3 bounds;
  uint32_t parent = kNone;
  uint32_t first_child = 0;                       // cluster number; children are consecutive
  uint32_t child_count = 0;                       // 0: holds surfaces
  uint32_t first_surface = 0, surface_count = 0;  // range of Hierarchy::surface_order, all below it
  double area_m2 = 0;                             // of all surfaces below, both sides counted
};

class Hierarchy {
 public:
  static constexpr uint32_t kLeafPolygons = 8;  // a cell with no more polygons is not divided

  // Keeps a pointer to the scene: it must outlive the hierarchy.
  explicit Hierarchy(const Scene& scene);

  // Takes what surfaces reflect and emit, and all light, from a scene of the same polygons, which
  // must outlive the hierarchy in the place of the first. Nodes and geometry stay as they are.
  void TakeOptics(const Scene& scene);

  const Scene& scene() const { return *scene_; }
  std::span<const Surface> surfaces() const { return surfaces_; }
  std::span<const Cluster> clusters() const {
    return clusters_;
  }  // parents before children; [0] the root
  // Surfaces in the order of the clusters that hold them.
  std::span<const uint32_t> surface_order() const { return surface_order_; }
  uint32_t cluster_of(uint32_t surface) const { return cluster_of_[surface]; }

  const ConvexPolygon& geometry(uint32_t surface) const { return geometry_[surface]; }
  // Reflectance and exitance over parts of surfaces.
  const SurfaceMaps& maps() const { return maps_; }
  // Whether reflectance maps count, else their means over surfaces; they do unless it is said here.
  void FollowTextures(bool follow) { maps_.FollowReflectance(follow); }
  double surface_area_m2(uint32_t surface) const { return area_m2_[surface]; }
  // Polygons with the same number lie in one plane (either orientation): no light passes between
  // them.
  uint32_t plane_of(uint32_t polygon) const { return plane_of_[polygon]; }
  // True where no polygon lies in front of a side that takes part but behind nothing: one convex
  // room, in which nothing can block.
  bool convex() const { return convex_; }
  // Of all lamps, W a channel.
  const Rgb& emitted_w() const { return emitted_w_; }
  double extent_m() const { return clusters_[0].bounds.Diagonal(); }

 private:
  const Scene* scene_;
  SurfaceMaps maps_;
  std::vector<Surface> surfaces_;
  std::vector<ConvexPolygon> geometry_;
  std::vector<double> area_m2_;
  Rgb emitted_w_{0.0};
  std::vector<Cluster> clusters_;
  std::vector<uint32_t> surface_order_, cluster_of_, plane_of_;
  bool convex_ = false;
};

}  // namespace isolux
