// Points on the surfaces of a scene, and the elements that stand for them when a shard is asked
// what arrives there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/output/reference_points.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/node_id.h"
#include "common/hierarchy/shard_data.h"

namespace isolux::testing {

struct PointOnSurface {
  NodeId element;           // a speck at the point: Shard::Gather at its first corner is there
  Vec3 position_m{0.0};     // in the scene's place
  ReferencePoint expected;  // in the file's place and unit
};

// Seeded, one in each of equal parts of the area of all surfaces; sorted by element. Nothing is
// expected of them yet.
std::vector<PointOnSurface> UniformPoints(const Hierarchy& hierarchy, uint64_t count,
                                          uint64_t seed);

// Places points of a file on the surfaces, sorted by element. Those on no surface are left out.
std::vector<PointOnSurface> PlacePoints(const Hierarchy& hierarchy,
                                        std::span<const ReferencePoint> points);

std::vector<NodeId> ElementsOf(std::span<const PointOnSurface> points);

// Irradiance at the first corner of the i-th element, W/m².
Rgb IrradianceOf(const GatherPart& part, size_t i);

}  // namespace isolux::testing
