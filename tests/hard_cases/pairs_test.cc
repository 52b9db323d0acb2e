// Hard cases of the coupling of two polygons.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "tests/hard_cases/hard_case.h"
#include "tests/worker/coupling/random_pairs.h"
#include "tests/worker/coupling/reference.h"
#include "worker/coupling/clip.h"
#include "worker/coupling/coupling.h"

namespace isolux {
namespace {

using testing::HardCase;
using testing::MakePair;
using testing::Motion;
using testing::PairFamilies;
using testing::PairFamily;
using testing::PolygonPair;
using testing::Reversed;

constexpr double kPi = std::numbers::pi;
constexpr uint64_t kSeeds = 10'000;  // pairs of each kind
// Of edges, that a coupling may take: some 75 ns each, so that this is a fifth of a millisecond.
constexpr double kMostPieces = 2500;

ConvexPolygon Quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return {4, {a, b, c, d}};
}
ConvexPolygon Floor(double width = 1, double depth = 1, double z = 0) {
  return Quad({0, 0, z}, {width, 0, z}, {width, depth, z}, {0, depth, z});
}
// On the side y = 0 of the floor, leaning over it or away from it.
ConvexPolygon Wall(double degrees, double from = 0, double to = 1, double height = 1) {
  const double angle = degrees * kPi / 180;
  const double y = height * std::cos(angle), z = height * std::sin(angle);
  return Quad({from, 0, 0}, {from, y, z}, {to, y, z}, {to, 0, 0});
}
ConvexPolygon Moved(ConvexPolygon polygon, const Vec3& by) {
  for (Vec3& v : polygon.v) v += by;
  return polygon;
}

double Smaller(const ConvexPolygon& p, const ConvexPolygon& q) {
  return std::min(p.Area(), q.Area());
}
// To a share of the smaller area.
PairCoupling CoupleTo(double tolerance, const ConvexPolygon& p, const ConvexPolygon& q) {
  return Couple(MakeCouplingEnd(p), MakeCouplingEnd(q), tolerance * Smaller(p, q));
}
double FactorTo(double tolerance, const ConvexPolygon& p, const ConvexPolygon& q) {
  return CoupleTo(tolerance, p, q).coupling_m2 / Smaller(p, q);
}
// By how much a coupling is outside [0, the smaller area]; infinite if it is no number.
double OutOfBounds(double factor) {
  return std::isfinite(factor) ? std::max({0.0, -factor, factor - 1}) : INFINITY;
}

std::string Where(const char* family, uint64_t seed) {
  return std::string(family) + ", seed " + std::to_string(seed);
}

template <typename Body>  // body(pair, seed, where)
void ForPairs(const Body& body) {
  for (const PairFamily& family : PairFamilies()) {
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
      body(MakePair(family, seed), seed, family.name);
    }
  }
}

// Moving and scaling round corners by a share of the extent, which is the larger end's: of the
// smaller one's size that is as much more as it is smaller. Over a thousandth of the sizes' ratio,
// where that is above 1.
double OverSizeRatio(double change, const PolygonPair& pair) {
  const double p = MakeCouplingEnd(pair.p).radius_m, q = MakeCouplingEnd(pair.q).radius_m;
  return change / std::max(1.0, 1e-3 * std::max(p / q, q / p));
}
constexpr const char* kOverRatio =
    "change of F, over a thousandth of the sizes' ratio where that is above 1";

TEST(HardPairs, SwappedEnds) {
  HardCase same("1", "any two polygons, swapped", "pairs whose coupling has other bits", 0);
  ForPairs([&](const PolygonPair& pair, uint64_t seed, const char* family) {
    const double tolerance = std::array{1e-2, 1e-4, 1e-8}[seed % 3];
    const double one = CoupleTo(tolerance, pair.p, pair.q).coupling_m2;
    const double other = CoupleTo(tolerance, pair.q, pair.p).coupling_m2;
    same.Measure(std::memcmp(&one, &other, sizeof one) == 0 ? 0 : 1, Where(family, seed));
  });
}

TEST(HardPairs, RigidMotion) {
  HardCase equal("2", "two polygons, turned at random", kOverRatio, 1e-10);
  ForPairs([&](const PolygonPair& pair, uint64_t seed, const char* family) {
    Random random(seed);
    const Motion motion = testing::RandomRotation(random);
    const double change =
        std::abs(FactorTo(1e-11, pair.p, pair.q) - FactorTo(1e-11, motion(pair.p), motion(pair.q)));
    equal.Measure(OverSizeRatio(change, pair), Where(family, seed));
  });
}

