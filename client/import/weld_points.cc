#include "client/import/weld_points.h"

#include <algorithm>
#include <limits>

#include "common/hierarchy/planes.h"
#include "common/scene/box_tree.h"

namespace isolux {
namespace {

constexpr double kWeldOfExtent = 1e-6;

// The shortest side of a face at each vertex.
std::vector<double> ShortestSides(const SceneFile& file, const std::vector<uint32_t>& vertex_of,
                                  const std::vector<Vec3>& vertices) {
  std::vector<double> shortest(vertices.size(), std::numeric_limits<double>::infinity());
  for (const FileFace& face : file.faces) {
    for (uint32_t i = 0; i < face.count; ++i) {
      const uint32_t a = vertex_of[file.corners[face.first + i]];
      const uint32_t b = vertex_of[file.corners[face.first + (i + 1) % face.count]];
      if (a == b) continue;
      const double length = glm::length(vertices[a] - vertices[b]);
      shortest[a] = std::min(shortest[a], length);
      shortest[b] = std::min(shortest[b], length);
    }
  }
  return shortest;
}

}  // namespace

uint64_t JoinNearPoints(const SceneFile& file, std::vector<uint32_t>* vertex_of,
                        std::vector<Vec3>* vertices) {
  const std::vector<double> shortest = ShortestSides(file, *vertex_of, *vertices);
  std::vector<Bounds3> boxes;
  Bounds3 all;
  for (const Vec3& v : *vertices) {
    boxes.push_back({v, v});
    all.Add(v);
  }
  const BoxTree tree(boxes);
  const double reach = kWeldOfExtent * all.Diagonal();
  std::vector<uint32_t> leader(vertices->size());
  uint64_t joined = 0;
  for (uint32_t v = 0; v < leader.size(); ++v) {
    leader[v] = v;
    tree.ForEachOverlap(Widened(boxes[v], reach), [&](uint32_t other) {
      if (other >= leader[v] || leader[other] != other) return;
      const double most = std::min(reach, kContactOfSize * std::min(shortest[v], shortest[other]));
      if (glm::length((*vertices)[v] - (*vertices)[other]) <= most) leader[v] = other;
    });
    if (leader[v] != v) ++joined;
  }
  if (joined == 0) return 0;
  std::vector<uint32_t> number(leader.size());
  uint32_t count = 0;
  for (uint32_t v = 0; v < leader.size(); ++v) {
    if (leader[v] == v) (*vertices)[count] = (*vertices)[v];
    number[v] = leader[v] == v ? count++ : number[leader[v]];
  }
  vertices->resize(count);
  for (uint32_t& v : *vertex_of) {
    if (v != kNoVertex) v = number[v];
  }
  return joined;
}

}  // namespace isolux
