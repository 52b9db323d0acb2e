#include "worker/radiosity/coupling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/util/random.h"

namespace isolux {
namespace {

ConvexPolygon Quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d) { return {4, {a, b, c, d}}; }

double CouplingOf(const ConvexPolygon& p, const ConvexPolygon& q) {
  return Couple(MakeCouplingEnd(p), MakeCouplingEnd(q)).coupling_m2;
}

ConvexPolygon UnitSquareAt(double z, bool up, double x = 0, double y = 0) {
  const ConvexPolygon square = Quad({x, y, z}, {x + 1, y, z}, {x + 1, y + 1, z}, {x, y + 1, z});
  return up ? square : ConvexPolygon{4, {square.v[3], square.v[2], square.v[1], square.v[0]}};
}

// Howell C-11: directly opposed rectangles a × b at distance c.
double OpposedRectangles(double a, double b, double c) {
  const double x = a / c, y = b / c;
  const double x1 = std::sqrt(1 + x * x), y1 = std::sqrt(1 + y * y);
  return 2 / (std::numbers::pi * x * y) *
         (std::log(std::sqrt(x1 * x1 * y1 * y1 / (1 + x * x + y * y))) +
          x * y1 * std::atan(x / y1) + y * x1 * std::atan(y / x1) - x * std::atan(x) -
          y * std::atan(y));
}

TEST(PointFormFactors, MatchesClosedForms) {
  // A corner's view of a unit square opposite at distance 1 (exact: 0.1385316059948929).
  const ConvexPolygon above = UnitSquareAt(1, false);
  const Vec3 corner(0.0);
  const Lanes factor =
      PointFormFactors(Vec3x4({corner, corner, corner, corner}), {0, 0, 1}, {above.v.data(), 4});
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(factor[i], 0.1385316059948929, 1e-14);
  // The whole hemisphere, nearly.
  const ConvexPolygon wide =
      Quad({-1e6, 1e6, 1e-3}, {1e6, 1e6, 1e-3}, {1e6, -1e6, 1e-3}, {-1e6, -1e6, 1e-3});
  EXPECT_NEAR(
      PointFormFactors(Vec3x4({corner, corner, corner, corner}), {0, 0, 1}, {wide.v.data(), 4})[2],
      1.0, 1e-8);
}

TEST(Couple, MatchesOpposedSquaresAtEveryDistance) {
  for (const double distance : {0.05, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0}) {
    const double exact = OpposedRectangles(1, 1, distance);
    const PolygonCoupling c = Couple(MakeCouplingEnd(UnitSquareAt(0, true)),
                                     MakeCouplingEnd(UnitSquareAt(distance, false)));
    EXPECT_NEAR(c.coupling_m2, exact, 3 * c.error_m2 + 1e-6) << distance;
    EXPECT_NEAR(c.coupling_m2, exact, (distance < 1 ? 0.05 : 0.01) * exact) << distance;
    EXPECT_LE(c.coupling_m2, 1.0);
  }
}

TEST(Couple, MatchesSquaresWithASharedEdge) {
  const ConvexPolygon floor = UnitSquareAt(0, true);
  const ConvexPolygon wall = Quad({0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1});
  EXPECT_NEAR(CouplingOf(floor, wall), 0.2000437760754031, 5e-3);
}

TEST(Couple, IsZeroWhereNothingCanBeSeen) {
  const ConvexPolygon up = UnitSquareAt(0, true);
  EXPECT_EQ(CouplingOf(up, UnitSquareAt(0, true, 2)), 0);                   // coplanar
  EXPECT_EQ(CouplingOf(up, UnitSquareAt(1, true)), 0);                      // facing away
  EXPECT_EQ(CouplingOf(up, UnitSquareAt(-1, true)), 0);                     // behind
  EXPECT_EQ(CouplingOf(UnitSquareAt(0, false), UnitSquareAt(1, true)), 0);  // back to back
}

TEST(Couple, ClipsByTheOtherPlane) {
  // Squares that cross at a right angle through their middles: each sees half of the other
  // (exact: 0.1203180030884808).
  const ConvexPolygon floor = UnitSquareAt(0, true);
  const ConvexPolygon wall = Quad({0.5, 0, -0.5}, {0.5, 1, -0.5}, {0.5, 1, 0.5}, {0.5, 0, 0.5});
  EXPECT_NEAR(CouplingOf(floor, wall), 0.1203180030884808, 6e-3);
}

// A random triangle or convex quad of about this size.
ConvexPolygon RandomPolygon(Random& random, const Vec3& centre, double size) {
  const Vec3 n =
      glm::normalize(Vec3(random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5));
  const Vec3 s = glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
  const Vec3 t = glm::cross(n, s);
  ConvexPolygon polygon;
  polygon.count = random.Unit() < 0.5 ? 3 : 4;
  double angle = random.Unit();
  for (int i = 0; i < polygon.count; ++i) {
    angle += 2 * std::numbers::pi / polygon.count;
    polygon.v[i] = centre + size * (std::cos(angle) * s + std::sin(angle) * t);
  }
  return polygon;
}

TEST(Couple, IsBoundedAndFiniteAndAdditiveForRandomPairs) {
  for (uint64_t seed = 1; seed <= 20000; ++seed) {
    Random random(seed);
    const double ratio = std::pow(10, 4 * random.Unit() - 2);
    const ConvexPolygon p = RandomPolygon(random, Vec3(0.0), 1);
    const Vec3 offset(3 * random.Unit() - 1.5, 3 * random.Unit() - 1.5, 3 * random.Unit() - 1.5);
    const ConvexPolygon q = RandomPolygon(random, offset, ratio);
    const PolygonCoupling c = Couple(MakeCouplingEnd(p), MakeCouplingEnd(q));
    ASSERT_TRUE(std::isfinite(c.coupling_m2) && std::isfinite(c.error_m2)) << "seed " << seed;
    ASSERT_GE(c.coupling_m2, 0) << "seed " << seed;
    ASSERT_LE(c.coupling_m2, std::min(p.Area(), q.Area())) << "seed " << seed;
    ASSERT_TRUE(c.variation_p >= 0 && c.variation_p <= 1) << "seed " << seed;
    ASSERT_TRUE(c.variation_q >= 0 && c.variation_q <= 1) << "seed " << seed;
  }
}

TEST(Couple, SurvivesScaleAndRigidMotion) {
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(seed);
    const ConvexPolygon p = RandomPolygon(random, Vec3(0.0), 1);
    const ConvexPolygon q =
        RandomPolygon(random, Vec3(2 * random.Unit(), 2 * random.Unit(), 2), 0.5);
    const double expected = CouplingOf(p, q);
    for (const double scale : {1e-6, 1.0, 1e6}) {
      const double angle = 6 * random.Unit();
      const auto move = [&](ConvexPolygon polygon) {
        for (Vec3& v : polygon.v) {
          v = scale * Vec3(std::cos(angle) * v.x - std::sin(angle) * v.y + 3,
                           std::sin(angle) * v.x + std::cos(angle) * v.y - 5, v.z + 1);
        }
        return polygon;
      };
      EXPECT_NEAR(CouplingOf(move(p), move(q)) / (scale * scale), expected, 1e-9)
          << "seed " << seed;
    }
  }
}

TEST(ClipToFront, KeepsTheAreaOfBothHalves) {
  for (uint64_t seed = 1; seed <= 1000; ++seed) {
    Random random(seed);
    const ConvexPolygon p = RandomPolygon(random, Vec3(0.0), 1);
    const Vec3 n =
        glm::normalize(Vec3(random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5));
    const Vec3 at(random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5);
    EXPECT_NEAR(ClipToFront(p, at, n, 0).Area() + ClipToFront(p, at, -n, 0).Area(), p.Area(), 1e-12)
        << "seed " << seed;
  }
}

TEST(Atan2Upper, MatchesTheLibrary) {
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const double y = std::pow(10, 8 * random.Unit() - 4);
    const double x = (random.Unit() - 0.5) * std::pow(10, 8 * random.Unit() - 4);
    EXPECT_NEAR(Atan2Upper(Splat(y), Splat(x))[1], std::atan2(y, x), 2e-15);
  }
  EXPECT_EQ(Atan2Upper(Splat(0), Splat(0))[0], 0);
}

}  // namespace
}  // namespace isolux
