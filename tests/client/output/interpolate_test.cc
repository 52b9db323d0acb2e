#include "client/output/interpolate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "common/util/random.h"

namespace isolux {
namespace {

const Vec3 kU(0.6, 0.8, 0.0), kV(0.0, 0.0, 1.0);  // a plane at an angle

Vec3 At(double u, double v) { return Vec3(5, -3, 2) + u * kU + v * kV; }

// A rectangle with T-vertices on two sides.
std::vector<Vec3> Face() {
  return {At(0, 0), At(0.5, 0), At(1.25, 0), At(2, 0), At(2, 1), At(0, 1), At(0, 0.25)};
}

double Interpolate(const std::vector<Vec3>& face, const std::vector<double>& values,
                   const Vec3& point) {
  std::vector<double> weights(face.size());
  MeanValueWeights(face, point, weights);
  return std::inner_product(values.begin(), values.end(), weights.begin(), 0.0);
}

TEST(MeanValueWeights, AreExactForLinearFieldsAndSumToOne) {
  const std::vector<Vec3> face = Face();
  const auto linear = [](const Vec3& p) { return 3 + 2 * p.x - p.y + 0.5 * p.z; };
  std::vector<double> values, ones(face.size(), 1.0);
  for (const Vec3& v : face) values.push_back(linear(v));
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = At(2 * random.Unit(), random.Unit());
    EXPECT_NEAR(Interpolate(face, values, p), linear(p), 1e-9);
    EXPECT_NEAR(Interpolate(face, ones, p), 1, 1e-12);
  }
}

TEST(MeanValueWeights, AreLinearAlongSidesBetweenTVertices) {
  const std::vector<Vec3> face = Face();
  const std::vector<double> values{1, 5, 2, 0, 7, 3, 4};
  for (size_t k = 0; k < face.size(); ++k) {
    const size_t next = (k + 1) % face.size();
    for (const double t : {0.0, 0.3, 0.5, 0.9, 1.0}) {
      const Vec3 p = (1 - t) * face[k] + t * face[next];
      const double expected = (1 - t) * values[k] + t * values[next];
      EXPECT_NEAR(Interpolate(face, values, p), expected, 1e-6);
      // No jump on the way to the side.
      const Vec3 inside = p + 1e-7 * (At(0.9, 0.5) - p);
      EXPECT_NEAR(Interpolate(face, values, inside), expected, 1e-5);
    }
  }
}

TEST(MeanValueWeights, StayBetweenZeroAndOne) {
  const std::vector<Vec3> face = Face();
  std::vector<double> weights(face.size());
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    MeanValueWeights(face, At(2.02 * random.Unit() - 0.01, 1.02 * random.Unit() - 0.01), weights);
    for (const double w : weights) EXPECT_TRUE(w >= 0 && w <= 1 + 1e-12) << w;
  }
  MeanValueWeights(std::vector<Vec3>(3, At(0, 0)), At(0, 0), {weights.data(), 3});
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(std::isfinite(weights[k]));
}

double TwiceArea(const Vec3& a, const Vec3& b, const Vec3& c) {
  return glm::dot(glm::cross(b - a, c - a), glm::cross(kU, kV));
}

TEST(Triangulate, CoversTheFaceWithTrianglesOfSomeArea) {
  Random random(11);
  for (int trial = 0; trial < 200; ++trial) {
    // A triangle or quad with T-vertices on random sides.
    std::vector<Vec3> corners{At(0, 0), At(2, 0), At(2, 1)};
    if (trial % 2 == 0) corners.push_back(At(0, 1));
    std::vector<Vec3> face;
    for (size_t k = 0; k < corners.size(); ++k) {
      const int extra = static_cast<int>(random.Bits() % 5);
      for (int i = 0; i <= extra; ++i) {
        const double t = static_cast<double>(i) / (extra + 1);
        face.push_back((1 - t) * corners[k] + t * corners[(k + 1) % corners.size()]);
      }
    }
    const auto triangles = Triangulate(face);
    ASSERT_EQ(triangles.size(), face.size() - 2);
    double total = 0;
    std::set<uint32_t> used;
    for (const auto& t : triangles) {
      const double area = TwiceArea(face[t[0]], face[t[1]], face[t[2]]);
      EXPECT_GT(area, 1e-6);
      total += area;
      used.insert(t.begin(), t.end());
    }
    EXPECT_NEAR(total, trial % 2 == 0 ? 4 : 2, 1e-9);
    EXPECT_EQ(used.size(), face.size());
  }
}

TEST(Triangulate, CutsASquareAlongEitherDiagonalAndALineSomehow) {
  EXPECT_EQ(Triangulate(std::vector<Vec3>{At(0, 0), At(1, 0), At(1, 1), At(0, 1)}).size(), 2U);
  EXPECT_EQ(Triangulate(std::vector<Vec3>{At(0, 0), At(1, 0), At(2, 0), At(3, 0)}).size(), 2U);
}

}  // namespace
}  // namespace isolux
