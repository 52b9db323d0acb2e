#include "worker/coupling/coupling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "tests/support/polygons.h"
#include "tests/worker/coupling/random_pairs.h"
#include "worker/coupling/clip.h"
#include "worker/coupling/point_factor.h"
#include "worker/coupling/variation.h"

namespace isolux {
namespace {

using testing::MakePair;
using testing::PairFamilies;
using testing::PairFamily;
using testing::PolygonPair;
using testing::RandomDirection;
using testing::RandomPolygon;

constexpr uint64_t kPairs = 10'000;  // of a family

constexpr ConvexPolygon kSquare{4, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)}};

ConvexPolygon Moved(ConvexPolygon polygon, const Vec3& by) {
  for (Vec3& v : polygon.v) v += by;
  return polygon;
}

// To a share of the smaller area.
PairCoupling CoupleTo(double tolerance, const ConvexPolygon& p, const ConvexPolygon& q) {
  return Couple(MakeCouplingEnd(p), MakeCouplingEnd(q), tolerance * std::min(p.Area(), q.Area()));
}

bool SameBits(const PairCoupling& a, const PairCoupling& b) {
  const auto bits = [](double value) { return std::bit_cast<uint64_t>(value); };
  return bits(a.coupling_m2) == bits(b.coupling_m2) && bits(a.error_m2) == bits(b.error_m2) &&
         a.regime == b.regime;
}

TEST(PointFormFactors, MatchesClosedForms) {
  // A corner's view of a unit square opposite at distance 1 (exact: 0.1385316059948929).
  const ConvexPolygon above = testing::Reversed(Moved(kSquare, {0, 0, 1}));
  const Vec3 corner(0.0);
  const Lanes factor =
      PointFormFactors(Vec3x4({corner, corner, corner, corner}), {0, 0, 1}, {above.v.data(), 4});
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(factor[i], 0.1385316059948929, 1e-14);
  // The whole hemisphere, nearly.
  const ConvexPolygon wide{
      4,
      {Vec3(-1e6, 1e6, 1e-3), Vec3(1e6, 1e6, 1e-3), Vec3(1e6, -1e6, 1e-3), Vec3(-1e6, -1e6, 1e-3)}};
  EXPECT_NEAR(
      PointFormFactors(Vec3x4({corner, corner, corner, corner}), {0, 0, 1}, {wide.v.data(), 4})[2],
      1.0, 1e-8);
}

TEST(Couple, IsZeroWhereNothingCanBeSeen) {
  const auto coupling = [](const ConvexPolygon& p, const ConvexPolygon& q) {
    return CoupleTo(1e-3, p, q).coupling_m2;
  };
  const ConvexPolygon down = testing::Reversed(kSquare);
  EXPECT_EQ(coupling(kSquare, Moved(kSquare, {2, 0, 0})), 0);   // coplanar
  EXPECT_EQ(coupling(kSquare, kSquare), 0);                     // the same
  EXPECT_EQ(coupling(kSquare, down), 0);                        // its own back
  EXPECT_EQ(coupling(kSquare, Moved(kSquare, {0, 0, 1})), 0);   // facing away
  EXPECT_EQ(coupling(kSquare, Moved(kSquare, {0, 0, -1})), 0);  // behind
  EXPECT_EQ(coupling(down, Moved(kSquare, {0, 0, 1})), 0);      // back to back
}

TEST(Couple, GivesTheSameBitsInEitherOrder) {
  for (const PairFamily& family : PairFamilies()) {
    for (uint64_t seed = 1; seed <= kPairs; ++seed) {
      const PolygonPair pair = MakePair(family, seed);
      const double tolerance = std::array{1e-2, 1e-4, 1e-7}[seed % 3];
      ASSERT_TRUE(
          SameBits(CoupleTo(tolerance, pair.p, pair.q), CoupleTo(tolerance, pair.q, pair.p)))
          << family.name << ", seed " << seed;
    }
  }
}

TEST(FormFactorRanges, AreShares) {
  for (const PairFamily& family : PairFamilies()) {
    for (uint64_t seed = 1; seed <= kPairs; ++seed) {
      const PolygonPair pair = MakePair(family, seed);
      const CouplingEnd p = MakeCouplingEnd(pair.p), q = MakeCouplingEnd(pair.q);
      const double coupling = Couple(p, q, 1e-3 * std::min(p.area_m2, q.area_m2)).coupling_m2;
      const FormFactorRanges ranges = RangesOver(p, q);
      const FormFactorVariation variation = VariationWith(ranges, p, q, coupling);
      ASSERT_LE(ranges.Variation().over_p, variation.over_p) << family.name << ", seed " << seed;
      ASSERT_LE(ranges.Variation().over_q, variation.over_q) << family.name << ", seed " << seed;
      ASSERT_TRUE(variation.over_p >= 0 && variation.over_p <= 1)
          << family.name << ", seed " << seed;
      ASSERT_TRUE(variation.over_q >= 0 && variation.over_q <= 1)
          << family.name << ", seed " << seed;
    }
  }
}

TEST(ClipToFront, KeepsTheAreaOfBothHalves) {
  for (uint64_t seed = 1; seed <= kPairs; ++seed) {
    Random random(seed);
    const ConvexPolygon p = RandomPolygon(random, Vec3(0.0), RandomDirection(random), 1);
    const Vec3 n = RandomDirection(random);
    const Vec3 at(random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5);
    EXPECT_NEAR(ClipToFront(p, at, n, 0).Area() + ClipToFront(p, at, -n, 0).Area(), p.Area(), 1e-12)
        << "seed " << seed;
  }
}

TEST(Lanes, ArcTangentMatchesTheLibrary) {
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const double y = std::pow(10, 8 * random.Unit() - 4);
    const double x = (random.Unit() - 0.5) * std::pow(10, 8 * random.Unit() - 4);
    EXPECT_NEAR(Atan2Upper(Splat(y), Splat(x))[1], std::atan2(y, x), 2e-15);
  }
  EXPECT_EQ(Atan2Upper(Splat(0), Splat(0))[0], 0);
}

TEST(Lanes, LogarithmMatchesTheLibraryToOneUnitInTheLastPlace) {
  Random random(4);
  for (int i = 0; i < 200000; ++i) {
    const double x = i % 2 == 0 ? std::pow(10, 600 * random.Unit() - 300)
                                : 1 + (random.Unit() - 0.5) * std::pow(10, -15 * random.Unit());
    const double expected = std::log(x);
    const double unit = std::abs(std::nextafter(expected, 2 * expected) - expected);
    ASSERT_LE(std::abs(Log(Splat(x))[i % 4] - expected), unit) << x;
  }
  EXPECT_EQ(Log(Splat(1))[0], 0);
}

}  // namespace
}  // namespace isolux
