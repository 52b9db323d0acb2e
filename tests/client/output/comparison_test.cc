#include "client/output/comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/client/output/patches.h"

namespace isolux {
namespace {

// One surface [0, 4] × [0, 1] in `parts` strips, with this irradiance at x in all channels.
template <typename Function>
PatchFile Strips(int parts, const Function& irradiance) {
  PatchFile file;
  for (int i = 0; i < parts; ++i) {
    const double a = 4.0 * i / parts, b = 4.0 * (i + 1) / parts;
    PatchFace& face = testing::AddFace(file, {{a, 0, 1}, {b, 0, 1}, {b, 1, 1}, {a, 1, 1}}, 0, 0);
    face.polygon = face.surface = 0;
  }
  for (PatchVertex& v : file.vertices) {
    v.irradiance.fill(static_cast<float>(irradiance(v.position.x)));
  }
  return file;
}

TEST(Compare, IsNothingForTheSame) {
  const PatchFile a = Strips(7, [](double x) { return 1 + x * x; });
  const auto result = Compare(a, a, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 0, 1e-12);
  EXPECT_NEAR(result->max_relative, 0, 1e-12);
  EXPECT_EQ(result->unmatched, 0U);
}

TEST(Compare, GivesTheIntegralsWhateverTheMeshes) {
  // h = 2, |Δ| = x / 4: mean 1/2, square 1/3, largest 1.
  const PatchFile a = Strips(3, [](double x) { return 2 + 0.25 * x; });
  const PatchFile b = Strips(5, [](double) { return 2; });
  const auto result = Compare(a, b, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 0.25, 3e-4);
  EXPECT_NEAR(result->rms_relative, std::sqrt(1.0 / 3) / 2, 3e-4);
  EXPECT_NEAR(result->max_relative, 0.5, 1e-4);
  EXPECT_NEAR(result->p95_local, 0.475, 3e-4);
  EXPECT_EQ(result->samples, 1U << 18);
}

TEST(Compare, SurfacesOfOneOnlyAreDarkInTheOther) {
  PatchFile a = Strips(2, [](double) { return 1; }), b = a;
  testing::AddFace(a, {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}, 0, 1).polygon = 8;
  testing::AddFace(b, {{0, 0, 3}, {0, 1, 3}, {2, 1, 3}, {2, 0, 3}}, 0, 1).polygon = 9;
  const auto result = Compare(a, b, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 4.0 / 6, 1e-4);
  EXPECT_GT(result->unmatched, 0U);
}

// Two bands of which the first is off by 1 of 4, the second by x of 8, and the third dark.
TEST(Compare, TellsBandsApart) {
  const auto with_bands = [](int parts, double first, double slope) {
    PatchFile file = Strips(parts, [](double) { return 12; });
    file.bands = {{400, 490}, {490, 580}, {580, 700}};
    for (const PatchVertex& v : file.vertices) {
      const auto second = static_cast<float>(8 + slope * v.position.x);
      const float irradiance[] = {static_cast<float>(first), second, 0};
      for (const float radiosity : {0.0F, 0.0F, 0.0F}) {
        file.vertex_bands.values.push_back(radiosity);
      }
      for (const float h : irradiance) file.vertex_bands.values.push_back(h);
    }
    return file;
  };
  const PatchFile a = with_bands(3, 5, 1), b = with_bands(5, 4, 0);
  ASSERT_TRUE(HaveSameBands(a, b));
  const auto result = CompareBands(a, b, {.samples = 1 << 14});
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, (1 + 2) / 12.0, 1e-3);
  ASSERT_EQ(result->bands.size(), 3U);
  EXPECT_NEAR(result->bands[0].l1_relative, 0.25, 1e-6);
  EXPECT_NEAR(result->bands[0].max_relative, 0.25, 1e-6);
  EXPECT_NEAR(result->bands[1].l1_relative, 0.25, 1e-3);
  EXPECT_NEAR(result->bands[1].rms_relative, std::sqrt(16 / 3.0) / 8, 1e-3);
  EXPECT_NEAR(result->bands[1].max_relative, 0.5, 1e-3);
  EXPECT_TRUE(result->bands[2].dark);
  EXPECT_FALSE(CompareBands(a, with_bands(2, 0, -8), {.samples = 0}).has_value());
  PatchFile other = b;
  other.bands[0].low_nm = 410;
  EXPECT_FALSE(HaveSameBands(a, other));
  EXPECT_FALSE(HaveSameBands(Strips(1, [](double) { return 1; }), b));
}

TEST(Compare, TellsSidesApart) {
  PatchFile a = Strips(2, [](double) { return 1; }), b = a;
  for (PatchFace& face : a.faces) face.side = 1;
  const auto result = Compare(a, b, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 2, 1e-9);
}

TEST(Compare, NeedsSomethingToBeRelativeTo) {
  const PatchFile dark = Strips(2, [](double) { return 0; });
  const PatchFile lit = Strips(2, [](double) { return 1; });
  EXPECT_FALSE(Compare(lit, dark, {}).has_value());
  EXPECT_FALSE(Compare({}, {}, {}).has_value());
  const auto result = Compare(dark, lit, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 1, 1e-9);
}

// Points along the strips with what is expected there.
std::vector<ReferencePoint> PointsOnStrips(double expected, double deviation) {
  std::vector<ReferencePoint> points;
  for (int i = 0; i < 400; ++i) {
    const double x = 4 * (i + 0.5) / 400;
    points.push_back({{x, 0.3, 1}, {0, 0, 1}, Rgb(expected), Rgb(deviation)});
  }
  return points;
}

TEST(CompareWithPoints, GivesTheErrorOfAKnownField) {
  // Expected 2, found 2 + x / 4 − 1/2: |Δ| has mean 1/4, square 1/12, largest 1/2, no bias.
  const PatchFile file = Strips(5, [](double x) { return 1.5 + 0.25 * x; });
  const auto result = Compare(file, PointsOnStrips(2, 0));
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 0.125, 1e-5);
  EXPECT_NEAR(result->rms_relative, std::sqrt(1.0 / 12) / 2, 1e-5);
  EXPECT_NEAR(result->max_relative, 0.25, 1e-3);
  EXPECT_NEAR(result->p95_local, 0.2375, 1e-3);
  EXPECT_NEAR(result->bias_relative, 0, 1e-6);
  EXPECT_EQ(result->samples, 400U);
  EXPECT_EQ(result->unmatched, 0U);
}

