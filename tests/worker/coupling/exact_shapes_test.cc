// Exact factors between shapes of many polygons: the six sides of boxes, discs as the limit of
// regular polygons, strips without end, spheres within spheres.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/exact_factors.h"
#include "tests/support/shapes.h"
#include "tests/worker/coupling/random_pairs.h"
#include "worker/coupling/coupling.h"

namespace isolux::testing {
namespace {

constexpr double kPi = std::numbers::pi;

double CouplingTo(double tolerance, const ConvexPolygon& p, const ConvexPolygon& q) {
  return Couple(MakeCouplingEnd(p), MakeCouplingEnd(q), tolerance).coupling_m2;
}

double CouplingOf(const std::vector<ConvexPolygon>& ps, const std::vector<ConvexPolygon>& qs) {
  double sum = 0;
  for (const ConvexPolygon& p : ps) {
    for (const ConvexPolygon& q : qs) sum += CouplingTo(1e-12, p, q);
  }
  return sum;
}

// ---- the six sides of boxes

double ExactBoxCoupling(const Vec3& size, int i, int j) {
  const int a = i / 2, b = j / 2;
  if (a == b) return OpposedRectangles(size[(a + 1) % 3], size[(a + 2) % 3], size[a]);
  return RightAngle(size[3 - a - b], size[b], size[a]);
}

TEST(ExactBoxes, AllFactorsOfTheSixSides) {
  for (const Vec3& size : {Vec3(1, 1, 1), Vec3(1, 1, 100), Vec3(1, 2, 3), Vec3(5, 4, 0.02)}) {
    for (int i = 0; i < 6; ++i) {
      const ConvexPolygon p = BoxFace(size, i);
      double row = 0;
      for (int j = 0; j < 6; ++j) {
        if (i == j) continue;
        const ConvexPolygon q = BoxFace(size, j);
        const double smaller = std::min(p.Area(), q.Area());
        const double found = CouplingTo(1e-9 * smaller, p, q);
        EXPECT_NEAR(found, ExactBoxCoupling(size, i, j), 1e-8 * smaller)
            << size.z << ": " << i << j;
        row += found;
      }
      EXPECT_NEAR(row / p.Area(), 1, 1e-8) << size.z << ": " << i;
    }
  }
}

// ---- discs

// Regular polygons of the same number of corners, the outermost at the radii of the discs.
double CoaxialPolygons(double r1, double r2, double h, int corners) {
  const std::vector<ConvexPolygon> low = Disc(r1, 0, corners, 1, true);
  // All sectors of the one see the other alike.
  return CouplingOf({low[0]}, Disc(r2, h, corners, 1, false)) / low[0].Area();
}

TEST(ExactDiscs, RegularPolygonsOf32Corners) {
  // To eighteen digits by a double contour integral.
  EXPECT_NEAR(CoaxialPolygons(1, 1, 1, 32), 0.380865679852947086, 1e-9);
}

// Errors of inscribed polygons are a series in even powers of 1/n: three refinements take off three
// terms.
TEST(ExactDiscs, AreTheLimitOfPolygons) {
  const double cases[][3] = {{0.5, 1, 1}, {1, 0.5, 1}, {1, 1, 1}, {1, 1, 0.5}, {1, 3, 0.25}};
  for (const auto& [r1, r2, h] : cases) {
    std::vector<double> values;
    for (const int corners : {24, 48, 96, 192}) {
      values.push_back(CoaxialPolygons(r1, r2, h, corners));
    }
    const double exact = CoaxialDiscs(r1, r2, h);
    EXPECT_LT(std::abs(values[1] - exact), 0.3 * std::abs(values[0] - exact));
    for (double power = 4; values.size() > 1; power *= 4) {
      for (size_t i = 0; i + 1 < values.size(); ++i) {
        values[i] = (power * values[i + 1] - values[i]) / (power - 1);
      }
      values.pop_back();
    }
    EXPECT_NEAR(values[0], exact, 1e-8) << r1 << " " << r2 << " " << h;
  }
}

// ---- strips without end

// What a metre of infinitely long strips exchanges: that by which twice the length exceeds the
// length. The ends cost the same in both but for 1/length².
template <typename MakePair>  // pair(length)
double PerMetre(const MakePair& make, double length) {
  const auto coupling = [&](double l) {
    const PolygonPair pair = make(l);
    return CouplingTo(1e-10, pair.p, pair.q);
  };
  return (coupling(2 * length) - coupling(length)) / length;
}

TEST(ExactStrips, GroovesAndOpposedStripsWithoutEnd) {
  for (const double degrees : {20.0, 60.0, 90.0, 150.0}) {
    const double angle = degrees * kPi / 180;
    const double found = PerMetre(
        [&](double l) {
          const Vec3 up(0, std::cos(angle), std::sin(angle));
          return PolygonPair{{4, {Vec3(0, 0, 0), Vec3(l, 0, 0), Vec3(l, 1, 0), Vec3(0, 1, 0)}},
                             {4, {Vec3(0, 0, 0), up, up + Vec3(l, 0, 0), Vec3(l, 0, 0)}}};
        },
        300);
    EXPECT_NEAR(found, Groove(angle), 1e-7) << degrees;
  }
  for (const double h : {0.1, 1.0, 3.0}) {
    const double found = PerMetre(
        [&](double l) {
          return PolygonPair{{4, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, l, 0), Vec3(0, l, 0)}},
                             {4, {Vec3(0, 0, h), Vec3(0, l, h), Vec3(1, l, h), Vec3(1, 0, h)}}};
        },
        300);
    EXPECT_NEAR(found, OpposedStrips(1, h), 1e-6) << h;
  }
}

// ---- spheres

// Everything that leaves the inner of two concentric bodies arrives at the outer one, whatever they
// are made of; of spheres every part of the outer one gets the ratio of the areas back.
TEST(ExactSpheres, OneInsideTheOther) {
  double last = 0;
  for (const int halvings : {0, 1, 2}) {
    const std::vector<ConvexPolygon> inner = Sphere(1, halvings, true),
                                     outer = Sphere(2, halvings, false);
    std::vector<double> back(outer.size(), 0);
    for (const ConvexPolygon& p : inner) {
      double row = 0;
      for (size_t j = 0; j < outer.size(); ++j) {
        const double coupling = CouplingTo(1e-10, p, outer[j]);
        row += coupling;
        back[j] += coupling;
      }
      EXPECT_NEAR(row / p.Area(), 1, 1e-7);
    }
    double total = 0, off = 0;
    for (size_t j = 0; j < outer.size(); ++j) {
      total += back[j];
      off = std::max(off, std::abs(back[j] / outer[j].Area() - 0.25));
    }
    EXPECT_NEAR(total / AreaOf(outer), AreaOf(inner) / AreaOf(outer), 1e-7);
    std::printf("%zu triangles: F back %.2g off\n", outer.size(), off);
    // All triangles of an icosahedron are alike; of finer ones the corners' are not.
    EXPECT_LT(off, halvings == 0 ? 1e-8 : halvings == 1 ? 0.003 : 0.5 * last);
    last = off;
  }
}

}  // namespace
}  // namespace isolux::testing
