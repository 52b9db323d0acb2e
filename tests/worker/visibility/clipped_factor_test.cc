#include "worker/visibility/clipped_factor.h"

#include <gtest/gtest.h>

#include "common/hierarchy/element.h"
#include "tests/worker/factors/exact_occluded.h"
#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

using testing::CornersOf;

double WholeFactor(const Vec3& x, const Vec3& n, std::span<const Vec3> q) {
  return PointFormFactors(Vec3x4({x, x, x, x}), n, q)[0];
}

std::vector<uint32_t> All(const OccluderSet& set) {
  std::vector<uint32_t> all(set.size());
  for (uint32_t i = 0; i < set.size(); ++i) all[i] = i;
  return all;
}

// ∫ over p of what is visible of q, at the middles of n × n cells.
double AtGrid(const testing::OccludedCase& c, const OccluderSet& set, int n) {
  PointClipper clipper(set);
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double s = (i + 0.5) / n, t = (j + 0.5) / n;
      const Vec3 x = c.p.v[0] + s * (c.p.v[1] - c.p.v[0]) + t * (c.p.v[3] - c.p.v[0]);
      const Vec3 normal = c.p.Normal();
      const double whole = WholeFactor(x, normal, CornersOf(c.q));
      sum += clipper.VisibleFactor(x, normal, CornersOf(c.q), All(set), whole);
    }
  }
  return sum * c.p.Area() / (n * n);
}

TEST(PointClipperTest, SixtyFourPointsGiveAHundredth) {
  for (const testing::OccludedCase& c : testing::OccludedCases()) {
    OccluderSet set(3);
    for (const ConvexPolygon& o : c.occluders) set.Add(CornersOf(o));
    const double error = std::abs(AtGrid(c, set, 8) - c.coupling_m2) / c.unobstructed_m2;
    std::printf("%s: 64 points %.2e", c.name.c_str(), error);
    EXPECT_LE(error, 0.01) << c.name;
    const double finer = std::abs(AtGrid(c, set, 32) - c.coupling_m2) / c.unobstructed_m2;
    std::printf(", after four subdivisions %.2e\n", finer);
    EXPECT_LE(finer, 1e-3) << c.name;
  }
}

// Strips without end, at the distance of their width, and halfway one of half the width: crossed
// strings round both of its edges, less those that are not crossed [Hottel54].
TEST(PointClipperTest, StripsWithoutEndPastAStrip) {
  constexpr double kFar = 1e6;
  const auto strip = [](double x0, double x1, double z, bool up) {
    return testing::AxisRectangle(2, z, x0, x1, -kFar, kFar, up);
  };
  OccluderSet set(kFar);
  set.Add(CornersOf(strip(0.25, 0.75, 0.5, true)));
  PointClipper clipper(set);
  const ConvexPolygon q = strip(0, 1, 1, false);
  const auto mean = [&](double from, double to) {  // Gauss's rule of five points
    constexpr double kAt[] = {-0.906179845938664, -0.538469310105683, 0, 0.538469310105683,
                              0.906179845938664};
    constexpr double kWeight[] = {0.236926885056189, 0.478628670499366, 0.568888888888889,
                                  0.478628670499366, 0.236926885056189};
    double sum = 0;
    for (int k = 0; k < 5; ++k) {
      const Vec3 x(0.5 * (from + to) + 0.5 * (to - from) * kAt[k], 0, 0), up(0, 0, 1);
      sum += 0.5 * kWeight[k] *
             clipper.VisibleFactor(x, up, CornersOf(q), All(set), WholeFactor(x, up, CornersOf(q)));
    }
    return sum;
  };
  // Smooth between the ends and the middle, from where one of the block's edges is before one of
  // q's.
  double found = 0;
  constexpr int kParts = 8;
  for (int i = 0; i < kParts; ++i) found += mean(1.0 * i / kParts, (i + 1.0) / kParts) / kParts;
  // On either side of the block both crossed strings and one of those that are not run over its
  // edge; what they run from there to the far ends cancels.
  const double to_edge = std::hypot(0.25, 0.5);
  EXPECT_NEAR(found, 2 * to_edge - 1, 1e-8);
}

// Against many rays from random points, with overlapping occluders of up to sixteen corners.
TEST(PointClipperTest, AgreesWithRays) {
  double worst = 0;
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(Hash(seed, 41));
    OccluderSet set(3);
    for (int i = 0; i < 6; ++i) {
      const Vec3 centre = testing::RandomPoint(random, Vec3(-.5, -.5, -.2), Vec3(1.5, 1.5, 1.2));
      set.Add(testing::RandomConvexPolygon(random, centre, 0.1 + 0.5 * random.Unit(),
                                           3 + static_cast<int>(random.Bits() % 14)));
    }
    const Vec3 x(random.Unit(), random.Unit(), 0), n(0, 0, 1);
    const ConvexPolygon q = testing::AxisRectangle(2, 1, 0, 1, 0, 1, false);
    const double whole = WholeFactor(x, n, CornersOf(q));
    PointClipper clipper(set);
    const double visible = clipper.VisibleFactor(x, n, CornersOf(q), All(set), whole);
    ASSERT_GE(visible, 0);
    ASSERT_LE(visible, whole);
    constexpr int kSide = 150;  // stratified over q
    double seen = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vec3 y((i % kSide + random.Unit()) / kSide, (i / kSide + random.Unit()) / kSide, 1);
      const Vec3 d = y - x;
      const double d2 = glm::dot(d, d);
      bool blocked = false;
      for (uint32_t o = 0; o < set.size() && !blocked; ++o) blocked = set.Blocks(o, x, y);
      if (!blocked) seen += d.z * d.z / (std::numbers::pi * d2 * d2);
    }
    seen /= kSide * kSide;
    worst = std::max(worst, std::abs(seen - visible));
    // The border of what is hidden passes ~10 × 150 cells, each off by half a cell's factor.
    EXPECT_NEAR(seen, visible, 4 * 0.32 * std::sqrt(1500.0) / (kSide * kSide) * 0.5)
        << "seed " << seed;
  }
  std::printf("largest difference from rays %.1e\n", worst);
}

// What is hidden by two sheets that overlap, or that share an edge, is hidden once.
TEST(PointClipperTest, OverlapsCountOnce) {
  const ConvexPolygon q = testing::AxisRectangle(2, 1, 0, 1, 0, 1, false);
  OccluderSet one(3), many(3);
  one.Add(CornersOf(testing::AxisRectangle(2, 0.5, 0.2, 0.7, 0.3, 0.6, true)));
  many.Add(CornersOf(testing::AxisRectangle(2, 0.5, 0.2, 0.45, 0.3, 0.6, true)));
  many.Add(CornersOf(testing::AxisRectangle(2, 0.5, 0.45, 0.7, 0.3, 0.6, false)));
  many.Add(CornersOf(testing::AxisRectangle(2, 0.5, 0.3, 0.6, 0.4, 0.6, true)));
  PointClipper clip_one(one), clip_many(many);
  for (int i = 0; i < 50; ++i) {
    Random random(static_cast<uint64_t>(i) + 900);
    const Vec3 x(random.Unit(), random.Unit(), 0), n(0, 0, 1);
    const double whole = WholeFactor(x, n, CornersOf(q));
    EXPECT_NEAR(clip_one.VisibleFactor(x, n, CornersOf(q), All(one), whole),
                clip_many.VisibleFactor(x, n, CornersOf(q), All(many), whole), 1e-13);
  }
}

}  // namespace
}  // namespace isolux
