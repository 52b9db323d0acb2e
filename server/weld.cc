#include "server/weld.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/util/random.h"

namespace isolux {
namespace {

constexpr uint32_t kNone = 0xffffffffu;
// Cell of the hash in tolerances: large enough that few corners lie near a border, small enough
// that few share a cell.
constexpr double kCellTolerances = 64;

struct Edge {
  uint32_t face, side, from, to;
};

int CornerCount(const std::array<uint32_t, 4>& face) { return face[3] == kNoCorner ? 3 : 4; }

// Sides that no other face runs along the other way, end to end: on a border of the group, or
// beside T-vertices. Only they can hold T-vertices, and only their ends can be some.
std::vector<Edge> UnpairedEdges(std::span<const std::array<uint32_t, 4>> faces,
                                size_t vertex_count) {
  // Each edge stands in the list of its lower vertex: the other end and the direction.
  std::vector<uint32_t> first(vertex_count + 1, 0);
  const auto for_edges = [&](const auto& body) {
    for (uint32_t f = 0; f < faces.size(); ++f) {
      const int count = CornerCount(faces[f]);
      for (int k = 0; k < count; ++k) {
        const uint32_t from = faces[f][k], to = faces[f][(k + 1) % count];
        if (from != to) body(Edge{f, static_cast<uint32_t>(k), from, to});
      }
    }
  };
  for_edges([&](const Edge& e) { ++first[std::min(e.from, e.to) + 1]; });
  std::partial_sum(first.begin(), first.end(), first.begin());
  struct Entry {
    uint32_t other;
    bool upward;
  };
  std::vector<Entry> entries(first.back());
  std::vector<uint32_t> fill(first.begin(), first.end() - 1);
  for_edges([&](const Edge& e) {
    entries[fill[std::min(e.from, e.to)]++] = {std::max(e.from, e.to), e.from < e.to};
  });
  std::vector<Edge> unpaired;
  for_edges([&](const Edge& e) {
    const uint32_t low = std::min(e.from, e.to), high = std::max(e.from, e.to);
    const bool upward = e.from < e.to;
    for (uint32_t i = first[low]; i < first[low + 1]; ++i) {
      if (entries[i].other == high && entries[i].upward != upward) return;
    }
    unpaired.push_back(e);
  });
  return unpaired;
}

// Points of one group, found along a segment in logarithmic time and the number found.
class PointTree {
 public:
  PointTree(std::span<const Vec3> positions, std::span<uint32_t> points, double tolerance)
      : positions_(positions), points_(points), axes_(points.size()), tolerance_(tolerance) {
    Build(0, points.size());
  }

  // Calls found(vertex, t) for points within the tolerance of the open segment.
  template <typename Found>
  void Along(const Vec3& from, const Vec3& to, const Found& found) const {
    const Segment segment{from, to - from, glm::length(to - from)};
    Visit(0, points_.size(), segment, 0, 1, found);
  }

 private:
  struct Segment {
    Vec3 from, along;
    double length;
  };

  void Build(size_t begin, size_t end) {
    if (end - begin < 2) return;
    Bounds3 bounds;
    for (size_t i = begin; i < end; ++i) bounds.Add(positions_[points_[i]]);
    const Vec3 extent = bounds.Extent();
    const int axis =
        extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    const size_t middle = begin + (end - begin) / 2;
    const auto at = [&](size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](uint32_t a, uint32_t b) {
      return positions_[a][axis] < positions_[b][axis];
    });
    axes_[middle] = static_cast<uint8_t>(axis);
    Build(begin, middle);
    Build(middle + 1, end);
  }

  template <typename Found>
  void Visit(size_t begin, size_t end, const Segment& s, double low, double high,
             const Found& found) const {
    if (begin == end || low > high) return;
    const size_t middle = begin + (end - begin) / 2;
    Test(points_[middle], s, found);
    if (end - begin == 1) return;
    // Of the part [low, high] of the segment, what can come within the tolerance of either half.
    const int axis = axes_[middle];
    const double gap = positions_[points_[middle]][axis] - s.from[axis], slope = s.along[axis];
    double left_low = low, left_high = high, right_low = low, right_high = high;
    if (slope > 0) {
      left_high = std::min(high, (gap + tolerance_) / slope);
      right_low = std::max(low, (gap - tolerance_) / slope);
    } else if (slope < 0) {
      left_low = std::max(low, (gap + tolerance_) / slope);
      right_high = std::min(high, (gap - tolerance_) / slope);
    } else {
      if (gap < -tolerance_) left_high = left_low - 1;
      if (gap > tolerance_) right_high = right_low - 1;
    }
    Visit(begin, middle, s, left_low, left_high, found);
    Visit(middle + 1, end, s, right_low, right_high, found);
  }

