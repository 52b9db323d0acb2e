#include "worker/factors/pair_factor.h"

#include <gtest/gtest.h>

#include "tests/worker/factors/exact_occluded.h"
#include "worker/factors/sampled_pair.h"

namespace isolux {
namespace {

using testing::CornersOf;

std::vector<uint32_t> All(const OccluderSet& set) {
  std::vector<uint32_t> all(set.size());
  for (uint32_t i = 0; i < set.size(); ++i) all[i] = i;
  return all;
}

// How many standard errors sampled shares are from what they estimate.
struct Deviations {
  int count = 0;
  double worst = 0, squares = 0;
  void Add(double sampled, double expected, int samples) {
    const double variance = std::max(expected * (1 - expected), 1.0 / samples) / samples;
    const double off = std::abs(sampled - expected) / std::sqrt(variance);
    ++count;
    worst = std::max(worst, off);
    squares += off * off;
  }
};

PairFactor SolveCase(const testing::OccludedCase& c, double tolerance_m2, bool swapped) {
  OccluderSet set(3);
  for (const ConvexPolygon& o : c.occluders) set.Add(CornersOf(o));
  const OccluderTree tree(set);
  PairSolver solver(tree);
  const CouplingEnd p = MakeCouplingEnd(c.p), q = MakeCouplingEnd(c.q);
  return solver.Solve({swapped ? q : p}, {swapped ? p : q}, All(set), tolerance_m2, 1);
}

TEST(PairFactorTest, ExactCasesToTheTolerance) {
  for (const testing::OccludedCase& c : testing::OccludedCases()) {
    const double smaller = std::min(c.p.Area(), c.q.Area());
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
      for (const bool swapped : {false, true}) {
        const PairFactor pair = SolveCase(c, tolerance * smaller, swapped);
        const double error = std::abs(pair.coupling_m2 - c.coupling_m2) / smaller;
        std::printf("%s, %.0e: error %.1e, stated %.1e, %s\n", c.name.c_str(), tolerance, error,
                    pair.error_m2 / smaller, ToText(pair.way));
        EXPECT_LE(error, tolerance) << c.name;
        EXPECT_LE(pair.error_m2, 1.1 * tolerance * smaller) << c.name;
        EXPECT_LE(error, pair.error_m2 / smaller + 1e-9) << c.name;
      }
    }
  }
}

// Pairs among random occluders, against a hundred times finer tolerances.
TEST(PairFactorTest, StatedErrorsHoldForRandomPairs) {
  constexpr uint64_t kSeeds = 3400;  // a tolerance, of its own
  uint64_t first = 1;
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    int pairs = 0, beyond_tolerance = 0, beyond_stated = 0;
    double worst = 0, squares = 0;
    for (uint64_t seed = first; seed < first + kSeeds; ++seed) {
      Random random(Hash(seed, 53));
      OccluderSet set(std::sqrt(3.0));
      const int count = 1 + static_cast<int>(random.Bits() % 6);
      for (int i = 0; i < count; ++i) {
        set.Add(testing::RandomConvexPolygon(
            random, testing::RandomPoint(random, Vec3(0.0), Vec3(1.0)),
            0.02 + 0.5 * random.Unit() * random.Unit(), 3 + static_cast<int>(random.Bits() % 6)));
      }
      const OccluderTree tree(set);
      PairSolver solver(tree);
      const auto polygon = [&] {
        return testing::ToPolygon(testing::RandomConvexPolygon(
            random, testing::RandomPoint(random, Vec3(0.0), Vec3(1.0)), 0.05 + 0.5 * random.Unit(),
            3 + static_cast<int>(random.Bits() % 2)));
      };
      const ConvexPolygon p_shape = polygon(), q_shape = polygon();
      const CouplingEnd p = MakeCouplingEnd(p_shape), q = MakeCouplingEnd(q_shape);
      const double smaller = std::min(p.area_m2, q.area_m2);
      const PairFactor fine = solver.Solve({p}, {q}, All(set), 0.01 * tolerance * smaller, 1);
      const PairFactor pair = solver.Solve({p}, {q}, All(set), tolerance * smaller, 1);
      if (pair.way != Way::kClipped && pair.way != Way::kDivided) continue;
      ++pairs;
      const double error = std::abs(pair.coupling_m2 - fine.coupling_m2) / smaller;
      beyond_tolerance += error > tolerance ? 1 : 0;
      beyond_stated += error > pair.error_m2 / smaller ? 1 : 0;
      worst = std::max(worst, error / tolerance);
      squares += error * error / (tolerance * tolerance);
    }
    std::printf(
        "tolerance %.0e: %d pairs, %d beyond it, %d beyond what was stated; worst %.2f, "
        "root mean square %.2f tolerances\n",
        tolerance, pairs, beyond_tolerance, beyond_stated, worst, std::sqrt(squares / pairs));
    EXPECT_GT(pairs, 100);
    EXPECT_LE(beyond_tolerance, pairs / 100) << tolerance;
    EXPECT_LE(beyond_stated, pairs / 100) << tolerance;
    first += kSeeds;
  }
}

