// isolux.json: lights beside a scene file.
#include "client/import/lights_file.h"

#include <OpenEXR/ImfRgbaFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <numbers>

#include "client/import/import.h"
#include "client/import/radiance_image.h"
#include "client/import/sky_file.h"
#include "common/util/random.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using ::testing::HasSubstr;

std::vector<Light> Read(const std::string& text) {
  SceneFile file;
  const Status status = ParseLightsFile(text, "isolux.json", &file);
  EXPECT_TRUE(status.ok()) << status.message();
  return file.lights;
}

std::string ErrorOf(const std::string& text) {
  SceneFile file;
  const Status status = ParseLightsFile(text, "isolux.json", &file);
  EXPECT_FALSE(status.ok()) << text;
  EXPECT_THAT(status.message(), HasSubstr("isolux.json: "));
  return status.message();
}

constexpr char kThree[] = R"({"lights": [
  {"type": "point", "name": "bulb", "position": [1, 2, 3], "intensity": [1, 2, 3]},
  {"type": "spot", "position": [0, 0, 1], "direction": [0, 0, -2], "intensity": 4,
   "inner_angle": 0, "outer_angle": 60},
  {"type": "directional", "direction": [3, 0, -4], "irradiance": 5},
  {"type": "sun", "direction": [0, 0, -1], "irradiance": 6, "angular_diameter": 0.5}]})";

TEST(LightsFile, ReadsEachKind) {
  const std::vector<Light> lights = Read(kThree);
  ASSERT_EQ(lights.size(), 4U);
  EXPECT_EQ(lights[0].kind, LightKind::kPoint);
  EXPECT_EQ(lights[0].name, "bulb");
  EXPECT_EQ(lights[0].position_m, Vec3(1, 2, 3));
  EXPECT_EQ(lights[0].intensity, Rgb(1, 2, 3));
  EXPECT_EQ(lights[1].direction, Vec3(0, 0, -1));
  EXPECT_NEAR(lights[1].cosine_none, 0.5, 1e-12);
  EXPECT_EQ(lights[1].cosine_full, 1);
  EXPECT_EQ(lights[2].direction, Vec3(0.6, 0, -0.8));
  EXPECT_EQ(lights[2].intensity, Rgb(5.0));
  EXPECT_FALSE(lights[2].is_sun());
  EXPECT_NEAR(lights[3].disc_radius, 0.25 * std::numbers::pi / 180, 1e-6);
  EXPECT_TRUE(Read("{}").empty());
}

TEST(LightsFile, SaysWhatIsWrong) {
  EXPECT_THAT(ErrorOf("{\"lights\": [\n  {\"type\"\n]}"), HasSubstr("line 3"));
  EXPECT_THAT(ErrorOf("[]"), HasSubstr("not an object"));
  EXPECT_THAT(ErrorOf(R"({"lamps": []})"), HasSubstr("there is no key 'lamps' here"));
  EXPECT_THAT(ErrorOf(R"({"lights": {}})"), HasSubstr("must be a list"));
  EXPECT_THAT(ErrorOf(R"({"lights": [{"type": "sphere"}]})"), HasSubstr("lights[0]: \"type\""));
  EXPECT_THAT(ErrorOf(R"({"lights": [{"type": "point", "intensity": 1}]})"),
              HasSubstr("\"position\" must be three numbers"));
  for (const char* irradiance : {"", ", \"irradiance\": [1, 2]", ", \"irradiance\": \"5\""}) {
    EXPECT_THAT(ErrorOf(std::string(R"({"lights": [{"type": "sun", "direction": [0, 0, -1])") +
                        irradiance + "}]}"),
                HasSubstr("\"irradiance\" must be 0 or more, one number or three"));
  }
  EXPECT_THAT(ErrorOf(R"({"lights": [{"type": "point", "position": [0, 0, 0], "intensity": -1}]})"),
              HasSubstr("\"intensity\" must be a number from 0"));
  EXPECT_THAT(ErrorOf(R"({"lights": [{"type": "point", "position": [0, 0, 0], "intensity": 1,
                                      "direction": [0, 0, 1]}]})"),
              HasSubstr("no key 'direction'"));
  EXPECT_THAT(ErrorOf(R"({"lights": [{"type": "directional", "direction": [0, 0, 0],
                                      "irradiance": 1}]})"),
              HasSubstr("has no length"));
  EXPECT_THAT(ErrorOf(std::string(100, '[') + std::string(100, ']')), HasSubstr("too deeply"));
}

Sky ReadSkyOf(const std::string& text) {
  SceneFile file;
  const Status status = ParseLightsFile(text, "isolux.json", &file);
  EXPECT_TRUE(status.ok()) << status.message();
  return file.sky;
}

// Of a plane that faces up: Σ over the upper texels of L cos, each of the solid angle 4π/n.
double IrradianceFromAbove(const Sky& sky) {
  double sum = 0;
  for (uint32_t row = 0; row < sky.rows / 2; ++row) {
    for (uint32_t column = 0; column < sky.columns; ++column) {
      sum += sky.Texel(column, row).y * (1 - (2.0 * row + 1) / sky.rows);
    }
  }
  return sum * 4 * std::numbers::pi / (sky.rows * sky.columns);
}

