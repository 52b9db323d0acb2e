// Couplings of random pairs against a reference: no more than one pair in a thousand exceeds its
// tolerance, and none by much. Ten thousand pairs of each family.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/worker/coupling/random_pairs.h"
#include "tests/worker/coupling/reference.h"
#include "worker/coupling/coupling.h"

namespace isolux {
namespace {

using testing::MakePair;
using testing::PairFamilies;
using testing::PairFamily;
using testing::PolygonPair;

constexpr uint64_t kFirstSeed = 20260101;

// Independent, and slow.
TEST(Couple, AgreesWithTheReferenceAtATightTolerance) {
  for (const PairFamily& family : PairFamilies()) {
    for (uint64_t seed = kFirstSeed; seed < kFirstSeed + 60; ++seed) {
      const PolygonPair pair = MakePair(family, seed);
      const CouplingEnd p = MakeCouplingEnd(pair.p), q = MakeCouplingEnd(pair.q);
      const double least = std::min(p.area_m2, q.area_m2);
      // What double precision leaves: of the product of the lengths.
      const double rounding = 1e-14 * std::sqrt(p.area_m2 * q.area_m2);
      EXPECT_NEAR(Couple(p, q, 1e-10 * least).coupling_m2,
                  static_cast<double>(testing::CouplingByContours(pair.p, pair.q)),
                  1e-10 * least + rounding)
          << family.name << ", seed " << seed;
    }
  }
}

// What was found at one tolerance.
struct Found {
  double tolerance;  // of the smaller area
  int over = 0, underestimated = 0;
  double worst = 0;  // error, in tolerances

  void Add(const CouplingEnd& p, const CouplingEnd& q, double exact_m2) {
    const double least = std::min(p.area_m2, q.area_m2);
    const double allowed = tolerance * least;
    const PairCoupling coupling = Couple(p, q, allowed);
    ASSERT_TRUE(coupling.coupling_m2 >= 0 && coupling.coupling_m2 <= least);
    ASSERT_TRUE(coupling.error_m2 >= 0 &&
                coupling.error_m2 <= allowed + 1e-14 * p.radius_m * q.radius_m);
    const double error = std::abs(coupling.coupling_m2 - exact_m2);
    over += error > allowed;
    underestimated += error > coupling.error_m2 + 1e-10 * least;
    worst = std::max(worst, error / allowed);
  }
};

// Against itself at a tolerance ten thousand times finer, for which the test above vouches.
TEST(Couple, KeepsItsTolerance) {
  constexpr int kPairs = 10000;
  for (const PairFamily& family : PairFamilies()) {
    std::vector<Found> found = {{1e-2}, {1e-3}, {1e-4}, {1e-6}};
    for (uint64_t seed = kFirstSeed; seed < kFirstSeed + kPairs; ++seed) {
      SCOPED_TRACE(std::string(family.name) + ", seed " + std::to_string(seed));
      const PolygonPair pair = MakePair(family, seed);
      const CouplingEnd p = MakeCouplingEnd(pair.p), q = MakeCouplingEnd(pair.q);
      const double exact_m2 = Couple(p, q, 1e-10 * std::min(p.area_m2, q.area_m2)).coupling_m2;
      for (Found& at : found) at.Add(p, q, exact_m2);
      if (HasFatalFailure()) return;
    }
    for (const Found& at : found) {
      std::printf("%-20s tolerance %.0e: %d over, worst error %.2f tolerances, %d underestimated\n",
                  family.name, at.tolerance, at.over, at.worst, at.underestimated);
      EXPECT_LE(at.over, kPairs / 1000) << family.name << " at " << at.tolerance;
      EXPECT_LE(at.worst, 2.5) << family.name << " at " << at.tolerance;
      EXPECT_LE(at.underestimated, kPairs / 100) << family.name << " at " << at.tolerance;
    }
  }
}

}  // namespace
}  // namespace isolux
