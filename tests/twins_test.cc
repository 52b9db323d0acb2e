// A scene that is there in two formats has one solution. Whole solves of a large scene: long.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "client/import/import.h"
#include "client/output/comparison.h"
#include "client/output/patch_locator.h"
#include "tests/support/shared_folder.h"
#include "tests/support/solve_scene.h"

namespace isolux::testing {
namespace {

// What a solution says in the middle of faces, drawn evenly over the area.
std::vector<ReferencePoint> PointsOf(const PatchFile& patch, size_t count) {
  std::vector<double> area_up_to;
  double area = 0;
  for (const PatchFace& face : patch.faces) {
    area += glm::length(AreaVector(CornersOf(patch, face)));
    area_up_to.push_back(area);
  }
  std::vector<ReferencePoint> points;
  for (size_t i = 0; i < count; ++i) {
    const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * area;
    const auto found = std::ranges::upper_bound(area_up_to, at) - area_up_to.begin();
    const PatchFace& face = patch.faces[static_cast<size_t>(found)];
    const std::vector<Vec3> corners = CornersOf(patch, face);
    ReferencePoint point;
    point.position = std::accumulate(corners.begin(), corners.end(), Vec3(0.0)) /
                     static_cast<double>(corners.size());
    point.normal = glm::normalize(AreaVector(corners));
    point.irradiance = IrradianceAt(patch, static_cast<uint32_t>(found), point.position);
    points.push_back(point);
  }
  return points;
}

// Textures, mirrors, glass and 13 lamps; the binary glTF was made of the OBJ by another program.
// Polygons have other numbers in it, so points are found by their places.
TEST(Twins, HallHasOneSolution) {
  const std::filesystem::path hall =
      std::filesystem::path(SharedFolder()) / "scenes/modern_hall/modern_hall";
  if (!std::filesystem::exists(hall.string() + ".glb")) {
    GTEST_SKIP() << "no collection of scenes; name its folder in ISOLUX_SHARED";
  }
  constexpr double kAccuracy = 0.15;
  SolveResult results[2];
  for (const int i : {0, 1}) {
    const auto scene = ImportScene(hall.string() + (i == 0 ? ".obj" : ".glb"), {});
    ASSERT_TRUE(scene.has_value()) << scene.error().message();
    results[i] = SolveScene(*scene, kAccuracy);
  }
  const std::vector<ReferencePoint> points = PointsOf(results[0].patch, 20'000);
  const Comparison off = Compare(results[1].patch, points).value();
  EXPECT_LT(off.l1_relative, kAccuracy);  // sides that one left out as dark count as dark
}

}  // namespace
}  // namespace isolux::testing
