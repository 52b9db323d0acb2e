#include "common/scene/triangulate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "common/util/random.h"

namespace isolux {
namespace {

double AreaOf(const std::vector<Vec3>& corners, const Triangulation& division) {
  double area = 0;
  for (const auto& t : division.triangles) {
    area +=
        0.5 * glm::length(glm::cross(corners[t[1]] - corners[t[0]], corners[t[2]] - corners[t[0]]));
  }
  return area;
}

Triangulation Divide(const std::vector<Vec3>& corners) {
  std::vector<uint32_t> ids(corners.size());
  std::iota(ids.begin(), ids.end(), 0U);
  return Triangulate(corners, ids);
}

TEST(Triangulate, ConcaveArrow) {
  const std::vector<Vec3> arrow = {{0, 0, 1}, {4, 0, 1}, {1, 1, 1}, {0, 4, 1}};
  const Triangulation division = Divide(arrow);
  EXPECT_TRUE(division.simple);
  EXPECT_EQ(division.triangles.size(), 2U);
  EXPECT_NEAR(AreaOf(arrow, division), 4.0, 1e-12);
}

TEST(Triangulate, TrianglesKeepTheOrientation) {
  const std::vector<Vec3> comb = {{0, 0, 0}, {5, 0, 0}, {5, 3, 0}, {4, 3, 0}, {4, 1, 0}, {3, 1, 0},
                                  {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  const Triangulation division = Divide(comb);
  EXPECT_TRUE(division.simple);
  EXPECT_NEAR(AreaOf(comb, division), 11.0, 1e-12);
  for (const auto& t : division.triangles) {
    EXPECT_GT(glm::cross(comb[t[1]] - comb[t[0]], comb[t[2]] - comb[t[0]]).z, 0);
  }
}

TEST(Triangulate, CornersOnALine) {
  const std::vector<Vec3> square = {{0, 0, 0}, {1, 0, 0},   {2, 0, 0}, {3, 0, 0},
                                    {3, 3, 0}, {1.5, 3, 0}, {0, 3, 0}, {0, 1, 0}};
  const Triangulation division = Divide(square);
  EXPECT_TRUE(division.simple);
  EXPECT_NEAR(AreaOf(square, division), 9.0, 1e-12);
}

TEST(Triangulate, HoleTiedInByASeam) {
  // Outer square 4 x 4 with a hole 2 x 2; the seam runs from corner 0 to the hole and back.
  const std::vector<Vec3> frame = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                                   {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  const std::vector<uint32_t> ids = {0, 1, 2, 3, 0, 4, 5, 6, 7, 4};
  const Triangulation division = Triangulate(frame, ids);
  EXPECT_TRUE(division.simple);
  EXPECT_NEAR(AreaOf(frame, division), 12.0, 1e-12);
}

TEST(Triangulate, SaysWhereTheOutlineCrossesItself) {
  EXPECT_FALSE(Divide({{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {2, 2, 0}}).simple);
  EXPECT_FALSE(Divide({{0, 0, 0}, {2, 3, 0}, {4, 0, 0}, {0, 2, 0}, {4, 2, 0}}).simple);
}

TEST(Triangulate, StarsInAnyPositionKeepTheirArea) {
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(Mix(seed));
    const int count = 5 + static_cast<int>(random.Bits() % (seed % 20 == 0 ? 300 : 40));
    const Vec3 u = glm::normalize(Vec3(random.Unit(), random.Unit(), random.Unit() + 0.1));
    const Vec3 v = glm::normalize(glm::cross(u, Vec3(random.Unit() + 0.1, -1, 0)));
    const Vec3 origin(100 * random.Unit(), 0, -3);
    std::vector<Vec3> star;
    double area = 0;
    double first_radius = 0, last_radius = 0;
    for (int i = 0; i < count; ++i) {
      const double radius = 0.2 + random.Unit();
      const double angle = 2 * std::numbers::pi * i / count;
      star.push_back(origin + radius * (std::cos(angle) * u + std::sin(angle) * v));
      if (i == 0) first_radius = radius;
      if (i > 0) area += 0.5 * std::sin(2 * std::numbers::pi / count) * radius * last_radius;
      last_radius = radius;
    }
    area += 0.5 * std::sin(2 * std::numbers::pi / count) * first_radius * last_radius;
    const Triangulation division = Divide(star);
    EXPECT_TRUE(division.simple) << "seed " << seed;
    EXPECT_NEAR(AreaOf(star, division), area, 1e-9) << "seed " << seed;
  }
}

TEST(Triangulate, AnyOutlineEnds) {
  for (uint64_t seed = 1; seed <= 2000; ++seed) {
    Random random(Mix(seed));
    std::vector<Vec3> corners(3 + random.Bits() % 20);
    const double scale = seed % 3 == 0 ? 3 : 1e6;  // small integers make coincidences
    for (Vec3& c : corners) {
      c = {std::floor(scale * random.Unit()), std::floor(scale * random.Unit()), 0};
    }
    for (const auto& t : Divide(corners).triangles) {
      for (const uint32_t i : t) ASSERT_LT(i, corners.size()) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace isolux
