#include "client/output/comparison.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace isolux
