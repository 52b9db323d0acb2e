// The convex polygons that block, in double: what proofs of visibility, exact clipping and segments
// in `factors` test against. Any number of corners; both sides block.
//
// What lies in the plane of a surface and joins it edge to edge (a region: a wall, however it is
// tessellated, and its back) never blocks it, whatever the last digits of its coordinates.
// Every other distance is judged against tolerance_m(), 1e-12 of the scene's extent (the rounding
// of coordinates near its border is 1e-16), and against how far a polygon is from flat itself. So
// an occluder 1e-9 of the extent above a surface blocks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

inline constexpr uint32_t kNoRegion = 0xffffffffu;

struct Occluder {
  Vec3 normal{0.0};  // unit; counter-clockwise about it
  Vec3 point{0.0};   // on its plane
  Bounds3 bounds;
  double tolerance_m = 0;  // nearer to the plane than this is on it
  uint32_t first = 0;      // corner
  uint32_t count = 0;
  uint32_t region = kNoRegion;
  uint32_t plane = kNoRegion;  // of polygons of the scene (planes.h)

  double Height(const Vec3& x) const { return glm::dot(normal, x - point); }
};

class OccluderSet {
 public:
  // `extent_m`: of all that will be tested, ends of segments included.
  explicit OccluderSet(double extent_m) : tolerance_m_(1e-12 * extent_m) {}

  // Adds a convex, planar polygon. One without area is not added: it blocks nothing.
  void Add(std::span<const Vec3> corners, uint32_t region = kNoRegion, uint32_t plane = kNoRegion);

  uint32_t size() const { return static_cast<uint32_t>(occluders_.size()); }
  const Occluder& operator[](uint32_t i) const { return occluders_[i]; }
  std::span<const Vec3> corners(const Occluder& o) const { return {&corners_[o.first], o.count}; }
  // In the polygon's plane, of unit length, square to the side that leaves the corner, inwards.
  std::span<const Vec3> inwards(const Occluder& o) const { return {&inwards_[o.first], o.count}; }
  double tolerance_m() const { return tolerance_m_; }

  // Whether the open segment from x to y crosses the polygon, its border included.
  bool Blocks(uint32_t i, const Vec3& x, const Vec3& y) const;

 private:
  std::vector<Occluder> occluders_;
  std::vector<Vec3> corners_, inwards_;
  double tolerance_m_;
};

struct SceneOccluders {
  OccluderSet set;
  std::vector<uint32_t> region_of, plane_of;  // of each polygon of the scene
};
// All polygons of the scene, neighbours in one plane joined; the largest first, as lists of
// candidates are in order and large ones settle most.
SceneOccluders MakeOccluders(const Scene& scene);

}  // namespace isolux
