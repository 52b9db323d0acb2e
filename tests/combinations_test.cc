// Effects that meet in one surface or one path of light: maps on sheets, sheets and fluorescence
// behind glass.
#include <gtest/gtest.h>

#include <cmath>

#include "client/output/comparison.h"
#include "client/output/patch_locator.h"
#include "tests/support/glass.h"
#include "tests/support/path_tracer.h"
#include "tests/support/scenes.h"
#include "tests/support/sheet.h"
#include "tests/support/solve_scene.h"

namespace isolux::testing {
namespace {

// Kirchhoff: a sheet that passes a quarter and, texel by texel, reflects ρ and emits 3/4 − ρ on
// both sides hangs in a furnace, and all radiosities are 1.
TEST(Combinations, ATexturedSheetInAFurnaceIsAsBrightAsTheWalls) {
  Scene scene = FurnaceCube(0.5, 0.5);
  AddSheet(scene, {{.2, .3, .2}, {.8, .3, .3}, {.8, .6, .8}, {.2, .6, .7}}, Rgb(.4), Rgb(.25));
  Material& material = scene.materials.back();
  material.exitance = Rgb(.35);
  material.reflectance_map.texture = 0;
  material.exitance_map.texture = 1;
  const double reflectance[] = {.1, .7, .5, .3};  // of mean 0.4
  for (const bool emission : {false, true}) {
    Texture& texture = scene.textures.emplace_back(Texture{2, 2, Wrap::kMirror, Wrap::kRepeat, {}});
    for (const double rho : reflectance) {
      const double relative = emission ? (.75 - rho) / .35 : rho / .4;
      texture.texels.insert(texture.texels.end(), 3, static_cast<float>(relative));
    }
  }
  scene.coordinates = {{{2.1, .4, .2, .1}, {-.3, 1.6, 1.5, 0}}};
  scene.polygons.back().coordinates = 0;
  scene.polygons.back().sides = kFrontTakesPart | kBackTakesPart | kFrontEmits | kBackEmits;
  const SolveResult result = SolveScene(scene, 0.02);
  EXPECT_LT(result.summary.rounds.back().energy_imbalance, 2e-3);
  double least = 1, most = 0, area = 0, off_radiosity = 0, off_irradiance = 0;
  for (const PatchFace& face : result.patch.faces) {
    const double of_face = glm::length(AreaVector(CornersOf(result.patch, face)));
    area += of_face;
    off_radiosity += of_face * std::abs(face.radiosity[0] - 1);
    off_irradiance += of_face * std::abs(face.irradiance[1] - 1);
    if (face.polygon != scene.polygons.back().file_polygon) continue;
    least = std::min<double>(least, face.emission[2]);
    most = std::max<double>(most, face.emission[2]);
  }
  EXPECT_LT(off_radiosity / area, 0.01);  // half of what was asked for
  EXPECT_LT(off_irradiance / area, 0.01);
  EXPECT_LT(least, 0.15);  // the faces show the map
  EXPECT_GT(most, 0.6);
}

// A room under a nearly blue lamp with a fluorescent wall; a fluorescent sheet, and a pane of
// coloured glass across.
Scene Room() {
  BoxFaces faces;
  faces.reflectance = {Rgb(.6, .5, .4), Rgb(.3), Rgb(.5), Rgb(.2, .4, .6), Rgb(.6), Rgb(.4)};
  faces.exitance[1] = Rgb(0.4, 0.3, 2);
  Scene scene = BoxRoom({2, 1, 1.5}, faces);
  scene.materials[0].reflectance = Rgb(.5, .4, .1);
  scene.materials[0].reradiation = {0.6, 0.2, 0.3};
  AddSheet(scene, {{1.2, .05, .05}, {1.4, .05, 1.4}, {1.4, .95, 1.4}, {1.2, .95, .05}}, Rgb(.2),
           Rgb(.4, .3, .2));
  scene.materials.back().reradiation = {0.4, 0.1, 0};
  AddPane(scene, {4, {Vec3(.6, 0, 0), {.6, 1, 0}, {.9, 1, 1.5}, {.9, 0, 1.5}}},
          GlassOf({.9, .7, .5}, 1.5));
  return scene;
}

TEST(Combinations, PathsThroughGlassSheetsAndPhosphorsAgree) {
  const Scene scene = Room();
  const SolveResult result = SolveScene(scene, 0.04);
  const RoundSummary& last = result.summary.rounds.back();
  EXPECT_LT(last.energy_imbalance, 5e-3);
  for (int c = 0; c < 3; ++c) EXPECT_GT(last.glass_w[c], 0);
  ThreadPool pool(2);
  const std::vector<ReferencePoint> points =
      TracePaths(scene, {.points = 32, .error = 0.04, .seconds = 30}, pool);
  EXPECT_LT(Compare(result.patch, points).value().l1_relative, 0.04 + NoiseOf(points));
  for (const char* without : {"-clear-glass", "-sheets", "-fluorescence"}) {
    const SolveResult other = SolveScene(scene, 0.2, without);
    EXPECT_GT(Compare(other.patch, points).value().l1_relative, 0.08) << without;
  }
}

}  // namespace
}  // namespace isolux::testing