TEST(HardPairs, Scaling) {
  HardCase equal("3", "two polygons, 1e-6 and 1e6 times as large", kOverRatio, 1e-12);
  // As many digits go as an end is thin.
  HardCase thin("3a", "the same, of an end a hundred times as long as wide", "change of F", 1e-11);
  ForPairs([&](const PolygonPair& pair, uint64_t seed, const char* family) {
    Motion motion;
    motion.scale = seed % 2 == 0 ? 1e-6 : 1e6;
    const double tolerance = std::array{1e-2, 1e-4, 1e-6}[seed % 3];
    const double change = std::abs(FactorTo(tolerance, pair.p, pair.q) -
                                   FactorTo(tolerance, motion(pair.p), motion(pair.q)));
    const CouplingEnd p = MakeCouplingEnd(pair.p), q = MakeCouplingEnd(pair.q);
    const double width =
        std::min(p.area_m2 / (p.radius_m * p.radius_m), q.area_m2 / (q.radius_m * q.radius_m));
    (width < 0.02 ? thin : equal).Measure(OverSizeRatio(change, pair), Where(family, seed));
  });
}

TEST(HardPairs, FarFromTheOrigin) {
  HardCase equal("4", "two polygons, moved by a million sizes of the smaller", "change of F", 1e-7);
  ForPairs([&](const PolygonPair& pair, uint64_t seed, const char* family) {
    const double size =
        std::min(MakeCouplingEnd(pair.p).radius_m, MakeCouplingEnd(pair.q).radius_m);
    Motion motion;
    motion.offset = 1e6 * size * Vec3(0.6, -0.48, 0.64);
    equal.Measure(
        std::abs(FactorTo(1e-9, pair.p, pair.q) - FactorTo(1e-9, motion(pair.p), motion(pair.q))),
        Where(family, seed));
  });
}

TEST(HardPairs, SharedSideAtAnyAngle) {
  HardCase bounded("5", "squares that share a side, 0.1 to 179.9 degrees",
                   "how far F is outside [0, 1]", 0);
  HardCase monotone("5a", "the same", "by how much F grows with the angle", 1e-9);
  for (const double tolerance : {1e-3, 1e-9}) {
    double last = 1;
    for (const double degrees :
         {0.1, 1.0, 10.0, 30.0, 60.0, 90.0, 120.0, 150.0, 170.0, 179.0, 179.9}) {
      const double factor = FactorTo(tolerance, Floor(), Wall(degrees));
      const std::string where = std::to_string(degrees) + " degrees";
      bounded.Measure(OutOfBounds(factor), where);
      monotone.Measure(std::max(0.0, factor - last), where);
      last = factor;
    }
  }
}

TEST(HardPairs, SharedCornerOnly) {
  HardCase exact("6", "faces of an octahedron that share a corner", "|F - exact|", 1e-8);
  const ConvexPolygon p{3, {Vec3(0, 0, 1), Vec3(0, 1, 0), Vec3(1, 0, 0)}};
  const ConvexPolygon q{3, {Vec3(0, 0, 1), Vec3(0, -1, 0), Vec3(-1, 0, 0)}};
  exact.Measure(std::abs(FactorTo(1e-9, p, q) - 0.128986791870356393 / p.Area()));
}

TEST(HardPairs, GapsThatClose) {
  HardCase continuous("7", "a floor and a wall with a gap of 1e-3 to 1e-12, or none",
                      "change of F beyond the gap's width", 1e-9);
  for (const double degrees : {30.0, 90.0, 150.0}) {
    const double closed = FactorTo(1e-10, Floor(), Wall(degrees));
    for (const double gap : {1e-3, 1e-6, 1e-9, 1e-12, 0.0}) {
      const double open = FactorTo(1e-10, Moved(Floor(), {0, gap, 0}), Wall(degrees));
      continuous.Measure(std::max(0.0, std::abs(open - closed) - gap),
                         std::to_string(degrees) + " degrees, gap " + std::to_string(gap));
    }
  }
}

