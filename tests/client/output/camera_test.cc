#include "client/output/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/output/patches.h"

namespace isolux {
namespace {

using ::testing::HasSubstr;

constexpr char kGood[] =
    R"({"eye": [278, 273, -800], "target": [278, 273, 0], "up": [0, 1, 0],
        "fov_y_deg": 39.3, "width": 256, "height": 128, "note": "as published"})";

std::string ErrorOf(const std::string& json) {
  const auto camera = ParseCamera(json, "cam.json");
  return camera.has_value() ? "" : camera.error().message();
}

TEST(Camera, IsReadFromJson) {
  const auto camera = ParseCamera(kGood, "cam.json");
  ASSERT_TRUE(camera.has_value()) << camera.error().message();
  EXPECT_EQ(camera->eye, Vec3(278, 273, -800));
  EXPECT_EQ(camera->target, Vec3(278, 273, 0));
  EXPECT_DOUBLE_EQ(camera->fov_y_deg, 39.3);
  EXPECT_EQ(camera->width, 256);
  EXPECT_EQ(camera->height, 128);
}

TEST(Camera, LooksAlongItsAxisWithYDownThePicture) {
  Camera camera;
  camera.eye = Vec3(0, 0, 5);
  camera.target = Vec3(0, 0, 0);
  camera.fov_y_deg = 90;
  camera.width = 200;
  camera.height = 100;
  EXPECT_NEAR(glm::length(camera.Direction(100, 50) - Vec3(0, 0, -1)), 0, 1e-12);
  EXPECT_NEAR(glm::length(camera.Direction(0, 0) - Vec3(-2, 1, -1)), 0, 1e-12);
  EXPECT_NEAR(glm::length(camera.Direction(200, 100) - Vec3(2, -1, -1)), 0, 1e-12);
}

TEST(Camera, ErrorsNameFileAndKey) {
  EXPECT_THAT(ErrorOf("{\n\"eye\": [1,\n}"), HasSubstr("cam.json:3:"));
  EXPECT_THAT(ErrorOf("[]"), HasSubstr("cam.json: a camera is an object"));
  EXPECT_THAT(ErrorOf(R"({"target": [0,0,0]})"), HasSubstr("cam.json: \"eye\""));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,"x"], "target": [0,0,0]})"), HasSubstr("\"eye\""));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,1e999], "target": [0,0,0]})"), HasSubstr("cam.json"));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,1], "target": [0,0]})"), HasSubstr("\"target\""));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,1], "target": [0,0,1]})"), HasSubstr("the same point"));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,1], "target": [0,0,0], "up": [0,0,2]})"),
              HasSubstr("\"up\""));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,1], "target": [0,0,0], "fov": 60})"), HasSubstr("\"fov\""));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,1], "target": [0,0,0], "fov_y_deg": 180})"),
              HasSubstr("\"fov_y_deg\""));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,1], "target": [0,0,0], "width": 0})"),
              HasSubstr("\"width\""));
  EXPECT_THAT(ErrorOf(R"({"eye": [0,0,1], "target": [0,0,0], "height": 10.5})"),
              HasSubstr("\"height\""));
  EXPECT_THAT(ReadCamera("/nonexistent/cam.json").error().message(),
              HasSubstr("/nonexistent/cam.json"));
}

TEST(GuessCamera, StandsInsideAClosedRoom) {
  const PatchFile file = testing::RoomPatches(false);
  const auto scene = PatchScene::Build(file);
  ASSERT_TRUE(scene.has_value());
  const Camera camera = GuessCamera(*scene);
  for (int d = 0; d < 3; ++d) {
    EXPECT_GT(camera.eye[d], scene->bounds().low[d]);
    EXPECT_LT(camera.eye[d], scene->bounds().high[d]);
  }
  // Along x, the longest side.
  const Vec3 forward = glm::normalize(camera.target - camera.eye);
  EXPECT_GT(std::abs(forward.x), 0.8);
  EXPECT_EQ(camera.up, Vec3(0, 1, 0));
  EXPECT_EQ(GuessCamera(*scene, 2).up, Vec3(0, 0, 1));
}

TEST(GuessCamera, LooksInThroughTheOpenSide) {
  const PatchFile file = testing::RoomPatches(true);
  const auto scene = PatchScene::Build(file);
  ASSERT_TRUE(scene.has_value());
  const Camera camera = GuessCamera(*scene);
  EXPECT_GT(camera.eye.z, scene->bounds().high.z);
  EXPECT_EQ(glm::normalize(camera.target - camera.eye), Vec3(0, 0, -1));
  for (const double x : {0.1, 0.9}) {
    for (const double y : {0.1, 0.9}) {
      EXPECT_TRUE(scene->Cast(camera.eye, camera.Direction(x * camera.width, y * camera.height))
                      .has_value());
    }
  }
}

}  // namespace
}  // namespace isolux
