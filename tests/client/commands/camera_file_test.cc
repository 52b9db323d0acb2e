#include "client/commands/camera_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "tests/support/gltf_file.h"

namespace isolux {
namespace {

using testing::GltfFile;
using ::testing::HasSubstr;
using Json = nlohmann::json;

// A wide camera, a narrow one below a turned and scaled node, and an orthographic one.
GltfFile Cameras() {
  GltfFile file;
  file.json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}},
      {{"type", "perspective"},
       {"name", "tele"},
       {"perspective", {{"yfov", 0.2}, {"aspectRatio", 2.0}, {"znear", 0.1}}}},
      {{"type", "orthographic"},
       {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"zfar", 9}, {"znear", 1}}}}};
  file.Node({{"camera", 0}, {"translation", {1, 2, 3}}});
  const int child = file.Node({{"camera", 1}, {"name", "eye"}, {"translation", {0, 0, 2}}}, false);
  const double half = std::sqrt(0.5);  // a quarter turn about y: −z becomes −x
  file.Node({{"translation", {5, 0, 0}},
             {"rotation", {0, half, 0, half}},
             {"scale", {3, 2, 4}},
             {"children", {child}}});
  file.Node({{"camera", 2}, {"name", "plan"}});
  return file;
}

Result<Camera> Choose(const GltfFile& file, const std::string& which) {
  const auto document = ParseGltfDocument(file.Text(), "room.gltf");
  if (!document.has_value()) return tl::unexpected(document.error());
  return CameraOf(*document, which);
}

std::string ErrorOf(const GltfFile& file, const std::string& which) {
  const auto camera = Choose(file, which);
  return camera.has_value() ? "" : camera.error().message();
}

TEST(GltfCamera, StandsWhereItsNodeDoes) {
  const auto first = Choose(Cameras(), "");
  ASSERT_TRUE(first.has_value()) << first.error().message();
  EXPECT_EQ(first->eye, Vec3(1, 2, 3));
  EXPECT_EQ(glm::normalize(first->target - first->eye), Vec3(0, 0, -1));
  EXPECT_EQ(first->up, Vec3(0, 1, 0));
  EXPECT_NEAR(first->fov_y_deg, 180 / std::numbers::pi, 1e-12);
  EXPECT_EQ(first->width, 1280);
  EXPECT_EQ(first->height, 960);
  for (const char* which : {"1", "eye", "tele"}) {
    const auto tele = Choose(Cameras(), which);
    ASSERT_TRUE(tele.has_value()) << tele.error().message();
    EXPECT_LT(glm::length(tele->eye - Vec3(13, 0, 0)), 1e-12);
    EXPECT_LT(glm::length(glm::normalize(tele->target - tele->eye) - Vec3(-1, 0, 0)), 1e-12);
    EXPECT_LT(glm::length(tele->up - Vec3(0, 1, 0)), 1e-12);
    EXPECT_NEAR(tele->fov_y_deg, 36 / std::numbers::pi, 1e-12);
    EXPECT_EQ(tele->width, 1920);
  }
}

TEST(GltfCamera, SaysWhatIsWrong) {
  EXPECT_THAT(ErrorOf(Cameras(), "plan"), HasSubstr("nodes[3] 'plan': its camera is orthographic"));
  EXPECT_THAT(ErrorOf(Cameras(), "3"),
              HasSubstr("room.gltf: no camera '3'; there are: 0 nodes[0], 1 nodes[1] 'eye', 2"));
  GltfFile file = Cameras();
  file.json["cameras"][0]["perspective"]["yfov"] = 4;
  EXPECT_THAT(ErrorOf(file, ""), HasSubstr("nodes[0]: its camera's yfov"));
  file.json["cameras"][1]["perspective"]["aspectRatio"] = 1e9;
  EXPECT_THAT(ErrorOf(file, "eye"), HasSubstr("aspectRatio leaves no picture"));
  file.json["nodes"][0]["camera"] = 9;
  EXPECT_THAT(ErrorOf(file, "0"), HasSubstr("nodes[0]: its camera does not exist"));
  file = Cameras();
  file.json["nodes"][0]["scale"] = {1, 1, 0};
  EXPECT_THAT(ErrorOf(file, "0"), HasSubstr("nodes[0]: its scale leaves its camera no direction"));
  file.json["scenes"][0]["nodes"] = Json::array();
  EXPECT_THAT(ErrorOf(file, ""), HasSubstr("no node of its scene has a camera"));
}

TEST(GltfCamera, ComesFromAFile) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "isolux_camera_file.gltf:x";
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "room.GLB").string();
  GltfFile file = Cameras();
  file.View(std::vector<float>{0});
  std::ofstream(path, std::ios::binary) << file.Binary();
  const std::vector<std::pair<std::string, int>> cases{{"", 1280}, {":0", 1280}, {":tele", 1920}};
  for (const auto& [which, width] : cases) {
    const auto camera = ReadCameraOf(path + which);
    ASSERT_TRUE(camera.has_value()) << camera.error().message();
    EXPECT_EQ(camera->width, width);
  }
  EXPECT_THAT(ReadCameraOf(path + ":9").error().message(), HasSubstr("no camera '9'"));
  EXPECT_THAT(ReadCameraOf((folder / "cam.json").string()).error().message(),
              HasSubstr("cam.json"));
  EXPECT_THAT(ReadCameraOf((folder / "absent.gltf:1").string()).error().message(),
              HasSubstr("absent.gltf: "));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace isolux