TEST(HardPairs, PlatesThatClose) {
  HardCase bounded("8", "opposed squares at 1e-1 to 1e-8", "how far F is outside [0, 1]", 0);
  HardCase monotone("8a", "the same", "by how much F falls as they close", 1e-10);
  HardCase limit("8b", "the same", "distance of F from 1, less twice that of the squares", 1e-10);
  for (const double tolerance : {1e-3, 1e-11}) {
    double last = 0;
    for (double distance = 1e-1; distance > 0.5e-8; distance /= 10) {
      const double factor = FactorTo(tolerance, Floor(), Reversed(Floor(1, 1, distance)));
      const std::string where = "distance " + std::to_string(distance);
      bounded.Measure(OutOfBounds(factor), where);
      if (tolerance < 1e-6) {
        monotone.Measure(std::max(0.0, last - factor), where);
        limit.Measure(std::max(0.0, 1 - factor - 2 * distance), where);
      }
      last = factor;
    }
  }
}

TEST(HardPairs, NothingToSee) {
  HardCase zero("9", "coplanar, back to back, facing away; turned at random", "C over the area", 0);
  const std::vector<PolygonPair> pairs = {{Floor(), Moved(Floor(), {1, 0, 0})},
                                          {Floor(), Moved(Floor(), {2, 0.3, 0})},
                                          {Floor(), Moved(Floor(), {0.4, 0.3, 0})},
                                          {Floor(), Floor()},
                                          {Floor(), Reversed(Floor())},
                                          {Reversed(Floor()), Moved(Floor(), {0, 0, 1})},
                                          {Floor(), Moved(Floor(), {0.2, 0.1, 0.7})},
                                          {Floor(), Moved(Floor(), {0, 0, -0.5})}};
  for (size_t i = 0; i < pairs.size(); ++i) {
    for (uint64_t seed = 0; seed < 100; ++seed) {
      Random random(seed);
      const Motion motion = seed == 0 ? Motion() : testing::RandomRotation(random);
      const PairCoupling coupling = CoupleTo(1e-3, motion(pairs[i].p), motion(pairs[i].q));
      zero.Measure(coupling.coupling_m2 + coupling.error_m2,
                   "pair " + std::to_string(i) + ", seed " + std::to_string(seed));
    }
  }
}

TEST(HardPairs, NearlyInOnePlane) {
  HardCase small("10", "squares of one plane tilted by 1e-9, both ways",
                 "how far F is outside [0, 1e-8], beyond the tolerance", 0);
  for (const double gap : {0.0, 1e-3, 0.5}) {
    for (const double tilt : {1e-9, -1e-9}) {
      const double z = -tilt;  // about the near side
      const ConvexPolygon q = Quad({-1 - gap, 0, z}, {-gap, 0, 0}, {-gap, 1, 0}, {-1 - gap, 1, z});
      for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12}) {
        const double factor = FactorTo(tolerance, Floor(), q);
        const double most = 1e-8 + (tolerance > 1e-9 ? tolerance : 0);
        small.Measure(std::isfinite(factor) ? std::max({0.0, -factor, factor - most}) : INFINITY,
                      "gap " + std::to_string(gap));
      }
    }
  }
}

TEST(HardPairs, PlanesThatCutBoth) {
  HardCase exact("11", "squares through each other's middle", "|F - exact|", 1e-8);
  const ConvexPolygon wall = Quad({0.5, 0, -0.5}, {0.5, 0, 0.5}, {0.5, 1, 0.5}, {0.5, 1, -0.5});
  exact.Measure(std::abs(FactorTo(1e-9, Floor(), wall) - 0.120318003088480848));

  HardCase additive("11a", "crossing polygons, one divided in four",
                    "|C - sum over the parts| over the smaller area", 1e-8);
  const PairFamily* crossing = nullptr;
  for (const PairFamily& family : PairFamilies()) {
    if (std::string(family.name) == "crossing planes") crossing = &family;
  }
  ASSERT_NE(crossing, nullptr);
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const PolygonPair pair = MakePair(*crossing, seed);
    ConvexPolygon triangle = pair.q;
    triangle.count = 3;
    const double tolerance = 1e-9 * Smaller(pair.p, triangle);
    const auto couple = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
      const ConvexPolygon part{3, {a, b, c}};
      return Couple(MakeCouplingEnd(pair.p), MakeCouplingEnd(part), tolerance).coupling_m2;
    };
    const auto& [a, b, c, unused] = triangle.v;
    const Vec3 ab = 0.5 * (a + b), bc = 0.3 * b + 0.7 * c, ca = 0.9 * c + 0.1 * a;
    const double sum =
        couple(a, ab, ca) + couple(ab, b, bc) + couple(ca, bc, c) + couple(ab, bc, ca);
    additive.Measure(std::abs(sum - couple(a, b, c)) / Smaller(pair.p, triangle),
                     "seed " + std::to_string(seed));
  }
}

