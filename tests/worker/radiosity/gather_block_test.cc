// The kernels of the gather in single precision, against the closed form in double.
#include "worker/radiosity/gather_block.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/polygons.h"
#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

using testing::AxisRectangle;
using testing::RandomConvexPolygon;
using testing::RandomDirection;
using testing::RandomPoint;
using testing::ToPolygon;

double InDouble(const Vec3& x, const Vec3& n, const ClippedPolygon& q, const Vec3& q_normal) {
  if (glm::dot(q_normal, x - q.v[0]) <= 0) return 0;
  return PointFormFactors(Vec3x4({x, x, x, x}), n, q.corners())[0];
}

TEST(FloatLanes, ArcTangentMatchesTheLibrary) {
  Random random(7);
  for (int i = 0; i < 100000; ++i) {
    const auto y = static_cast<float>(std::exp(20 * random.Unit() - 10));
    const auto x = static_cast<float>((random.Unit() - 0.5) * std::exp(20 * random.Unit() - 10));
    const double exact = std::atan2(static_cast<double>(y), static_cast<double>(x));
    EXPECT_NEAR(Atan2Upper(SplatFloat(y), SplatFloat(x))[3] / exact, 1, 5e-7) << y << " " << x;
  }
  EXPECT_EQ(Atan2Upper(SplatFloat(0), SplatFloat(0))[0], 0);
}

TEST(FloatLanes, HashedNumbersAreUniform) {
  std::array<int, 16> count{};
  constexpr int kRounds = 20000;
  for (uint32_t i = 0; i < kRounds; ++i) {
    const FloatLanes u = UnitFromHash(UInt32Lanes{0, 1, 2, 3, 4, 5, 6, 7} + 8 * i);
    for (int lane = 0; lane < 8; ++lane) {
      ASSERT_GE(u[lane], 0);
      ASSERT_LT(u[lane], 1);
      ++count[static_cast<size_t>(16 * u[lane])];
    }
  }
  const double expected = 8.0 * kRounds / 16;
  for (const int c : count) EXPECT_NEAR(c, expected, 5 * std::sqrt(expected));
}

TEST(SourceBlock, FormFactorsMatchTheClosedForm) {
  constexpr uint64_t kSeed = 20260;
  SCOPED_TRACE(kSeed);
  Random random(kSeed);
  double worst = 0;
  for (int round = 0; round < 3000; ++round) {
    const Vec3 n = RandomDirection(random);
    const Vec3 origin = RandomPoint(random, Vec3(-50), Vec3(50));
    const double scale = std::exp2(40 * random.Unit() - 20);
    const SurfaceFrame frame = FrameOf(n);
    SourceBlock block;
    block.Start(frame, scale * origin, std::ldexp(1.0, -std::ilogb(100 * scale)));
    std::vector<std::pair<ClippedPolygon, Vec3>> sources;
    while (sources.size() < 8) {
      const double away = std::exp(6 * random.Unit() - 3);
      const Vec3 centre = origin + away * RandomDirection(random);
      ConvexPolygon q = ToPolygon(RandomConvexPolygon(random, centre, away * (0.05 + random.Unit()),
                                                      random.Unit() < 0.5 ? 3 : 4));
      const Vec3 normal = q.Normal();
      for (Vec3& v : q.v) v *= scale;
      const ClippedPolygon front = ClipToFront(q, scale * origin, n, 0);
      if (front.count == 0 || front.count == 5) continue;
      block.Add(front, normal, {}, {});
      sources.emplace_back(front, normal);
    }
    const Vec3 x = scale * (origin + 0.3 * random.Unit() * frame.u - 0.2 * random.Unit() * frame.v);
    const FloatLanes factors = FormFactors(block.octets()[0], block.At(x));
    for (int i = 0; i < 8; ++i) {
      const double exact = InDouble(x, n, sources[i].first, sources[i].second);
      // A source seen on edge may flip to its back.
      const double height = glm::dot(sources[i].second, x - sources[i].first.v[0]);
      if (std::abs(height) < 1e-5 * scale) continue;
      worst = std::max(worst, std::abs(factors[i] - exact));
    }
  }
  EXPECT_LT(worst, 2e-5);
}

// Points a hundred-thousandth of an element away from the wall that stands on its edge see half a
// quarter of the sphere less the sides: the nearness must not turn into noise, however small the
// element is beside the wall.
TEST(SourceBlock, PointsInTheCornerOfARoomSeeTheWall) {
  const ConvexPolygon wall = AxisRectangle(0, 0, -50, 50, 0, 3, true);  // x = 0, front to +x
  for (const double size : {10.0, 1.0, 0.1, 0.01, 0.001}) {
    const Vec3 n(0, 0, 1), origin(0.5 * size, 0.3, 0);
    SourceBlock block;
    block.Start(FrameOf(n), origin, 1.0 / 128);
    const ClippedPolygon front = ClipToFront(wall, origin, n, 1e-10);
    ASSERT_EQ(front.count, 4);
    block.Add(front, wall.Normal(), {}, {});
    for (const double share : {0.5, 0.1, 1e-3, 1e-5}) {
      const Vec3 x(share * size, 0.3, 0);
      const double exact = InDouble(x, n, front, wall.Normal());
      EXPECT_NEAR(FormFactors(block.octets()[0], block.At(x))[0], exact, 1e-4)
          << "element " << size << ", point " << share;
    }
  }
}

TEST(SourceBlock, FiveCornersAreTwoParts) {
  Random random(3);
  ClippedPolygon five;
  const std::vector<Vec3> corners = RandomConvexPolygon(random, Vec3(0, 0, 2), 0.7, 5);
  five.count = 5;
  std::copy(corners.begin(), corners.end(), five.v.begin());
  const Vec3 normal = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
  const Vec3 n = glm::dot(normal, Vec3(0, 0, 1)) < 0 ? Vec3(0, 0, 1) : Vec3(0, 0, -1);
  if (n.z < 0) GTEST_FAIL() << "the seed gives a polygon that faces away";
  SourceBlock block;
  block.Start(FrameOf(n), Vec3(0.0), 1);
  block.Add(five, normal, {}, {});
  const FloatLanes factors = FormFactors(block.octets()[0], block.At(Vec3(0.0)));
  EXPECT_NEAR(factors[0] + factors[1], InDouble(Vec3(0.0), n, five, normal), 1e-6);
  for (int i = 2; i < 8; ++i) EXPECT_EQ(factors[i], 0);
}

TEST(SourceBlock, NothingPaddedBringsLight) {
  SourceBlock block;
  block.Start(FrameOf(Vec3(0, 0, 1)), Vec3(0.0), 1);
  block.AddCluster(Vec3(0, 0, 1), 0.5, 1, Lanes{1, 1, 1, 0});
  const FloatLanes factors = FormFactors(block.clusters()[0], block.At(Vec3(0.0)));
  EXPECT_NEAR(factors[0], 0.5 / (std::numbers::pi + 0.5), 1e-6);
  for (int i = 1; i < 8; ++i) EXPECT_EQ(factors[i] * block.clusters()[0].radiosity[0][i], 0);
}

}  // namespace
}  // namespace isolux
