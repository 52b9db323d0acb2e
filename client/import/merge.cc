#include "client/import/merge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "common/hierarchy/planes.h"
#include "common/hierarchy/regions.h"

namespace isolux {
namespace {

// Corners off the common plane, over the diagonal. Coordinates printed with six digits move corners
// by as much; it stays below what the solver allows a quad (kPlanarTolerance).
constexpr double kCoplanar = 1e-5;
// Sine of the least turn at a corner: a straighter one would make a triangle with a split side.
constexpr double kLeastTurn = 0.01;
// A region is divided anew where that leaves no more than this share of its triangles, and none
// with less area over squared longest side than this, or than it had before.
constexpr double kWorthwhile = 0.6, kLeastShape = 0.003;
// Corners of an outline so near a line count as on it, over the scene's extent.
constexpr double kStraightOfExtent = 1e-7;

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
  if (first.material != second.material || first.sides != second.sides ||
      first.coordinates != second.coordinates) {
    return std::nullopt;
  }
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

// Triangles, a quad counting as two.
size_t TriangleCount(const Scene& scene, const Region& region) {
  size_t count = 0;
  for (const uint32_t p : region.polygons) count += scene.polygons[p].vertex_count() - 2;
  return count;
}

// The least of area over squared longest side.
double WorstShape(const Scene& scene, std::span<const std::array<uint32_t, 3>> triangles) {
  double worst = 1;
  for (const auto& t : triangles) {
    const Vec3 &a = scene.vertices[t[0]], &b = scene.vertices[t[1]], &c = scene.vertices[t[2]];
    const double longest2 =
        std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
    worst = std::min(worst, 0.5 * glm::length(glm::cross(b - a, c - a)) / longest2);
  }
  return worst;
}

double WorstShape(const Scene& scene, const Region& region) {
  double worst = 1;
  for (const uint32_t p : region.polygons) {
    const auto& v = scene.polygons[p].vertices;
    const std::array<std::array<uint32_t, 3>, 2> halves{{{v[0], v[1], v[2]}, {v[0], v[2], v[3]}}};
    const auto count = static_cast<size_t>(scene.polygons[p].vertex_count() - 2);
    worst = std::min(worst, WorstShape(scene, std::span(halves).first(count)));
  }
  return worst;
}

}  // namespace

RegionMerge MergeRegions(Scene* scene, std::vector<uint32_t>* plane_of) {
  std::vector<Loop> loops;
  std::vector<Vec3> normals;
  std::vector<uint64_t> key;
  std::map<std::tuple<uint32_t, uint32_t, uint8_t, uint32_t>, uint64_t> numbers;
  double straight = kStraightOfExtent * ExtentOf(*scene);
  for (uint32_t p = 0; p < scene->polygons.size(); ++p) {
    const Polygon& polygon = scene->polygons[p];
    loops.emplace_back(polygon.vertices.begin(), polygon.vertices.begin() + polygon.vertex_count());
    normals.push_back(SideGeometry(*scene, p, Side::kFront).Normal());
    // Of two orientations in one plane no edge runs both ways, so they need no keys of their own.
    key.push_back(
        numbers
            .try_emplace({(*plane_of)[p], polygon.material, polygon.sides, polygon.coordinates},
                         numbers.size())
            .first->second);
  }
  RegionMerge merge;
  std::vector<bool> gone(scene->polygons.size(), false);
  std::map<uint32_t, std::vector<Polygon>> made;  // by the polygon in whose place they come
  for (const Region& region : FindRegions(*scene, loops, key, normals)) {
    if (region.polygons.size() < 3) continue;
    const uint32_t first = region.polygons[0];
    double area = 0;
    uint32_t number = kNoVertex;
    for (const uint32_t p : region.polygons) {
      area += SideGeometry(*scene, p, Side::kFront).Area();
      number = std::min(number, scene->polygons[p].file_polygon);
    }
    const auto triangles = Retriangulate(*scene, region, normals[first], area, straight);
    if (!triangles || static_cast<double>(triangles->size()) >
                          kWorthwhile * static_cast<double>(TriangleCount(*scene, region)))
      continue;
    if (WorstShape(*scene, *triangles) < std::min(kLeastShape, WorstShape(*scene, region)))
      continue;
    for (const auto& t : *triangles) {
      Polygon polygon = scene->polygons[first];
      polygon.vertices = {t[0], t[1], t[2], kNoVertex};
      polygon.file_polygon = number;
      made[first].push_back(polygon);
    }
    for (const uint32_t p : region.polygons) gone[p] = true;
    if (merge.gone == 0) merge.first_polygon = number;
    merge.gone += region.polygons.size() - std::min(region.polygons.size(), triangles->size());
  }
  std::vector<Polygon> kept;
  std::vector<uint32_t> kept_planes;
  for (uint32_t p = 0; p < gone.size(); ++p) {
    if (!gone[p]) kept.push_back(scene->polygons[p]);
    if (const auto at = made.find(p); at != made.end()) {
      kept.insert(kept.end(), at->second.begin(), at->second.end());
    }
    kept_planes.resize(kept.size(), (*plane_of)[p]);
  }
  scene->polygons = std::move(kept);
  *plane_of = std::move(kept_planes);
  return merge;
}

uint64_t MergeTrianglePairs(Scene* scene, std::vector<uint32_t>* plane_of) {
  std::vector<bool> taken(scene->polygons.size(), false), gone(scene->polygons.size(), false);
  uint64_t merged = 0;
  for (const Pair& pair : FindPairs(*scene)) {
    const auto [first, second] = std::minmax(pair.triangles[0], pair.triangles[1]);
    if (taken[first] || taken[second]) continue;
    taken[first] = taken[second] = true;
    Polygon& kept = scene->polygons[first];
    const Polygon& other = scene->polygons[second];
    kept.vertices = pair.quad;
    kept.file_polygon = std::min(kept.file_polygon, other.file_polygon);
    gone[second] = true;
    ++merged;
  }
  EraseMarked(gone, &scene->polygons);
  if (plane_of != nullptr) EraseMarked(gone, plane_of);
  return merged;
}

}  // namespace isolux