TEST(LightsFile, ReadsAMedium) {
  SceneFile file;
  const Status status =
      ParseLightsFile(R"({"medium": {"extinction_per_m": [0.1, 0.2, 3]}})", "isolux.json", &file);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(file.medium.extinction_per_m, Rgb(0.1, 0.2, 3));
  EXPECT_THAT(ErrorOf(R"({"medium": 3})"), HasSubstr("medium: not an object"));
  EXPECT_THAT(ErrorOf(R"({"medium": {}})"), HasSubstr("\"extinction_per_m\""));
  EXPECT_THAT(ErrorOf(R"({"medium": {"extinction_per_m": [0, -1, 0]}})"), HasSubstr("0 or more"));
  EXPECT_THAT(ErrorOf(R"({"medium": {"extinction_per_m": 1e9}})"), HasSubstr("unit"));
  EXPECT_THAT(ErrorOf(R"({"medium": {"kappa": 1}})"), HasSubstr("extinction_per_m"));
}

TEST(LightsFile, SkiesHaveTheirIrradiance) {
  constexpr double kPi = std::numbers::pi;
  const Sky even = ReadSkyOf(R"({"sky": {"type": "constant", "radiance": 2, "ground": 2}})");
  EXPECT_EQ(even.texels.size(), 3U);
  EXPECT_EQ(even.RadianceFrom({0, -1, 0}), Rgb(2.0));
  const Sky half = ReadSkyOf(R"({"sky": {"type": "constant", "radiance": 2, "up": [0, 0, 3]}})");
  EXPECT_EQ(half.RadianceFrom({0, 0, 1}), Rgb(2.0));
  EXPECT_EQ(half.RadianceFrom({0, 0.6, -0.8}), Rgb(0.0));
  // ∫ L s 2π ds, L linear in the sine s of the height; texels are exact for L, not for L s.
  const Sky overcast = ReadSkyOf(R"({"sky": {"type": "cie_overcast", "zenith": 9}})");
  EXPECT_NEAR(IrradianceFromAbove(overcast), 7 * kPi, 1e-3);
  const Sky gradient =
      ReadSkyOf(R"({"sky": {"type": "gradient", "zenith": 3, "horizon": [6, 6, 6]}})");
  EXPECT_NEAR(IrradianceFromAbove(gradient), 2 * kPi * (3.0 / 3 + 6.0 / 6), 1e-3);
  EXPECT_NEAR(gradient.RadianceFrom({0.6, 0.8, 0}).x, 3.6, 0.03);
  // Brightest about the sun; the zenith is what it is said to be.
  const Sky clear = ReadSkyOf(R"({"sky": {"type": "cie_clear", "zenith": 5, "sun": [1, 1, 0]}})");
  EXPECT_NEAR(clear.RadianceFrom({0, 1, 0}).x, 5, 0.5);
  const Vec3 sun = glm::normalize(Vec3(1, 1, 0));
  EXPECT_GT(clear.RadianceFrom(sun).x, 4 * clear.RadianceFrom({0, 1, 0}).x);
  EXPECT_GT(clear.RadianceFrom(sun).x, 4 * clear.RadianceFrom({-sun.x, sun.y, 0}).x);
}

TEST(LightsFile, RefusesSkiesThatMakeNoSense) {
  EXPECT_THAT(ErrorOf(R"({"sky": 3})"), HasSubstr("sky: not an object"));
  EXPECT_THAT(ErrorOf(R"({"sky": {"type": "night"}})"), HasSubstr("\"cie_overcast\""));
  EXPECT_THAT(ErrorOf(R"({"sky": {"type": "constant"}})"), HasSubstr("\"radiance\""));
  EXPECT_THAT(ErrorOf(R"({"sky": {"type": "cie_clear", "zenith": 1, "sun": [0, -1, 0]}})"),
              HasSubstr("above the horizon"));
  EXPECT_THAT(ErrorOf(R"({"sky": {"type": "map", "file": "../x.hdr"}})"), HasSubstr("leads out"));
  EXPECT_THAT(ErrorOf(R"({"sky": {"type": "map", "file": "x.hdr"}})"), HasSubstr("no such file"));
}

TEST(LightsFile, MapsGoRightFromTheMiddle) {
  // 8 x 4 pixels; the brightest is right of the middle, just above the horizon.
  std::vector<float> pixels(3 * 8 * 4, 1.0F);
  for (int c = 0; c < 3; ++c) pixels[3 * (1 * 8 + 5) + c] = 100;
  const Sky sky = FromEquirectangular(pixels, 8, 4);
  EXPECT_EQ(sky.columns, 8U);
  EXPECT_EQ(sky.rows, 2U);
  // Ahead is −z, up is y: to the right is x. Pixel 5 is from 45° to 90° right of the middle.
  const auto at = [&](double degrees) {
    const double turn = degrees * std::numbers::pi / 180;
    return sky.RadianceFrom(glm::normalize(Vec3(std::sin(turn), 0.3, -std::cos(turn)))).x;
  };
  EXPECT_EQ(at(0), 1);
  EXPECT_GT(at(67), 10);
  EXPECT_EQ(at(-67), 1);
  EXPECT_EQ(at(113), 1);
  // Its light is that of its solid angle: from 45° to 90° of height's complement.
  double total = 0;
  for (uint32_t i = 0; i < sky.texels.size(); i += 3) total += sky.texels[i] - 1;
  EXPECT_NEAR(total * 4 * std::numbers::pi / 16,
              99 * (std::numbers::pi / 4) * std::cos(std::numbers::pi / 4), 1e-3);
}

