#include "worker/radiosity/openings.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "common/util/random.h"

namespace isolux {
namespace {

constexpr size_t kMostPackets = 16384;  // over all free edges
constexpr size_t kPacketsOfAnEdge = 8;  // at most
// Points nearer to an edge than this many times the noise of coordinates may be anywhere.
constexpr double kClearOfNoise = 16;

struct Edge {
  uint32_t low = 0, high = 0;  // vertices
  uint32_t polygon = 0;
  int corner = 0;  // where it begins
};

std::vector<Edge> FreeEdges(const Scene& scene) {
  std::vector<Edge> edges;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    for (int k = 0; k < polygon.vertex_count(); ++k) {
      const uint32_t a = polygon.vertices[k],
                     b = polygon.vertices[(k + 1) % polygon.vertex_count()];
      edges.push_back({std::min(a, b), std::max(a, b), p, k});
    }
  }
  const auto order = [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.polygon, a.corner) <
           std::tie(b.low, b.high, b.polygon, b.corner);
  };
  const auto same = [](const Edge& a, const Edge& b) { return a.low == b.low && a.high == b.high; };
  std::sort(edges.begin(), edges.end(), order);
  std::vector<Edge> free;
  for (size_t i = 0; i < edges.size(); ++i) {
    const bool before = i > 0 && same(edges[i - 1], edges[i]);
    const bool after = i + 1 < edges.size() && same(edges[i + 1], edges[i]);
    if (!before && !after) free.push_back(edges[i]);
  }
  return free;
}

using Pairs = std::vector<std::pair<uint32_t, uint32_t>>;  // of surfaces

class Looker {
 public:
  Looker(const Hierarchy& hierarchy, const RayScene& rays)
      : scene_(hierarchy.scene()),
        rays_(rays),
        surface_of_(scene_.polygons.size(), {kNone, kNone}) {
    for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
      const Surface& surface = hierarchy.surfaces()[s];
      surface_of_[surface.polygon][static_cast<int>(surface.side)] = s;
    }
  }

  // What a packet of pairs of rays from beyond the edge finds.
  void Look(const Edge& edge, Random& random, Pairs* found) const {
    const Polygon& polygon = scene_.polygons[edge.polygon];
    const int count = polygon.vertex_count();
    const auto corner = [&](int k) { return scene_.vertices[polygon.vertices[k % count]]; };
    const Vec3 from = corner(edge.corner), along = corner(edge.corner + 1) - from;
    const double length = glm::length(along);
    const Vec3 n = Normal(polygon);
    if (!(length > 0) || !(glm::length(n) > 0)) return;
    const Vec3 beyond = glm::cross(along / length, n);
    std::array<Escape, RayScene::kPacket> one, other;
    for (int i = 0; i < RayScene::kPacket; ++i) {
      const double u = random.Unit(), v = random.Unit();
      const double away = std::max(length * v * v, kClearOfNoise * rays_.coordinate_noise_m());
      const Vec3 point = from + u * along + away * beyond;
      Vec3 direction(0.0);
      do {
        direction = Vec3(2 * random.Unit() - 1, 2 * random.Unit() - 1, 2 * random.Unit() - 1);
      } while (glm::dot(direction, direction) > 1 || glm::dot(direction, direction) < 1e-6);
      direction = glm::normalize(direction);
      one[i] = {point, direction, edge.polygon};
      other[i] = {point, -direction, edge.polygon};
    }
    const auto ahead = rays_.Trace(one, RayScene::kPacket);
    const auto behind = rays_.Trace(other, RayScene::kPacket);
    for (int i = 0; i < RayScene::kPacket; ++i) {
      const uint32_t a = SurfaceOf(ahead[i]), b = SurfaceOf(behind[i]);
      if (a == kNone || b == kNone) continue;
      // The rays pass over what lies in the edge's own plane: the neighbour across a longer edge.
      const Segment segment{Meet(one[i], ahead[i].polygon), Meet(other[i], behind[i].polygon),
                            ahead[i].polygon, behind[i].polygon};
      if (rays_.Visible(segment)) found->emplace_back(a, b);
    }
  }

 private:
  static constexpr uint32_t kNone = 0xffffffffu;

  Vec3 Normal(const Polygon& polygon) const {
    const auto& v = polygon.vertices;
    const Vec3 n = glm::cross(
        scene_.vertices[v[2]] - scene_.vertices[v[0]],
        scene_.vertices[polygon.vertex_count() == 4 ? v[3] : v[2]] - scene_.vertices[v[1]]);
    const double length = glm::length(n);
    return length > 0 ? n / length : Vec3(0.0);
  }

  uint32_t SurfaceOf(const RayHit& hit) const {
    return hit.polygon == RayHit::kNothing ? kNone
                                           : surface_of_[hit.polygon][static_cast<int>(hit.side)];
  }

  Vec3 Meet(const Escape& ray, uint32_t polygon) const {
    const Vec3 n = Normal(scene_.polygons[polygon]);
    const Vec3 corner = scene_.vertices[scene_.polygons[polygon].vertices[0]];
    const double towards = glm::dot(n, ray.direction);
    return towards != 0 ? ray.from + glm::dot(n, corner - ray.from) / towards * ray.direction
                        : ray.from;
  }

  const Scene& scene_;
  const RayScene& rays_;
  std::vector<std::array<uint32_t, 2>> surface_of_;  // by polygon and side
};

bool OneComponent(size_t surfaces, DisjointSets* components) {
  for (uint32_t s = 0; s < surfaces; ++s) {
    if (components->Find(s) != 0) return false;
  }
  return true;
}

}  // namespace

void JoinPastFreeEdges(const Hierarchy& hierarchy, const RayScene& rays, uint64_t seed,
                       ThreadPool& pool, DisjointSets* components) {
  if (OneComponent(hierarchy.surfaces().size(), components)) return;
  const std::vector<Edge> edges = FreeEdges(hierarchy.scene());
  if (edges.empty()) return;
  const size_t packets = std::clamp<size_t>(kMostPackets / edges.size(), 1, kPacketsOfAnEdge);
  // Where there are too many edges, evenly spread ones.
  const size_t looked_at = std::min(edges.size(), kMostPackets);
  const Looker looker(hierarchy, rays);
  std::vector<Pairs> found(looked_at);
  pool.For(looked_at, 64, [&](size_t begin, size_t end, int) {
    for (size_t i = begin; i < end; ++i) {
      const Edge& edge = edges[i * edges.size() / looked_at];
      Random random(Hash(seed, 0xedfeu, Hash(edge.polygon, edge.corner)));
      for (size_t k = 0; k < packets; ++k) looker.Look(edge, random, &found[i]);
    }
  });
  for (const Pairs& pairs : found) {
    for (const auto& [a, b] : pairs) components->Join(a, b);
  }
}

}  // namespace isolux
