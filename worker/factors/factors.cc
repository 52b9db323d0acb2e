#include "worker/factors/factors.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <numeric>

#include "common/util/random.h"
#include "worker/factors/groups.h"
#include "worker/factors/row_sums.h"
#include "worker/visibility/box_shaft.h"

namespace isolux {
namespace {

// One convex piece of an end.
struct Piece {
  ConvexPolygon polygon;
  PairEnd end;
  uint32_t of = 0;  // FactorTable::ends
};

struct Pieces {
  std::vector<Piece> all;
  std::vector<FactorEnd> ends;
};

Pieces MakePieces(const Scene& scene, std::span<const uint32_t> region_of) {
  const std::vector<Surface> surfaces = MakeSurfaces(scene);
  std::vector<uint32_t> order(surfaces.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](uint32_t s) {
    return std::pair(scene.polygons[surfaces[s].polygon].file_polygon, surfaces[s].side);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  Pieces pieces;
  pieces.all.resize(order.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const auto [polygon, side] = key(order[i]);
    if (i == 0 || key(order[i - 1]) != key(order[i])) pieces.ends.push_back({polygon, side});
    Piece& piece = pieces.all[i];
    piece.polygon = SideGeometry(scene, surfaces[order[i]].polygon, side);
    piece.end = {MakeCouplingEnd(piece.polygon), region_of[surfaces[order[i]].polygon]};
    piece.of = static_cast<uint32_t>(pieces.ends.size() - 1);
    pieces.ends.back().area_m2 += piece.end.polygon.area_m2;
  }
  return pieces;
}

// Everything that the threads share.
struct Work {
  const Pieces& pieces;
  const std::vector<Group>& groups;
  const OccluderTree& tree;
  double tolerance;
};

// What one thread does and has found.
struct Worker {
  explicit Worker(const OccluderTree& tree) : solver(tree) {}
  PairSolver solver;
  std::array<uint64_t, kWayCount> pairs{};
  uint64_t above_tolerance = 0;
};

// All pairs of pieces of two groups (of one, where they are the same).
void SolveGroupPair(const Work& work, uint32_t a, uint32_t b, Worker* worker,
                    std::vector<Factor>* found) {
  const Group& first = work.groups[a];
  const Group& second = work.groups[b];
  const std::vector<uint32_t> candidates =
      work.tree.Candidates(BoxShaft(first.bounds, second.bounds));
  for (size_t i = 0; i < first.members.size(); ++i) {
    for (size_t j = a == b ? i + 1 : 0; j < second.members.size(); ++j) {
      const uint32_t p = std::min(first.members[i], second.members[j]);
      const uint32_t q = std::max(first.members[i], second.members[j]);
      const Piece &from = work.pieces.all[p], &to = work.pieces.all[q];
      // Pieces of faces share the faces' tolerance; for whole faces this is that of the smaller.
      const double larger =
          std::max(work.pieces.ends[from.of].area_m2, work.pieces.ends[to.of].area_m2);
      const double tolerance_m2 =
          work.tolerance * from.end.polygon.area_m2 * to.end.polygon.area_m2 / larger;
      const PairFactor pair =
          worker->solver.Solve(from.end, to.end, candidates, tolerance_m2, Hash(p, q));
      ++worker->pairs[static_cast<size_t>(pair.way)];
      if (pair.error_m2 > tolerance_m2) ++worker->above_tolerance;
      if (pair.coupling_m2 <= 0) continue;
      const double times = from.of == to.of ? 2 : 1;  // a face's own pieces, both ways
      found->push_back({std::min(from.of, to.of), std::max(from.of, to.of),
                        times * pair.coupling_m2, times * pair.error_m2});
    }
  }
}

// The pairs of pieces as pairs of ends, in order, those of one pair added up.
std::vector<Factor> Join(const std::vector<std::vector<Factor>>& parts, size_t ends) {
  std::vector<uint64_t> start(ends + 1, 0);
  for (const auto& part : parts) {
    for (const Factor& factor : part) ++start[factor.p + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Factor> sorted(start.back());
  std::vector<uint64_t> next(start.begin(), start.end() - 1);
  for (const auto& part : parts) {
    for (const Factor& factor : part) sorted[next[factor.p]++] = factor;
  }
  size_t kept = 0;
  for (size_t p = 0; p < ends; ++p) {
    const auto begin = sorted.begin() + static_cast<ptrdiff_t>(start[p]);
    const auto end = sorted.begin() + static_cast<ptrdiff_t>(start[p + 1]);
    std::stable_sort(begin, end, [](const Factor& a, const Factor& b) { return a.q < b.q; });
    for (auto it = begin; it != end; ++it) {
      if (it != begin && sorted[kept - 1].q == it->q) {
        sorted[kept - 1].coupling_m2 += it->coupling_m2;
        sorted[kept - 1].error_m2 += it->error_m2;
      } else {
        sorted[kept++] = *it;
      }
    }
  }
  sorted.resize(kept);
  return sorted;
}

std::vector<Group> GroupPieces(const Pieces& pieces) {
  std::vector<GroupMember> members;
  members.reserve(pieces.all.size());
  for (const Piece& piece : pieces.all) {
    GroupMember& member = members.emplace_back();
    member.normal = piece.end.polygon.normal;
    for (int i = 0; i < piece.polygon.count; ++i) member.bounds.Add(piece.polygon.v[i]);
  }
  return MakeGroups(members);
}

}  // namespace

Result<FactorTable> ComputeFactors(const Scene& scene, const FactorOptions& options,
                                   ThreadPool& pool) {
  const SceneOccluders occluders = MakeOccluders(scene);
  Pieces pieces = MakePieces(scene, occluders.region_of);
  if (pieces.all.size() > kMostFactorPieces) {
    return Error(StatusCode::kResourceExhausted,
                 "{} sides of polygons make more pairs than fit: at most {} are taken; give fewer "
                 "or larger polygons, or --reflect front",
                 pieces.all.size(), kMostFactorPieces);
  }
  const OccluderTree tree(occluders.set);
  const std::vector<Group> groups = GroupPieces(pieces);
  const Work work{pieces, groups, tree, options.tolerance};

  std::vector<std::pair<uint32_t, uint32_t>> tasks;
  for (uint32_t a = 0; a < groups.size(); ++a) {
    for (uint32_t b = a; b < groups.size(); ++b) tasks.emplace_back(a, b);
  }
  std::vector<std::vector<Factor>> found(tasks.size());
  std::vector<std::unique_ptr<Worker>> workers;
  for (int t = 0; t < pool.thread_count(); ++t) workers.push_back(std::make_unique<Worker>(tree));
  std::atomic<size_t> done = 0;
  pool.For(tasks.size(), 4, [&](size_t begin, size_t end, int thread) {
    for (size_t i = begin; i < end; ++i) {
      SolveGroupPair(work, tasks[i].first, tasks[i].second, workers[thread].get(), &found[i]);
    }
    done += end - begin;
    if (thread == 0 && options.progress) {
      options.progress(static_cast<double>(done) / static_cast<double>(tasks.size()));
    }
  });

  FactorTable table;
  table.ends = std::move(pieces.ends);
  for (const auto& worker : workers) {
    for (int way = 0; way < kWayCount; ++way) table.pairs[way] += worker->pairs[way];
    table.above_tolerance += worker->above_tolerance;
  }
  table.factors = Join(found, table.ends.size());
  LowerRows(&table);
  return table;
}

}  // namespace isolux
