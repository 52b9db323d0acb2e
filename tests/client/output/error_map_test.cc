#include "client/output/error_map.h"

#include <gtest/gtest.h>

#include "tests/client/output/patches.h"

namespace isolux {
namespace {

// Two squares side by side over [-1, 1]²: areas 2 (left) and 2 (right).
PatchFile TwoHalves(float left_error, float right_error) {
  PatchFile file;
  testing::AddFace(file, {{-1, -1, 0}, {0, -1, 0}, {0, 1, 0}, {-1, 1, 0}}, 1, 3).error = left_error;
  testing::AddFace(file, {{0, -1, 0}, {1, -1, 0}, {1, 1, 0}, {0, 1, 0}}, 1, 1).error = right_error;
  return file;
}

TEST(RelativeErrors, AreOverTheMeanIrradiance) {
  const RelativeErrors errors = FindRelativeErrors(TwoHalves(0.1F, 0.3F));
  EXPECT_DOUBLE_EQ(errors.mean_irradiance_w_m2, 2);
  ASSERT_EQ(errors.of_face.size(), 2u);
  EXPECT_NEAR(errors.of_face[0], 0.05, 1e-8);
  EXPECT_NEAR(errors.of_face[1], 0.15, 1e-8);
  EXPECT_DOUBLE_EQ(errors.area[0], 2);
  EXPECT_NEAR(errors.mean, 0.1, 1e-8);
  EXPECT_NEAR(errors.p95, 0.15, 1e-8);
}

TEST(RelativeErrors, AreThoseOfTheBrightestChannel) {
  PatchFile file = TwoHalves(0.2F, 0.2F);
  for (PatchFace& face : file.faces) face.irradiance = {0.5F, 4, 1};
  EXPECT_DOUBLE_EQ(FindRelativeErrors(file).mean_irradiance_w_m2, 4);
}

TEST(RelativeErrors, OfDarknessAreZero) {
  PatchFile file = TwoHalves(0.2F, 0.2F);
  for (PatchFace& face : file.faces) face.irradiance = {};
  const RelativeErrors errors = FindRelativeErrors(file);
  EXPECT_EQ(errors.mean, 0);
  EXPECT_EQ(errors.of_face, (std::vector<double>{0, 0}));
  EXPECT_TRUE(FindRelativeErrors({}).of_face.empty());
}

double Brightness(const Rgb& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

TEST(FalseColours, GrowBrighterWithTheLogarithm) {
  const FalseColours colours{0.01, 1};
  EXPECT_EQ(colours.Of(0), colours.Of(0.01));
  EXPECT_EQ(colours.Of(5), colours.Of(1));
  double before = -1;
  for (double value = 0.01; value < 1.01; value *= 1.1) {
    EXPECT_GT(Brightness(colours.Of(value)), before) << value;
    before = Brightness(colours.Of(value));
  }
}

TEST(ErrorMap, ShowsEachFaceInItsColour) {
  const PatchFile file = TwoHalves(0.02F, 2);
  const auto scene = PatchScene::Build(file);
  ASSERT_TRUE(scene.has_value());
  Camera camera;
  camera.eye = Vec3(0, 0, 1);
  camera.target = Vec3(0, 0, 0);
  camera.fov_y_deg = 120;  // the outer pixels see nothing
  camera.width = camera.height = 16;
  ThreadPool pool(2);
  RenderOptions options;
  options.samples = 4;
  const std::vector<uint8_t> rgb =
      RenderErrors(*scene, camera, options, FindRelativeErrors(file), {0.01, 1}, pool);
  const auto pixel = [&](size_t x, size_t y) {
    const size_t at = 3 * (16 * y + x);
    return std::array<int, 3>{rgb[at], rgb[at + 1], rgb[at + 2]};
  };
  const auto near = [](const std::array<int, 3>& shown, const std::array<uint8_t, 3>& wanted) {
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], wanted[c], 2) << c;
  };
  near(pixel(5, 8), FalseColours::Stops().front());  // 0.01
  near(pixel(10, 8), FalseColours::Stops().back());  // 1
  const std::array<int, 3> outside = pixel(0, 0);
  EXPECT_NEAR(outside[0], outside[1], 2);
  EXPECT_NEAR(outside[1], outside[2], 2);
}

}  // namespace
}  // namespace isolux
