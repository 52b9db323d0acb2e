// The polygons of a scene in Embree, and packets of eight rays through them. A packet is the unit:
// the eight rays of a link belong together and are traced together.
//
// Hits are rejected by identity: a ray never hits the polygons it runs between, nor any polygon in
// their planes; nothing is moved along a normal.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "common/hierarchy/hierarchy.h"
#include "worker/coupling/float_lanes.h"

namespace isolux {

// A segment from a point on one polygon to a point on another.
struct Segment {
  Vec3 from{0.0}, to{0.0};
  uint32_t from_polygon = 0, to_polygon = 0;
};

// Eight segments.
struct RayPacket {
  std::array<FloatLanes, 3> from{}, to{};  // by axis
  std::array<uint32_t, 8> from_polygon{}, to_polygon{};
  uint32_t valid = 0;  // by bits: those that count

  void Set(int i, const Segment& segment);
};

// A ray that leaves a polygon, to wherever it goes.
struct Escape {
  Vec3 from{0.0}, direction{0.0};
  uint32_t from_polygon = 0;
};

struct RayHit {
  static constexpr uint32_t kNothing = 0xffffffffu;
  uint32_t polygon = kNothing;
  Side side = Side::kFront;  // that is met
  double distance = 0;       // in lengths of the ray's direction
};

class RayScene {
 public:
  static constexpr int kPacket = 8;

  // Keeps a pointer to the hierarchy. Thread-safe after construction.
  explicit RayScene(const Hierarchy& hierarchy);
  ~RayScene();

  // What rounding leaves of coordinates in single precision: hits so near an end of a segment do
  // not count.
  double coordinate_noise_m() const;

  // Bit i is set where segment i counts and is free of obstacles.
  uint32_t Visible(const RayPacket& packet) const;
  bool Visible(const Segment& segment) const;

  // What each ray meets first. count ≤ 8.
  std::array<RayHit, kPacket> Trace(const std::array<Escape, kPacket>& rays, int count) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isolux