TEST(HardPairs, Needles) {
  HardCase exact("12", "needle triangles and strips 1:1e5 at their own width",
                 "relative error of C against long double", 1e-6);
  HardCase quick("12b", "the same, at 1e-2, 1e-4 and 1e-8", "pieces of edges integrated",
                 kMostPieces);
  constexpr double kWidth = 1e-5;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const double skew = random.Unit(), shift = kWidth * random.Unit();
    const ConvexPolygon p{3, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(skew, kWidth, 0)}};
    const ConvexPolygon q{3,
                          {Vec3(0, shift, kWidth), Vec3(random.Unit(), shift + kWidth, kWidth),
                           Vec3(1, shift, 1.5 * kWidth)}};
    const ConvexPolygon strip = Floor(1, kWidth), roof = Reversed(Floor(1, kWidth, kWidth));
    const Motion motion = seed == 0 ? Motion() : testing::RandomRotation(random);
    for (const PolygonPair& pair : {PolygonPair{p, q}, PolygonPair{strip, roof}}) {
      const ConvexPolygon a = motion(pair.p), b = motion(pair.q);
      const auto reference = static_cast<double>(testing::CouplingByContours(a, b));
      exact.Measure(std::abs(CoupleTo(1e-8, a, b).coupling_m2 - reference) / reference,
                    "seed " + std::to_string(seed));
      for (const double tolerance : {1e-2, 1e-4, 1e-8}) {
        quick.Measure(CoupleTo(tolerance, a, b).pieces, "seed " + std::to_string(seed));
      }
    }
  }
}

TEST(HardPairs, NoPairTakesLong) {
  HardCase quick("13c", "any two polygons at 1e-8", "pieces of edges integrated", kMostPieces);
  ForPairs([&](const PolygonPair& pair, uint64_t seed, const char* family) {
    quick.Measure(CoupleTo(1e-8, pair.p, pair.q).pieces, Where(family, seed));
  });
}

TEST(HardPairs, StraightCorners) {
  HardCase whole("12a", "quads with a corner of 179.99 degrees",
                 "|C - sum over the two triangles| over the smaller area", 1e-7);
  const PairFamily& family = PairFamilies().back();
  ASSERT_EQ(std::string(family.name), "straight corners");
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const PolygonPair pair = MakePair(family, seed);
    const double tolerance = 1e-9 * Smaller(pair.p, pair.q);
    const auto couple = [&](const ConvexPolygon& q) {
      return Couple(MakeCouplingEnd(pair.p), MakeCouplingEnd(q), tolerance).coupling_m2;
    };
    const auto& v = pair.q.v;
    const double sum = couple({3, {v[0], v[1], v[2]}}) + couple({3, {v[0], v[2], v[3]}});
    whole.Measure(std::abs(couple(pair.q) - sum) / Smaller(pair.p, pair.q),
                  "seed " + std::to_string(seed));
  }
}

// The floor fills half of what a small square standing on it sees.
TEST(HardPairs, FarUnequalSizesThatTouch) {
  HardCase bounded("13", "a square of 1e-6 or 1e-9 standing on a floor, or on its edge",
                   "how far F of the small one is outside [0, 1]", 0);
  HardCase half("13a", "the same", "|F - 1/2|", 1e-6);
  HardCase quick("13b", "the same, at 1e-3 and 1e-8, in either order", "pieces of edges integrated",
                 kMostPieces);
  for (const double size : {1e-6, 1e-9}) {
    for (const double y : {0.0, 0.5}) {
      for (const double tolerance : {1e-3, 1e-8}) {
        const ConvexPolygon wall = Moved(Wall(90, 0.37, 0.37 + size, size), {0, y, 0});
        const double factor = FactorTo(tolerance, Floor(), wall);
        const std::string where = "size " + std::to_string(size) + ", y " + std::to_string(y);
        bounded.Measure(OutOfBounds(factor), where);
        if (tolerance < 1e-6) half.Measure(std::abs(factor - 0.5), where);
        quick.Measure(CoupleTo(tolerance, Floor(), wall).pieces, where);
        quick.Measure(CoupleTo(tolerance, wall, Floor()).pieces, where);
      }
    }
  }
}

}  // namespace
}  // namespace isolux
