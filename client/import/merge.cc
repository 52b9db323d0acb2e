#include "client/import/merge.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace isolux {
namespace {

// Corners off the common plane, over the diagonal. Coordinates printed with six digits move corners
// by as much; it stays below what the solver allows a quad (kPlanarTolerance).
constexpr double kCoplanar = 1e-5;
// Sine of the least turn at a corner: a straighter one would make a triangle with a split side.
constexpr double kLeastTurn = 0.01;

struct Edge {
  uint32_t low = 0, high = 0;  // vertices
  uint32_t triangle = 0;       // polygon of the scene
  uint8_t opposite = 0;        // its corner that is not on the edge
};

struct Pair {
  double quality = 0;
  std::array<uint32_t, 2> triangles{};
  std::array<uint32_t, 4> quad{};
};

// 4π A / perimeter²: 1 for a disk, 0.79 for a square, near 0 for slivers.
double Roundness(const ConvexPolygon& polygon) {
  double perimeter = 0;
  for (int i = 0; i < polygon.count; ++i) {
    perimeter += glm::length(polygon.v[(i + 1) % polygon.count] - polygon.v[i]);
  }
  return 4 * M_PI * polygon.Area() / (perimeter * perimeter);
}

bool TurnsEverywhere(const ConvexPolygon& quad) {
  const Vec3 normal = quad.Normal();
  for (int i = 0; i < 4; ++i) {
    const Vec3 in = quad.v[i] - quad.v[(i + 3) % 4];
    const Vec3 out = quad.v[(i + 1) % 4] - quad.v[i];
    const double sine = glm::dot(glm::cross(in, out), normal);
    if (sine < kLeastTurn * glm::length(in) * glm::length(out)) return false;
  }
  return true;
}

bool IsFlat(const ConvexPolygon& quad, const Vec3& normal) {
  const double diagonal =
      std::max(glm::length(quad.v[2] - quad.v[0]), glm::length(quad.v[3] - quad.v[1]));
  for (int i = 1; i < 4; ++i) {
    if (std::abs(glm::dot(quad.v[i] - quad.v[0], normal)) > kCoplanar * diagonal) return false;
  }
  return true;
}

std::optional<Pair> Join(const Scene& scene, const Edge& a, const Edge& b) {
  const Polygon& first = scene.polygons[a.triangle];
  const Polygon& second = scene.polygons[b.triangle];
  if (first.material != second.material || first.sides != second.sides) return std::nullopt;
  // From the corner off the edge: apex, start of the edge, apex of the other, end of the edge.
  const uint32_t start = first.vertices[(a.opposite + 1) % 3];
  const uint32_t end = first.vertices[(a.opposite + 2) % 3];
  if (second.vertices[(b.opposite + 1) % 3] != end) return std::nullopt;  // not wound alike
  Pair pair;
  pair.triangles = {a.triangle, b.triangle};
  pair.quad = {first.vertices[a.opposite], start, second.vertices[b.opposite], end};
  ConvexPolygon quad{4, {}};
  for (int i = 0; i < 4; ++i) quad.v[i] = scene.vertices[pair.quad[i]];
  const ConvexPolygon one = SideGeometry(scene, a.triangle, Side::kFront);
  const ConvexPolygon two = SideGeometry(scene, b.triangle, Side::kFront);
  if (!IsFlat(quad, one.Normal()) || !IsFlat(quad, two.Normal()) || !TurnsEverywhere(quad)) {
    return std::nullopt;
  }
  pair.quality = Roundness(quad);
  if (pair.quality < std::min(Roundness(one), Roundness(two))) return std::nullopt;
  return pair;
}

std::vector<Edge> SortedEdges(const Scene& scene) {
  std::vector<Edge> edges;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    if (polygon.vertex_count() != 3) continue;
    for (uint8_t i = 0; i < 3; ++i) {
      const uint32_t a = polygon.vertices[(i + 1) % 3];
      const uint32_t b = polygon.vertices[(i + 2) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), p, i});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return edges;
}

std::vector<Pair> FindPairs(const Scene& scene) {
  const std::vector<Edge> edges = SortedEdges(scene);
  std::vector<Pair> pairs;
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high)
      ++end;
    if (end - i == 2) {  // where more meet, which belong together is anyone's guess
      if (const auto pair = Join(scene, edges[i], edges[i + 1])) pairs.push_back(*pair);
    }
    i = end;
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(b.quality, a.triangles) < std::tie(a.quality, b.triangles);
  });
  return pairs;
}

}  // namespace

uint64_t MergeTrianglePairs(Scene* scene) {
  constexpr uint32_t kGone = 0xffffffffu;
  std::vector<bool> taken(scene->polygons.size(), false);
  uint64_t merged = 0;
  for (const Pair& pair : FindPairs(*scene)) {
    const auto [first, second] = std::minmax(pair.triangles[0], pair.triangles[1]);
    if (taken[first] || taken[second]) continue;
    taken[first] = taken[second] = true;
    Polygon& kept = scene->polygons[first];
    Polygon& gone = scene->polygons[second];
    kept.vertices = pair.quad;
    kept.file_polygon = std::min(kept.file_polygon, gone.file_polygon);
    gone.material = kGone;
    ++merged;
  }
  std::erase_if(scene->polygons, [](const Polygon& p) { return p.material == kGone; });
  return merged;
}

}  // namespace isolux