TEST(CompareWithPoints, ChannelsAddUp) {
  PatchFile file = Strips(1, [](double) { return 0; });
  for (PatchVertex& v : file.vertices) v.irradiance = {3, 1, 2};
  const ReferencePoint point{{1, 0.5, 1}, {0, 0, 1}, {2, 2, 2}, Rgb(0.0)};
  const auto result = Compare(file, std::vector{point});
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 2.0 / 6, 1e-6);
  EXPECT_NEAR(result->bias_relative, 0, 1e-6);
}

TEST(CompareWithPoints, TakesOffTheNoiseOfThePoints) {
  // An error of 0.5 and normal noise of 0.3 look like √(0.25 + 2/π 0.09) on average.
  const double seen = std::sqrt(0.25 + 2 / M_PI * 0.09);
  const PatchFile file = Strips(2, [&](double) { return 2 + seen; });
  const auto result = Compare(file, PointsOnStrips(2, 0.3));
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 0.25, 1e-6);
  const PatchFile right = Strips(2, [](double) { return 2.1; });
  EXPECT_EQ(Compare(right, PointsOnStrips(2, 0.3))->l1_relative, 0);
}

TEST(CompareWithPoints, APointOnNoFaceIsDark) {
  const PatchFile file = Strips(2, [](double) { return 1; });
  std::vector<ReferencePoint> points = PointsOnStrips(1, 0);
  for (size_t i = 0; i < 100; ++i) points[i].position.z += 0.01;
  for (size_t i = 100; i < 200; ++i) points[i].normal = {0, 0, -1};
  const auto result = Compare(file, points);
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->unmatched, 200U);
  EXPECT_NEAR(result->l1_relative, 0.5, 1e-9);
}

TEST(CompareWithPoints, TellsSidesAndSheetsApart) {
  PatchFile file;
  testing::AddFace(file, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 0, 1);
  testing::AddFace(file, {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}, 0, 2);
  testing::AddFace(file, {{0, 0, 5e-5}, {1, 0, 5e-5}, {1, 1, 5e-5}, {0, 1, 5e-5}}, 0, 3);
  const ReferencePoint above{{0.3, 0.4, 1e-9}, {0, 0, 1}, Rgb(1), Rgb(0.0)};
  const ReferencePoint below{{0.3, 0.4, 1e-9}, {0, 0, -1}, Rgb(2), Rgb(0.0)};
  const ReferencePoint sheet{{0.3, 0.4, 5.1e-5}, {0, 0, 1}, Rgb(3), Rgb(0.0)};
  const auto result = Compare(file, std::vector{above, below, sheet});
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->l1_relative, 0, 1e-9);
}

}  // namespace
}  // namespace isolux
