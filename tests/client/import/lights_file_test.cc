// isolux.json: lights beside a scene file.
#include "client/import/lights_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/import/import.h"
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
  {"type": "directional", "direction": [3, 0, -4], "irradiance": 5}]})";

TEST(LightsFile, ReadsEachKind) {
  const std::vector<Light> lights = Read(kThree);
  ASSERT_EQ(lights.size(), 3U);
  EXPECT_EQ(lights[0].kind, LightKind::kPoint);
  EXPECT_EQ(lights[0].name, "bulb");
  EXPECT_EQ(lights[0].position_m, Vec3(1, 2, 3));
  EXPECT_EQ(lights[0].intensity, Rgb(1, 2, 3));
  EXPECT_EQ(lights[1].direction, Vec3(0, 0, -1));
  EXPECT_NEAR(lights[1].cosine_none, 0.5, 1e-12);
  EXPECT_EQ(lights[1].cosine_full, 1);
  EXPECT_EQ(lights[2].direction, Vec3(0.6, 0, -0.8));
  EXPECT_EQ(lights[2].intensity, Rgb(5.0));
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
      EXPECT_TRUE(CheckLight(file.lights[l], l).ok()) << text;
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
