// Corners of many faces → shared vertices, without cracks. Faces belong to groups (coplanar, one
// material, one side); vertices are shared within a group only. For the coordinator's output mesh;
// one thread. The result depends on the order of the calls alone.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/vec.h"

namespace isolux {

// Finds the vertex for a corner by a spatial hash: exact, neighbouring cells included.
class Welder {
 public:
  // Corners of a group no farther apart than `tolerance` become one vertex. `low` is the low corner
  // of all positions to come.
  Welder(double tolerance, const Vec3& low, size_t expected_vertices);

  // The lowest-numbered vertex of the group within the tolerance, or a new one.
  uint32_t Vertex(const Vec3& position, uint32_t group);

  std::span<const Vec3> positions() const { return positions_; }
  std::span<const uint32_t> groups() const { return groups_; }
  double tolerance() const { return tolerance_; }

 private:
  uint32_t& Bucket(const std::array<int64_t, 3>& cell, uint32_t group);
  void Grow();

  double tolerance_, cell_size_;
  Vec3 low_;
  std::vector<Vec3> positions_;
  std::vector<uint32_t> groups_;
  std::vector<uint64_t> hashes_;          // of each vertex' cell and group
  std::vector<uint32_t> buckets_, next_;  // chains of vertices
};

// A vertex inside the side of a face that goes from its corner `side` to the next.
struct TVertex {
  uint32_t face = 0;
  uint32_t side = 0;
  double along = 0;  // in (0, 1)
  uint32_t vertex = 0;
};

inline constexpr uint32_t kNoCorner = 0xffffffffu;

// All vertices that lie on sides of faces of their group without being their ends, by face, side
// and place along the side. Faces are triangles (last corner kNoCorner) or quads, and overlap
// nowhere.
std::vector<TVertex> FindTVertices(const Welder& welder,
                                   std::span<const std::array<uint32_t, 4>> faces);

}  // namespace isolux
