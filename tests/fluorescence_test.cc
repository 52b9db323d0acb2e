// Fluorescence through whole solves: against closed forms of a furnace and of two plates without
// end, and against path tracing; energy by channel, the bound, and the same bits on any number of
// workers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "client/output/comparison.h"
#include "common/hierarchy/effects/plan.h"
#include "tests/support/local_cluster.h"
#include "tests/support/path_tracer.h"
#include "tests/support/same_bits.h"
#include "tests/support/scenes.h"
#include "tests/support/sheet.h"
#include "tests/support/solve_scene.h"

namespace isolux::testing {
namespace {

SolveResult Solve(const Scene& scene, double accuracy, const std::string& effects = "",
                  int workers = 1) {
  return SolveScene(scene, accuracy, effects, workers);
}

const RoundSummary& LastRound(const SolveResult& result) { return result.summary.rounds.back(); }

Effect RowOf(const Scene& scene, const char* name) {
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.02, {});
  return *std::ranges::find(table.effects, name, &Effect::name);
}

// A material of its own for a polygon, that fluoresces.
void MakeFluorescent(Scene& scene, uint32_t polygon, const Rgb& reflectance,
                     const Reradiation& reradiation) {
  Material material = scene.materials[scene.polygons[polygon].material];
  material.reflectance = reflectance;
  material.reradiation = reradiation;
  scene.polygons[polygon].material = static_cast<uint32_t>(scene.materials.size());
  scene.materials.push_back(material);
}

TEST(Fluorescence, AFurnaceGivesOutWhatItTakesIn) {
  Scene scene = FurnaceCube(0.3, 0);
  const Reradiation m{0.3, 0.2, 0.4};
  for (Material& material : scene.materials) {
    material.exitance = {0, 0, 1};
    material.reradiation = m;
  }
  for (Polygon& polygon : scene.polygons) polygon.sides |= kFrontEmits;
  const SolveResult result = Solve(scene, 0.02);
  const double blue = 1 / 0.7, green = m.blue_to_green * blue / 0.7,
               red = (m.blue_to_red * blue + m.green_to_red * green) / 0.7;
  for (const PatchFace& face : result.patch.faces) {
    EXPECT_NEAR(face.irradiance[0] / red, 1, 2e-3);
    EXPECT_NEAR(face.irradiance[1] / green, 1, 2e-3);
    EXPECT_NEAR(face.irradiance[2] / blue, 1, 2e-3);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(face.radiosity[c] / face.irradiance[c], 1, 5e-3);
  }
  // What is given out in a channel counts as emitted there, what is taken for it as absorbed.
  const RoundSummary& last = LastRound(result);
  EXPECT_NEAR(last.emitted_w[2], 6, 1e-6);
  EXPECT_NEAR(last.emitted_w[1], 6 * m.blue_to_green * blue, 0.02);
  EXPECT_NEAR(last.emitted_w[0], 6 * (m.blue_to_red * blue + m.green_to_red * green), 0.02);
  EXPECT_NEAR(last.absorbed_w[2], 6 * 0.7 * blue, 0.02);
  EXPECT_LT(last.energy_imbalance, 2e-3);
}

// Plates without end: what mirrors all round make of two squares. Plate 1 shines blue and reflects
// half of all, plate 2 reflects 0.2 of blue and 0.4 of green and turns half of blue to green.
TEST(Fluorescence, TwoPlates) {
  BoxFaces faces;
  faces.reflectance[4] = Rgb(0.5);
  faces.exitance[4] = {0, 0, 1};
  Scene scene = BoxRoom({6, 6, 1}, faces);
  MakeFluorescent(scene, 5, {0, 0.4, 0.2}, {0.5, 0, 0});
  for (uint32_t p = 0; p < 4; ++p) {
    MakeFluorescent(scene, p, Rgb(0.0), {});
    scene.materials.back().specular = 1;
  }
  const SolveResult result = Solve(scene, 0.02);
  const double blue[] = {1.11111111111111, 0.222222222222222},
               green[] = {0.347222222222222, 0.694444444444444};
  int faces_seen = 0;
  for (const PatchFace& face : result.patch.faces) {
    if (face.polygon < 4) continue;
    const int plate = face.polygon == 4 ? 0 : 1;
    EXPECT_NEAR(face.radiosity[2] / blue[plate], 1, 0.012);
    EXPECT_NEAR(face.radiosity[1] / green[plate], 1, 0.012);
    EXPECT_EQ(face.radiosity[0], 0);
    ++faces_seen;
  }
  EXPECT_GE(faces_seen, 2);
}

// A room with a lamp that is nearly blue, fluorescent walls, and a fluorescent sheet.
Scene Room() {
  BoxFaces faces;
  faces.reflectance = {Rgb(.6, .5, .4), Rgb(.3), Rgb(.5), Rgb(.2, .4, .6), Rgb(.6), Rgb(.4)};
  faces.exitance[5] = Rgb(0.2, 0.1, 2);
  Scene scene = BoxRoom({2, 1, 1.5}, faces);
  MakeFluorescent(scene, 0, Rgb(.5, .4, .1), {0.6, 0.2, 0.3});
  MakeFluorescent(scene, 3, Rgb(.3, .3, .2), {0, 0.5, 0});
  AddSheet(scene, {{1, .2, .2}, {1.3, .2, 1}, {1.3, .8, 1}, {1, .8, .2}}, Rgb(.2), Rgb(.4, .3, .2));
  scene.materials.back().reradiation = {0.4, 0.1, 0};
  return scene;
}

TEST(Fluorescence, PathsThatChangeColourAgree) {
  const Scene scene = Room();
  const SolveResult result = Solve(scene, 0.02);
  EXPECT_LT(LastRound(result).energy_imbalance, 5e-3);
  ThreadPool pool(2);
  const std::vector<ReferencePoint> points =
      TracePaths(scene, {.points = 32, .error = 0.04, .seconds = 30}, pool);
  const Comparison off = Compare(result.patch, points).value();
  EXPECT_LT(off.l1_relative, 0.02 + NoiseOf(points));
  EXPECT_GT(Compare(Solve(scene, 0.2, "-fluorescence").patch, points).value().l1_relative, 0.15);
}

TEST(Fluorescence, TheSameOnOneAndThreeWorkers) {
  SolveToSameBits(Room(), Rotating(0.1, {0.3, 0.1}));
}

TEST(Fluorescence, SwitchedOffItLeavesNoTrace) {
  const Scene scene = Room();
  Scene plain = scene;
  for (Material& material : plain.materials) material.reradiation = {};
  const std::string off = BytesWithoutComments(Solve(scene, 0.2, "-fluorescence").patch);
  EXPECT_EQ(BytesWithoutComments(Solve(plain, 0.2, "+colour").patch), off);
  EXPECT_EQ(BytesWithoutComments(Solve(plain, 0.2, "+colour,+fluorescence").patch), off);
}

TEST(Fluorescence, NeglectCostsNoMoreThanItsBound) {
  for (const double share : {0.002, 0.1, 0.5}) {
    BoxFaces faces;
    faces.reflectance.fill(Rgb(0.4));
    faces.exitance[4] = Rgb(1);
    Scene scene = BoxRoom({1, 1, 1}, faces);
    for (uint32_t p = 0; p < 6; ++p) MakeFluorescent(scene, p, Rgb(0.4), {share, 0, 0});
    const Effect row = RowOf(scene, "fluorescence");
    ASSERT_TRUE(row.present && row.bound.has_value());
    EXPECT_EQ(row.on, share > 0.01);
    EXPECT_FALSE(RowOf(scene, "colour").bound.has_value());
    const auto arriving = [&](const std::string& effects) {
      const auto absorbed = LastRound(Solve(scene, 0.05, effects)).absorbed_w;
      return (absorbed[0] + absorbed[1] + absorbed[2]) / 0.6;
    };
    const double all = arriving("+fluorescence"), cost = (all - arriving("-fluorescence")) / all;
    EXPECT_GT(cost, 0.2 * share);
    EXPECT_LT(cost, *row.bound);
  }
}

TEST(Fluorescence, FollowsTheSceneAsBytes) {
  Scene scene = Room();
  const std::string bytes = Encode(scene);
  const auto back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(back->materials.back().reradiation, scene.materials.back().reradiation);
  Scene plain = scene;
  for (Material& material : plain.materials) material.reradiation = {};
  const std::string without = Encode(plain);
  EXPECT_EQ(without, bytes.substr(0, without.size()));
  for (size_t size = without.size() + 1; size < bytes.size(); ++size) {
    EXPECT_FALSE(Decode(bytes.substr(0, size)).has_value()) << size;
  }
  for (const double wrong : {-0.1, 0.6, std::nan("")}) {
    scene.materials.back().reradiation.blue_to_green = wrong;
    EXPECT_FALSE(Validate(scene).ok()) << wrong;
  }
}

}  // namespace
}  // namespace isolux::testing