// Among polygons that share planes, edges and corners, as those of buildings do, against segments
// that ask every occluder: no proof, no clipping.
TEST(PairFactorTest, AgreesWithSegmentsWhereThingsTouch) {
  Deviations seen;
  for (uint64_t seed = 1; seed <= 10'000; ++seed) {
    Random random(Hash(seed, 59));
    OccluderSet set(std::sqrt(3.0));
    for (int i = 0; i < 6; ++i) set.Add(CornersOf(testing::LatticePolygon(random)));
    const OccluderTree tree(set);
    PairSolver solver(tree);
    const ConvexPolygon p_shape = testing::LatticePolygon(random);
    const ConvexPolygon q_shape = testing::LatticePolygon(random);
    const CouplingEnd p = MakeCouplingEnd(p_shape), q = MakeCouplingEnd(q_shape);
    const double smaller = std::min(p.area_m2, q.area_m2);
    const PairFactor pair = solver.Solve({p}, {q}, All(set), 1e-4 * smaller, 1);
    if (pair.way == Way::kFacingAway) continue;
    // Directions by their cosine from random points of the smaller end.
    const CouplingEnd &from = p.area_m2 <= q.area_m2 ? p : q, &to = p.area_m2 <= q.area_m2 ? q : p;
    constexpr int kSegments = 1000;
    int arrive = 0;
    for (int i = 0; i < kSegments; ++i) {
      const Vec3 x = testing::PointOn(CornersOf(*from.polygon), random);
      const Vec3 d = testing::CosineDirection(from.normal, random);
      const double approach = -glm::dot(to.normal, d);
      const double height = glm::dot(to.normal, x - to.centre);
      if (!(approach > 0 && height > 0)) continue;
      const Vec3 y = x + height / approach * d;
      if (!testing::Contains(*to.polygon, y)) continue;
      bool blocked = false;
      for (uint32_t o = 0; o < set.size() && !blocked; ++o) blocked = set.Blocks(o, x, y);
      if (!blocked) ++arrive;
    }
    seen.Add(static_cast<double>(arrive) / kSegments, pair.coupling_m2 / smaller, kSegments);
    ASSERT_LE(seen.worst, 5.0) << "seed " << seed << ": " << ToText(pair.way) << ", F "
                               << pair.coupling_m2 / smaller << ", segments "
                               << static_cast<double>(arrive) / kSegments;
  }
  std::printf("%d pairs, at most %.1f standard errors off; mean square %.2f\n", seen.count,
              seen.worst, seen.squares / seen.count);
  EXPECT_GT(seen.count, 300);
  EXPECT_LT(seen.squares, 1.3 * seen.count);
}

TEST(PairFactorTest, WhatOneSheetHidesIsExactlyNothing) {
  for (const testing::OccludedCase& c : testing::OccludedCases()) {
    if (c.name != "all covered") continue;
    const PairFactor pair = SolveCase(c, 1e-4, false);
    EXPECT_EQ(pair.coupling_m2, 0);
    EXPECT_EQ(pair.error_m2, 0);
    EXPECT_EQ(pair.way, Way::kHidden);
  }
}

}  // namespace
}  // namespace isolux
