#include "client/output/picture.h"

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "tests/client/output/patches.h"

namespace isolux {
namespace {

Camera FacingZ(int size) {
  Camera camera;  // sees [-1, 1]² of the plane z = 0, y up
  camera.eye = Vec3(0, 0, 1);
  camera.target = Vec3(0, 0, 0);
  camera.fov_y_deg = 90;
  camera.width = camera.height = size;
  return camera;
}

Image RenderFile(const PatchFile& file, const Camera& camera, int samples, int threads = 2) {
  const auto scene = PatchScene::Build(file);
  EXPECT_TRUE(scene.has_value());
  ThreadPool pool(threads);
  RenderOptions options;
  options.samples = samples;
  return Render(*scene, camera, options, pool);
}

double Pixel(const Image& image, int x, int y, int channel = 0) {
  return image.rgb[static_cast<size_t>(3 * (y * image.width + x) + channel)];
}

// A square whose radiosity is 2 + x over [-1, 1]², from T-vertices on one side as well.
PatchFile Slope() {
  PatchFile file;
  testing::AddFace(file, {{-1, -1, 0}, {0.5, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, 0, 0);
  for (PatchVertex& v : file.vertices) {
    v.radiosity = {static_cast<float>(2 + v.position.x), 1, 0};
  }
  return file;
}

TEST(Render, ShowsRadianceInterpolatedOverTheFace) {
  const Image image = RenderFile(Slope(), FacingZ(16), 64);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const double middle = (x + 0.5) / 8 - 1;
      EXPECT_NEAR(Pixel(image, x, y), (2 + middle) / std::numbers::pi, 0.003);
      EXPECT_NEAR(Pixel(image, x, y, 1), 1 / std::numbers::pi, 1e-6);
      EXPECT_EQ(Pixel(image, x, y, 2), 0);
    }
  }
}

TEST(Render, IsTheSameForAnyNumberOfThreads) {
  EXPECT_EQ(RenderFile(Slope(), FacingZ(40), 4, 1).rgb, RenderFile(Slope(), FacingZ(40), 4, 3).rgb);
}

TEST(Render, CoversEdgesByTheirShareOfThePixel) {
  PatchFile file;
  testing::AddFace(file, {{-1, -1, 0}, {0.125, -1, 0}, {0.125, 1, 0}, {-1, 1, 0}}, 3, 0);
  const Image image = RenderFile(file, FacingZ(8), 256);
  EXPECT_NEAR(Pixel(image, 3, 4), 3 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(Pixel(image, 4, 4), 0.5 * 3 / std::numbers::pi, 0.02);
  EXPECT_EQ(Pixel(image, 5, 4), 0);
}

TEST(Render, ShowsTheSideThatFacesTheCamera) {
  // Coincident front and back of different radiosity, and a lone back in front of both.
  PatchFile file;
  const std::vector<Vec3> front{{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}};
  const std::vector<Vec3> back(front.rbegin(), front.rend());
  testing::AddFace(file, front, 1, 0);
  testing::AddFace(file, back, 2, 0).side = 1;
  std::vector<Vec3> nearer = back;
  for (Vec3& p : nearer) p.z = 0.25;
  testing::AddFace(file, nearer, 8, 0);
  EXPECT_NEAR(Pixel(RenderFile(file, FacingZ(3), 4), 1, 1), 1 / std::numbers::pi, 1e-6);
  Camera camera = FacingZ(3);
  camera.eye.z = -1;
  EXPECT_NEAR(Pixel(RenderFile(file, camera, 4), 1, 1), 2 / std::numbers::pi, 1e-6);
}

TEST(Render, HasNoCracks) {
  // A room whose walls are divided differently, seen from many places: no ray gets out.
  PatchFile file;
  const PatchFile room = testing::RoomPatches(false);
  int parts = 3;
  for (const PatchFace& wall : room.faces) {
    const auto corner = [&](int k) { return room.vertices[wall.vertices[k]].position; };
    ++parts;
    for (int i = 0; i < parts; ++i) {
      for (int k = 0; k < parts; ++k) {
        const auto at = [&](int a, int b) {
          const double u = static_cast<double>(a) / parts, v = static_cast<double>(b) / parts;
          return (1 - u) * ((1 - v) * corner(0) + v * corner(3)) +
                 u * ((1 - v) * corner(1) + v * corner(2)) + Vec3(0.1, 0.7, 1.3);
        };
        testing::AddFace(file, {at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)}, 1, 0);
      }
    }
  }
  for (int i = 0; i < 3; ++i) {
    Camera camera;
    camera.eye = Vec3(1.1 + i, 1.7, 2.1 + 0.3 * i);
    camera.target = camera.eye + Vec3(std::cos(i), 0.1, std::sin(i));
    camera.fov_y_deg = 120;
    camera.width = camera.height = 128;
    const Image image = RenderFile(file, camera, 4);
    for (const float value : image.rgb) ASSERT_NEAR(value, 1 / std::numbers::pi, 1e-5);
  }
}

TEST(Render, DimsLampsForDisplaysOnly) {
  PatchFile file;
  testing::AddFace(file, {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}}, 100, 0);
  const auto scene = PatchScene::Build(file);
  ThreadPool pool(1);
  RenderOptions options;
  options.brightest = 4;
  EXPECT_NEAR(Pixel(Render(*scene, FacingZ(2), options, pool), 0, 0), 4, 1e-5);
}

TEST(AutoExposure, PutsTheBrightPartsBelowWhiteAndStopsDouble) {
  const PatchFile file = testing::RoomPatches(false);
  const auto scene = PatchScene::Build(file);
  Camera camera;
  camera.eye = Vec3(1, 1.2, 1.5);
  camera.target = Vec3(6, 1.2, 1.5);
  const Exposure exposure = AutoExposure(*scene, camera, ToneMap::kLinear, 0);
  // The brightest wall in sight has radiosity 6.
  EXPECT_NEAR(exposure.scale * 6 / std::numbers::pi, 0.8, 1e-9);
  const Exposure brighter = AutoExposure(*scene, camera, ToneMap::kLinear, 1);
  EXPECT_DOUBLE_EQ(brighter.scale, 2 * exposure.scale);
}

TEST(ToDisplay, EncodesSrgbWithinADither) {
  Image image{4, 1, {0, 0, 0, 0.5F, 0.5F, 0.5F, 1, 1, 1, 7, 7, 7}};
  const auto bytes = ToDisplay(image, {1, ToneMap::kLinear});
  EXPECT_EQ(bytes[0], 0);
  EXPECT_NEAR(bytes[3], 188, 1);
  EXPECT_EQ(bytes[6], 255);
  EXPECT_EQ(bytes[9], 255);
  // Reinhard: white at the white luminance, darker below.
  const auto curve = ToDisplay(image, {4, ToneMap::kReinhard});
  EXPECT_EQ(curve[6], 255);
  EXPECT_LT(curve[3], 255);
}

TEST(ToDisplay, DithersWithoutChangingTheMean) {
  const float value = 0.2140F;  // between two steps
  const Image image{100, 100, std::vector<float>(30'000, value)};
  const auto bytes = ToDisplay(image, {1, ToneMap::kLinear});
  double mean = 0;
  for (const uint8_t byte : bytes) mean += byte / 30'000.0;
  const double exact = 255 * (1.055 * std::pow(value, 1 / 2.4) - 0.055);
  EXPECT_NEAR(mean, exact, 0.02);
}

class PictureFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("isolux_picture_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string Path(const char* name) const { return (folder_ / name).string(); }

  std::filesystem::path folder_;
};

TEST_F(PictureFile, PngComesBack) {
  const std::vector<uint8_t> rgb{255, 0, 0, 0, 255, 0, 0, 0, 255, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  ASSERT_TRUE(WritePng(Path("a.png"), 3, 2, rgb).ok());
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&image, Path("a.png").c_str()), 0);
  EXPECT_EQ(image.width, 3U);
  EXPECT_EQ(image.height, 2U);
  image.format = PNG_FORMAT_RGB;
  std::vector<uint8_t> back(rgb.size());
  ASSERT_NE(png_image_finish_read(&image, nullptr, back.data(), 0, nullptr), 0);
  EXPECT_EQ(back, rgb);
}

TEST_F(PictureFile, ExrHoldsTheFloats) {
  const Image image{2, 2, {0.1F, 0.2F, 0.3F, 1000, 2000, 3000, 1e-9F, 0, 1, 5, 6, 7}};
  ASSERT_TRUE(WriteExr(Path("a.exr"), image).ok());
  Imf::InputFile file(Path("a.exr").c_str());
  std::vector<float> green(4);
  Imf::FrameBuffer frame;
  frame.insert("G", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(green.data()), sizeof(float),
                               2 * sizeof(float)));
  file.setFrameBuffer(frame);
  file.readPixels(0, 1);
  EXPECT_EQ(green, (std::vector<float>{0.2F, 2000, 0, 6}));
}

TEST_F(PictureFile, CannotBeWrittenWhereThereIsNoFolder) {
  EXPECT_THAT(WritePng(Path("no/a.png"), 1, 1, {1, 2, 3}).message(), ::testing::HasSubstr("no/a"));
  EXPECT_FALSE(WriteExr(Path("no/a.exr"), Image{1, 1, {1, 2, 3}}).ok());
}

TEST(PatchScene, WithoutFacesIsRefused) {
  const PatchFile empty;
  EXPECT_FALSE(PatchScene::Build(empty).has_value());
}

}  // namespace
}  // namespace isolux
