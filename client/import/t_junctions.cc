#include "client/import/t_junctions.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include "common/hierarchy/planes.h"
#include "common/scene/box_tree.h"

namespace isolux {
namespace {

struct Edge {
  uint32_t low = 0, high = 0, polygon = 0;
};

// Edges of one polygon only, by polygon.
std::vector<Edge> LoneEdges(const Scene& scene) {
  std::vector<Edge> edges;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    const int count = polygon.vertex_count();
    for (int i = 0; i < count; ++i) {
      const uint32_t a = polygon.vertices[i], b = polygon.vertices[(i + 1) % count];
      edges.push_back({std::min(a, b), std::max(a, b), p});
    }
  }
  const auto ends = [](const Edge& e) { return std::tie(e.low, e.high); };
  std::sort(edges.begin(), edges.end(), [&](const Edge& a, const Edge& b) {
    return ends(a) != ends(b) ? ends(a) < ends(b) : a.polygon < b.polygon;
  });
  std::vector<Edge> lone;
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && ends(edges[end]) == ends(edges[i])) ++end;
    if (end - i == 1) lone.push_back(edges[i]);
    i = end;
  }
  std::stable_sort(lone.begin(), lone.end(),
                   [](const Edge& a, const Edge& b) { return a.polygon < b.polygon; });
  return lone;
}

}  // namespace

TJunctions CountTJunctions(const Scene& scene) {
  const double extent = ExtentOf(scene);
  const std::vector<Edge> edges = LoneEdges(scene);
  std::vector<uint32_t> points;
  for (const Edge& e : edges) {
    points.push_back(e.low);
    points.push_back(e.high);
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::vector<Bounds3> boxes;
  for (const uint32_t v : points) boxes.push_back({scene.vertices[v], scene.vertices[v]});
  const BoxTree tree(boxes);
  TJunctions result;
  for (const Edge& e : edges) {
    const Vec3 &from = scene.vertices[e.low], &to = scene.vertices[e.high];
    const Vec3 along = to - from;
    const double length = glm::length(along);
    const double tolerance = ContactTolerance(extent, length);
    Bounds3 box;
    box.Add(from);
    box.Add(to);
    tree.ForEachOverlap(Widened(box, tolerance), [&](uint32_t i) {
      if (points[i] == e.low || points[i] == e.high) return;
      const Vec3 offset = scene.vertices[points[i]] - from;
      const double t = glm::dot(offset, along) / length;
      if (t <= tolerance || t >= length - tolerance) return;
      if (glm::length(glm::cross(offset, along)) > tolerance * length) return;
      if (result.count++ == 0) result.first_polygon = scene.polygons[e.polygon].file_polygon;
    });
  }
  return result;
}

}  // namespace isolux