  template <typename Found>
  void Test(uint32_t vertex, const Segment& s, const Found& found) const {
    const Vec3 offset = positions_[vertex] - s.from;
    const double t = glm::dot(offset, s.along) / (s.length * s.length);
    if (!(t > 0 && t < 1)) return;
    if (glm::length(offset - t * s.along) > tolerance_) return;
    if (std::min(t, 1 - t) * s.length > tolerance_) found(vertex, t);
  }

  std::span<const Vec3> positions_;
  std::span<uint32_t> points_;
  std::vector<uint8_t> axes_;
  double tolerance_;
};

}  // namespace

Welder::Welder(double tolerance, const Vec3& low, size_t expected_vertices)
    : tolerance_(tolerance), cell_size_(kCellTolerances * tolerance), low_(low) {
  positions_.reserve(expected_vertices);
  groups_.reserve(expected_vertices);
  hashes_.reserve(expected_vertices);
  next_.reserve(expected_vertices);
  size_t size = 1024;
  while (size < expected_vertices) size *= 2;
  buckets_.assign(size, kNone);
}

uint32_t Welder::Vertex(const Vec3& position, uint32_t group) {
  // The cells of all points within the tolerance: mostly one. The grid is shifted off the round
  // numbers that scenes are made of.
  std::array<int64_t, 3> low{}, high{}, own{};
  for (int d = 0; d < 3; ++d) {
    const double x = (position[d] - low_[d]) / cell_size_ + 0.381966;
    const double reach = tolerance_ / cell_size_;
    own[d] = static_cast<int64_t>(std::floor(x));
    low[d] = static_cast<int64_t>(std::floor(x - reach));
    high[d] = static_cast<int64_t>(std::floor(x + reach));
  }
  uint32_t best = kNone;
  for (int64_t x = low[0]; x <= high[0]; ++x) {
    for (int64_t y = low[1]; y <= high[1]; ++y) {
      for (int64_t z = low[2]; z <= high[2]; ++z) {
        for (uint32_t v = Bucket({x, y, z}, group); v != kNone; v = next_[v]) {
          if (v < best && groups_[v] == group &&
              glm::length(positions_[v] - position) <= tolerance_) {
            best = v;
          }
        }
      }
    }
  }
  if (best != kNone) return best;
  if (positions_.size() >= buckets_.size()) Grow();
  const auto vertex = static_cast<uint32_t>(positions_.size());
  positions_.push_back(position);
  groups_.push_back(group);
  hashes_.push_back(Hash(Hash(static_cast<uint64_t>(own[0]), static_cast<uint64_t>(own[1])),
                         static_cast<uint64_t>(own[2]), group));
  uint32_t& bucket = buckets_[hashes_.back() & (buckets_.size() - 1)];
  next_.push_back(bucket);
  bucket = vertex;
  return vertex;
}

uint32_t& Welder::Bucket(const std::array<int64_t, 3>& cell, uint32_t group) {
  const uint64_t hash = Hash(Hash(static_cast<uint64_t>(cell[0]), static_cast<uint64_t>(cell[1])),
                             static_cast<uint64_t>(cell[2]), group);
  return buckets_[hash & (buckets_.size() - 1)];
}

void Welder::Grow() {
  buckets_.assign(2 * buckets_.size(), kNone);
  for (uint32_t v = 0; v < positions_.size(); ++v) {
    uint32_t& bucket = buckets_[hashes_[v] & (buckets_.size() - 1)];
    next_[v] = bucket;
    bucket = v;
  }
}

std::vector<TVertex> FindTVertices(const Welder& welder,
                                   std::span<const std::array<uint32_t, 4>> faces) {
  const std::span<const Vec3> positions = welder.positions();
  const std::span<const uint32_t> groups = welder.groups();
  std::vector<Edge> edges = UnpairedEdges(faces, positions.size());
  std::stable_sort(edges.begin(), edges.end(),
                   [&](const Edge& a, const Edge& b) { return groups[a.from] < groups[b.from]; });

  // Group by group: a tree of the ends of the unpaired sides, asked for what lies along each.
  std::vector<TVertex> result;
  std::vector<uint32_t> points;
  for (size_t begin = 0; begin < edges.size();) {
    const uint32_t group = groups[edges[begin].from];
    points.clear();
    size_t end = begin;
    for (; end < edges.size() && groups[edges[end].from] == group; ++end) {
      points.push_back(edges[end].from);
      points.push_back(edges[end].to);
    }
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    const PointTree tree(positions, points, welder.tolerance());
    for (; begin < end; ++begin) {
      const Edge& e = edges[begin];
      tree.Along(positions[e.from], positions[e.to], [&](uint32_t vertex, double along) {
        if (vertex != e.from && vertex != e.to) {
          result.push_back({e.face, e.side, along, vertex});
        }
      });
    }
  }
  std::sort(result.begin(), result.end(), [](const TVertex& a, const TVertex& b) {
    if (a.face != b.face) return a.face < b.face;
    if (a.side != b.side) return a.side < b.side;
    return a.along != b.along ? a.along < b.along : a.vertex < b.vertex;
  });
  return result;
}

}  // namespace isolux