TEST(LightsFile, ReadsRadianceImages) {
  const testing::TempDir dir;
  std::vector<float> pixels(3 * 4 * 2, 0.5F);
  pixels[0] = 8;
  std::string bytes;
  stbi_write_hdr_to_func(
      [](void* to, void* data, int size) {
        static_cast<std::string*>(to)->append(static_cast<const char*>(data), size);
      },
      &bytes, 4, 2, 3, pixels.data());
  const std::string path = dir.Write("sky.hdr", bytes);
  const Result<RadianceImage> image = ReadRadianceImage(path);
  ASSERT_TRUE(image.has_value()) << image.error().message();
  EXPECT_EQ(image->width, 4U);
  EXPECT_NEAR(image->pixels[0], 8, 0.1);
  EXPECT_NEAR(image->pixels[5], 0.5, 0.01);
  EXPECT_THAT(ReadRadianceImage(path, 7).error().message(), HasSubstr("4 x 2 pixels"));
  for (size_t length = 0; length < bytes.size(); length += 3) {
    const Result<RadianceImage> cut =
        ReadRadianceImage(dir.Write("cut.hdr", bytes.substr(0, length)));
    if (!cut.has_value()) {
      EXPECT_THAT(cut.error().message(), HasSubstr("cut.hdr: "));
    }
  }
  const std::string exr = dir.Write("sky.exr", "");
  {
    Imf::RgbaOutputFile out(exr.c_str(), 3, 2, Imf::WRITE_RGB);
    std::vector<Imf::Rgba> half(6, Imf::Rgba(0.25F, 0.5F, 1, 1));
    out.setFrameBuffer(half.data(), 1, 3);
    out.writePixels(2);
  }
  const Result<RadianceImage> open = ReadRadianceImage(exr);
  ASSERT_TRUE(open.has_value()) << open.error().message();
  EXPECT_EQ(open->height, 2U);
  EXPECT_EQ(open->pixels[4], 0.5F);
  EXPECT_FALSE(ReadRadianceImage(dir.Write("bad.exr", "\x76\x2f\x31\x01 and nothing")).has_value());
  // As a sky beside a scene.
  dir.Write("isolux.json", R"({"sky": {"type": "map", "file": "sky.hdr", "scale": 2}})");
  const Result<Scene> scene =
      ImportScene(dir.Write("s.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"), {});
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  EXPECT_EQ(scene->sky.rows, 1U);
  EXPECT_NEAR(scene->sky.MeanRadiance().y, 1, 0.01);
}

TEST(LightsFile, DamagedTextIsReadOrRefused) {
  Random random(11);
  for (int i = 0; i < 3000; ++i) {
    std::string text = kThree;
    for (int k = 0; k < 3; ++k) {
      const size_t at = random.Bits() % text.size();
      if (random.Bits() % 2 == 0)
        text.erase(at, 1 + random.Bits() % 8);
      else
        text[at] = static_cast<char>(random.Bits() % 128);
    }
    SceneFile file;
    const Status status = ParseLightsFile(text, "isolux.json", &file);
    if (!status.ok()) {
      EXPECT_FALSE(status.message().empty());
    }
    for (size_t l = 0; l < file.lights.size(); ++l) {
      EXPECT_TRUE(CheckLight(file.lights[l], file.photometries, l).ok()) << text;
    }
  }
}

// In the scene's unit, relative to its centre; a lamp is not needed beside.
TEST(LightsFile, StandsBesideAScene) {
  const testing::TempDir dir;
  const std::string path =
      dir.Write("s.obj", "v 0 0 0\nv 200 0 0\nv 200 200 0\nv 0 200 0\nf 1 2 3 4\n");
  ImportOptions options;
  options.unit = "cm";
  EXPECT_THAT(ImportScene(path, options).error().message(), HasSubstr("there are no lights"));
  dir.Write("isolux.json", R"({"lights": [
    {"type": "point", "position": [100, 50, 300], "intensity": 2}]})");
  const Result<Scene> scene = ImportScene(path, options);
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  ASSERT_EQ(scene->lights.size(), 1U);
  EXPECT_LT(glm::length(scene->lights[0].position_m + scene->origin_m - Vec3(1, 0.5, 3)), 1e-12);
  dir.Write("isolux.json", "{");
  EXPECT_THAT(ImportScene(path, options).error().message(), HasSubstr("isolux.json: parse error"));
}

}  // namespace
}  // namespace isolux
