#include "common/hierarchy/regions.h"
#include "common/util/disjoint_sets.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/scene/plane_frame.h"
#include "common/scene/triangulate.h"
#include "common/util/disjoint_sets.h"

namespace isolux {
namespace {

constexpr uint32_t kNone = 0xffffffffu;
constexpr size_t kMostCorners = 400;  // of an outline: cutting ears takes its square and more
constexpr size_t kMostHoles = 32;
// Sine by which a corner may turn the wrong way and still count as straight.
constexpr double kStraight = 1e-6;

struct HalfEdge {
  uint32_t low = 0, high = 0;  // vertices
  uint32_t owner = 0;          // polygon or cell
  uint32_t corner = 0;         // from this corner to the next
  bool upward = false;         // from low to high
};

std::vector<HalfEdge> SortedEdges(std::span<const Loop> loops) {
  std::vector<HalfEdge> edges;
  for (uint32_t p = 0; p < loops.size(); ++p) {
    const Loop& loop = loops[p];
    for (uint32_t i = 0; i < loop.size(); ++i) {
      const uint32_t a = loop[i], b = loop[(i + 1) % loop.size()];
      edges.push_back({std::min(a, b), std::max(a, b), p, i, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.owner, a.corner) < std::tie(b.low, b.high, b.owner, b.corner);
  });
  return edges;
}

// Calls pair(a, b) for edges that exactly two of a key have, in opposite directions.
template <typename Pair>
void ForEachPair(const std::vector<HalfEdge>& edges, std::span<const uint64_t> key,
                 const Pair& pair) {
  std::vector<const HalfEdge*> same;
  for (size_t i = 0; i < edges.size();) {
    size_t end = i;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high)
      ++end;
    for (size_t a = i; a < end; ++a) {
      same.clear();
      bool first = true;
      for (size_t b = i; b < end; ++b) {
        if (key[edges[b].owner] != key[edges[a].owner]) continue;
        first = first && b >= a;
        same.push_back(&edges[b]);
      }
      if (first && same.size() == 2 && same[0]->upward != same[1]->upward) pair(*same[0], *same[1]);
    }
    i = end;
  }
}

struct Directed {
  uint32_t from = 0, to = 0;
};

// Grows with the angle clockwise from `a` to `b`, in (0, 4].
double Clockwise(const Point2& a, const Point2& b) {
  const double cross = Cross(a, b), dot = Dot(a, b);
  const double sum = std::abs(cross) + std::abs(dot);
  if (sum == 0) return 4;
  if (cross < 0) return 1 - dot / sum;
  return cross > 0 || dot < 0 ? 3 + dot / sum : 4;
}

// Traces boundary edges into loops; where several leave a vertex, the one that keeps the region's
// sector together. Empty where they do not close.
std::vector<Loop> TraceLoops(const Scene& scene, std::vector<Directed> edges, const Vec3& normal) {
  std::sort(edges.begin(), edges.end(), [](const Directed& a, const Directed& b) {
    return std::tie(a.from, a.to) < std::tie(b.from, b.to);
  });
  const PlaneFrame frame(scene.vertices[edges[0].from], normal);
  std::vector<bool> used(edges.size(), false);
  const auto next = [&](const Directed& e) -> size_t {
    size_t best = edges.size();
    double best_angle = 0;
    auto it = std::lower_bound(edges.begin(), edges.end(), e.to,
                               [](const Directed& a, uint32_t v) { return a.from < v; });
    const Point2 here = frame.Flat(scene.vertices[e.to]);
    const Point2 back = frame.Flat(scene.vertices[e.from]) - here;
    for (; it != edges.end() && it->from == e.to; ++it) {
      const auto i = static_cast<size_t>(it - edges.begin());
      if (used[i]) continue;
      const Point2 out = frame.Flat(scene.vertices[it->to]) - here;
      const double angle = Clockwise(back, out);
      if (best < edges.size() && angle >= best_angle) continue;
      best = i;
      best_angle = angle;
    }
    return best;
  };
  std::vector<Loop> loops;
  for (size_t start = 0; start < edges.size(); ++start) {
    if (used[start]) continue;
    Loop loop;
    size_t at = start;
    while (!used[at]) {
      used[at] = true;
      loop.push_back(edges[at].from);
      if (edges[at].to == edges[start].from) break;
      at = next(edges[at]);
      if (at == edges.size()) return {};
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

double Area(const Scene& scene, const Loop& loop, const Vec3& normal) {
  Vec3 sum(0.0);
  const Vec3& first = scene.vertices[loop[0]];
  for (size_t i = 1; i + 1 < loop.size(); ++i) {
    sum += glm::cross(scene.vertices[loop[i]] - first, scene.vertices[loop[i + 1]] - first);
  }
  return 0.5 * glm::dot(sum, normal);
}

// Takes out corners nearer than `tolerance` to the line through the corners kept before and the one
// after. What has been taken out since the last kept corner stays near the line, too, as each is
// measured against the corners that are left.
Loop WithoutStraight(const Scene& scene, const Loop& loop, double tolerance) {
  const auto straight = [&](uint32_t a, uint32_t b, uint32_t c) {
    const Vec3 along = scene.vertices[c] - scene.vertices[a];
    const Vec3 to = scene.vertices[b] - scene.vertices[a];
    const double length2 = glm::dot(along, along);
    const double t = glm::dot(to, along);
    if (!(t > 0 && t < length2)) return false;
    const Vec3 off = glm::cross(to, along);
    const double limit = std::min(tolerance * tolerance,
                                  1e-8 * std::min(t * t, (length2 - t) * (length2 - t)) / length2);
    return glm::dot(off, off) <= limit * length2;
  };
  // Begin at a corner that surely is one: the farthest from the first.
  size_t start = 0;
  double farthest = -1;
  for (size_t i = 0; i < loop.size(); ++i) {
    const Vec3 d = scene.vertices[loop[i]] - scene.vertices[loop[0]];
    if (glm::dot(d, d) <= farthest) continue;
    farthest = glm::dot(d, d);
    start = i;
  }
  Loop kept{loop[start]};
  for (size_t k = 1; k < loop.size(); ++k) {
    const uint32_t here = loop[(start + k) % loop.size()];
    const uint32_t after = loop[(start + k + 1) % loop.size()];
    if (!straight(kept.back(), here, after)) kept.push_back(here);
  }
  return kept;
}

// Ties holes into the outer loop by seams between their nearest corners; the seam must not cross
// anything, which the areas of the triangulation show.
Loop TieHoles(const Scene& scene, std::vector<Loop> loops) {
  Loop outer = std::move(loops[0]);
  while (loops.size() > 1) {
    size_t best_loop = 1, best_from = 0, best_to = 0;
    double best = std::numeric_limits<double>::infinity();
    for (size_t l = 1; l < loops.size(); ++l) {
      for (size_t i = 0; i < outer.size(); ++i) {
        for (size_t k = 0; k < loops[l].size(); ++k) {
          const Vec3 d = scene.vertices[outer[i]] - scene.vertices[loops[l][k]];
          if (glm::dot(d, d) >= best) continue;
          best = glm::dot(d, d);
          best_loop = l;
          best_from = i;
          best_to = k;
        }
      }
    }
    const Loop& hole = loops[best_loop];
    Loop tied(outer.begin(), outer.begin() + static_cast<ptrdiff_t>(best_from) + 1);
    for (size_t k = 0; k <= hole.size(); ++k) tied.push_back(hole[(best_to + k) % hole.size()]);
    tied.insert(tied.end(), outer.begin() + static_cast<ptrdiff_t>(best_from), outer.end());
    outer = std::move(tied);
    loops.erase(loops.begin() + static_cast<ptrdiff_t>(best_loop));
  }
  return outer;
}

// Cells and what they are joined to; a cell that was joined to another is empty.
class CellJoiner {
 public:
  CellJoiner(const Scene& scene, std::vector<Loop> cells, const Vec3& normal, size_t most_corners)
      : scene_(scene),
        cells_(std::move(cells)),
        normal_(normal),
        most_corners_(most_corners),
        sets_(cells_.size()) {}

  std::vector<Loop> Run() {
    const std::vector<uint64_t> key(cells_.size(), 0);
    struct Shared {
      double length2;
      uint32_t from, to, left, right;
    };
    std::vector<Shared> shared;
    ForEachPair(SortedEdges(cells_), key, [&](const HalfEdge& a, const HalfEdge& b) {
      const HalfEdge& up = a.upward ? a : b;
      const HalfEdge& down = a.upward ? b : a;
      const Vec3 d = scene_.vertices[a.high] - scene_.vertices[a.low];
      shared.push_back({glm::dot(d, d), a.low, a.high, up.owner, down.owner});
    });
    // The longest first: what is left then are the short ones.
    std::stable_sort(shared.begin(), shared.end(),
                     [](const Shared& a, const Shared& b) { return a.length2 > b.length2; });
    // An edge may become free when another has gone; few do so more than twice.
    for (int pass = 0; pass < 3; ++pass) {
      for (const Shared& edge : shared) Try(edge.from, edge.to, edge.left, edge.right);
    }
    std::vector<Loop> result;
    for (Loop& cell : cells_) {
      if (!cell.empty()) result.push_back(std::move(cell));
    }
    return result;
  }

 private:
  // `left` has the edge as from → to.
  void Try(uint32_t from, uint32_t to, uint32_t left, uint32_t right) {
    left = sets_.Find(left);
    right = sets_.Find(right);
    if (left == right) return;
    Loop& a = cells_[left];
    Loop& b = cells_[right];
    const size_t i = EdgeOf(a, from, to), k = EdgeOf(b, to, from);
    if (i == a.size() || k == b.size()) return;
    Loop joined;
    for (size_t s = 1; s <= a.size(); ++s) joined.push_back(a[(i + s) % a.size()]);
    for (size_t s = 2; s < b.size(); ++s) joined.push_back(b[(k + s) % b.size()]);
    RemoveSpurs(&joined);
    if (joined.size() < 3 || joined.size() > most_corners_ || !Convex(joined)) return;
    sets_.Join(left, right);
    cells_[std::max(left, right)].clear();
    cells_[std::min(left, right)] = std::move(joined);
  }

  static size_t EdgeOf(const Loop& loop, uint32_t from, uint32_t to) {
    for (size_t i = 0; i < loop.size(); ++i) {
      if (loop[i] == from && loop[(i + 1) % loop.size()] == to) return i;
    }
    return loop.size();
  }

  // Where two cells share several edges in a row, the others run to and fro.
  static void RemoveSpurs(Loop* loop) {
    for (size_t i = 0; i < loop->size() && loop->size() > 2;) {
      const size_t n = loop->size();
      if ((*loop)[(i + n - 1) % n] != (*loop)[(i + 1) % n]) {
        ++i;
        continue;
      }
      const size_t next = (i + 1) % n;
      loop->erase(loop->begin() + static_cast<ptrdiff_t>(std::max(i, next)));
      loop->erase(loop->begin() + static_cast<ptrdiff_t>(std::min(i, next)));
      i = 0;
    }
  }

  bool Convex(const Loop& loop) const {
    for (size_t i = 0; i < loop.size(); ++i) {
      const Vec3& here = scene_.vertices[loop[i]];
      const Vec3 in = here - scene_.vertices[loop[(i + loop.size() - 1) % loop.size()]];
      const Vec3 out = scene_.vertices[loop[(i + 1) % loop.size()]] - here;
      const double turn = glm::dot(glm::cross(in, out), normal_);
      if (turn < -kStraight * glm::length(in) * glm::length(out)) return false;
      if (turn <= 0 && glm::dot(in, out) < 0) return false;
    }
    return Area(scene_, loop, normal_) > 0;
  }

  const Scene& scene_;
  std::vector<Loop> cells_;
  Vec3 normal_;
  size_t most_corners_;
  DisjointSets sets_;
};

}  // namespace

AlikeLoops OrientAlike(const Scene& scene, std::span<const uint32_t> plane_of) {
  const size_t count = scene.polygons.size();
  AlikeLoops alike{std::vector<Loop>(count), std::vector<Vec3>(count), std::vector<double>(count)};
  std::vector<Vec3> reference(count, Vec3(0.0));  // of each plane: the normal of its first polygon
  for (uint32_t p = 0; p < count; ++p) {
    const Polygon& polygon = scene.polygons[p];
    Loop& loop = alike.loops[p];
    loop.assign(polygon.vertices.begin(), polygon.vertices.begin() + polygon.vertex_count());
    const Vec3 area = SideGeometry(scene, p, Side::kFront).AreaVector();
    alike.areas[p] = glm::length(area);
    alike.normals[p] = area / alike.areas[p];
    Vec3& first = reference[plane_of[p]];
    if (first == Vec3(0.0)) first = alike.normals[p];
    if (glm::dot(first, alike.normals[p]) >= 0) continue;
    alike.normals[p] = -alike.normals[p];
    std::reverse(loop.begin(), loop.end());
  }
  return alike;
}

std::vector<Region> FindRegions(const Scene& scene, std::span<const Loop> loops,
                                std::span<const uint64_t> key, std::span<const Vec3> normals) {
  const std::vector<HalfEdge> edges = SortedEdges(loops);
  DisjointSets sets(loops.size());
  std::vector<std::vector<bool>> inner(loops.size());
  for (size_t p = 0; p < loops.size(); ++p) inner[p].assign(loops[p].size(), false);
  ForEachPair(edges, key, [&](const HalfEdge& a, const HalfEdge& b) {
    sets.Join(a.owner, b.owner);
    inner[a.owner][a.corner] = inner[b.owner][b.corner] = true;
  });
  std::vector<Region> regions;
  std::vector<std::vector<Directed>> borders;
  std::vector<uint32_t> number(loops.size(), kNone);
  for (uint32_t p = 0; p < loops.size(); ++p) {
    uint32_t& n = number[sets.Find(p)];
    if (n == kNone) {
      n = static_cast<uint32_t>(regions.size());
      regions.emplace_back();
      borders.emplace_back();
    }
    regions[n].polygons.push_back(p);
    for (size_t i = 0; i < loops[p].size(); ++i) {
      if (!inner[p][i]) borders[n].push_back({loops[p][i], loops[p][(i + 1) % loops[p].size()]});
    }
  }
  for (size_t r = 0; r < regions.size(); ++r) {
    if (regions[r].polygons.size() == 1) {
      regions[r].outline = {loops[regions[r].polygons[0]]};
    } else if (!borders[r].empty()) {
      regions[r].outline =
          TraceLoops(scene, std::move(borders[r]), normals[regions[r].polygons[0]]);
    }
  }
  return regions;
}

std::optional<std::vector<std::array<uint32_t, 3>>> Retriangulate(const Scene& scene,
                                                                  const Region& region,
                                                                  const Vec3& normal,
                                                                  double area_m2,
                                                                  double tolerance_m) {
  std::vector<Loop> loops;
  size_t corners = 0;
  for (const Loop& loop : region.outline) {
    loops.push_back(WithoutStraight(scene, loop, tolerance_m));
    if (loops.back().size() < 3) return std::nullopt;
    corners += loops.back().size();
  }
  if (loops.empty() || corners > kMostCorners || loops.size() > kMostHoles + 1) return std::nullopt;
  // The outer loop is the one that runs counter-clockwise.
  size_t outer = loops.size();
  for (size_t l = 0; l < loops.size(); ++l) {
    if (Area(scene, loops[l], normal) <= 0) continue;
    if (outer != loops.size()) return std::nullopt;
    outer = l;
  }
  if (outer == loops.size()) return std::nullopt;
  std::swap(loops[0], loops[outer]);
  const Loop tied = TieHoles(scene, std::move(loops));
  std::vector<Vec3> points;
  for (const uint32_t v : tied) points.push_back(scene.vertices[v]);
  const Triangulation division = Triangulate(points, tied);
  if (!division.simple) return std::nullopt;
  std::vector<std::array<uint32_t, 3>> triangles;
  double covered = 0;
  for (const auto& t : division.triangles) {
    triangles.push_back({tied[t[0]], tied[t[1]], tied[t[2]]});
    const ConvexPolygon shape{
        3, {scene.vertices[tied[t[0]]], scene.vertices[tied[t[1]]], scene.vertices[tied[t[2]]]}};
    if (!HasArea(shape)) return std::nullopt;
    covered += glm::dot(shape.AreaVector(), normal);
  }
  // Straightened borders change the area by their length times the tolerance.
  double border = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    border += glm::length(points[(i + 1) % points.size()] - points[i]);
  }
  if (std::abs(covered - area_m2) > 1e-9 * area_m2 + border * tolerance_m) return std::nullopt;
  return triangles;
}

std::vector<Loop> JoinConvex(const Scene& scene, std::vector<Loop> cells, const Vec3& normal,
                             size_t most_corners) {
  return CellJoiner(scene, std::move(cells), normal, most_corners).Run();
}

}  // namespace isolux
