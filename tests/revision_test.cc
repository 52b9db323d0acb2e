// Decisions about effects are made again once the first round has measured what neglecting them
// costs: what is left out costs no more than was measured, what matters stays, and nothing of it
// depends on workers, losses or restarts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/hierarchy/effects/plan.h"
#include "common/util/random.h"
#include "tests/support/glass.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"
#include "worker/radiosity/exchange.h"
#include "worker/shard.h"

namespace isolux::testing {
namespace {

// A rectangle in a wall's way, its corner and two sides; the number of its material.
uint32_t AddRectangle(Scene& scene, const Vec3& corner, const Vec3& u, const Vec3& v,
                      Material material, uint8_t sides) {
  Polygon polygon;
  polygon.vertices.fill(kNoVertex);
  for (int i = 0; i < 4; ++i) {
    polygon.vertices[static_cast<size_t>(i)] = static_cast<uint32_t>(scene.vertices.size());
    scene.vertices.push_back(corner + (i == 1 || i == 2 ? u : Vec3(0.0)) +
                             (i >= 2 ? v : Vec3(0.0)));
  }
  polygon.material = static_cast<uint32_t>(scene.materials.size());
  polygon.file_polygon = scene.file_polygon_count++;
  polygon.sides = sides;
  scene.materials.push_back(std::move(material));
  scene.polygons.push_back(polygon);
  return polygon.material;
}

const Vec3 kRoom(4, 3, 2.5);

// A room with a lamp of 0.5 m² below its ceiling.
Scene LitRoom(const Rgb& walls) {
  BoxFaces faces;
  faces.reflectance.fill(walls);
  faces.reflectance[4] = Rgb(0.3);
  Scene scene = BoxRoom(kRoom, faces);
  AddRectangle(scene, {1.5, 1.2, 2.45}, {0, 0.5, 0}, {1, 0, 0}, {"lamp", Rgb(0.0), Rgb(20.0)},
               kFrontTakesPart | kFrontEmits);
  return scene;
}

// With a mirror of this height and width before the wall x = 0.
Scene MirrorRoom(double side_m) {
  Scene scene = LitRoom(Rgb(0.6));
  Material mirror{"mirror", Rgb(0.05), Rgb(0.0)};
  mirror.specular = 0.9;
  AddRectangle(scene, {0.02, 1, 0.5}, {0, side_m, 0}, {0, 0, side_m}, mirror, kFrontTakesPart);
  return scene;
}

Scene SheetRoom(double side_m, double transmittance) {
  Scene scene = LitRoom(Rgb(0.5));
  Material sheet{"sheet", Rgb(0.3), Rgb(0.0)};
  sheet.transmittance = Rgb(transmittance);
  AddRectangle(scene, {1, 1, 1.2}, {side_m, 0, 0}, {0, side_m, 0}, sheet,
               kFrontTakesPart | kBackTakesPart);
  return scene;
}

Scene FluorescentRoom(double side_m) {
  Scene scene = LitRoom(Rgb(0.5));
  Material paint{"paint", Rgb(0.2), Rgb(0.0)};
  paint.reradiation = {0.2, 0.3, 0.2};
  AddRectangle(scene, {0.02, 1, 0.5}, {0, side_m, 0}, {0, 0, side_m}, paint, kFrontTakesPart);
  return scene;
}

Scene GlassRoom(double side_m) {
  Scene scene = LitRoom(Rgb(0.5));
  scene.glazing.glasses = {GlassOf({0.6, 0.7, 0.6}, 1)};
  Pane pane;
  pane.corners = {Vec3(1, 1, 1.2), Vec3(1 + side_m, 1, 1.2), Vec3(1 + side_m, 1 + side_m, 1.2),
                  Vec3(1, 1 + side_m, 1.2)};
  pane.count = 4;
  scene.glazing.panes = {pane};
  return scene;
}

Scene MediumRoom(double extinction_per_m) {
  Scene scene = LitRoom(Rgb(0.5));
  scene.medium.extinction_per_m = Rgb(extinction_per_m);
  return scene;
}

// ∫H dA over all faces and channels, W.
double Arriving(const SolveResult& result) {
  double power_w = 0;
  for (const PatchFace& face : result.patch.faces) {
    Vec3 area(0.0);
    const auto at = [&](size_t i) {
      return result.patch.vertices[face.vertices[i % face.vertices.size()]].position;
    };
    for (size_t i = 0; i < face.vertices.size(); ++i) area += 0.5 * glm::cross(at(i), at(i + 1));
    power_w += glm::length(area) * (face.irradiance[0] + face.irradiance[1] + face.irradiance[2]);
  }
  return power_w;
}

// The same of the elements of one worker, and what its first round measured, after rounds with
// these thresholds over the emitted power.
struct Solved {
  double arriving_w = 0;
  std::vector<MeasuredEffect> measured;
};
Solved SolveElements(const Scene& scene, const std::string& effects,
                     std::initializer_list<double> thresholds) {
  ThreadPool pool(1);
  NullExchange exchange;
  Shard shard(std::make_shared<const Scene>(scene), &pool);
  SolveOptions options = ToAccuracy(0.1);
  options.effects = effects;
  EXPECT_TRUE(shard.Start(options, {{{NodeId::kCluster, 0}}, {0}, 1}, 0).ok());
  Solved solved;
  for (const double threshold : thresholds) {
    const auto report = shard.RunRound(threshold * Sum(shard.EmittedPower()), 0.02, exchange);
    EXPECT_TRUE(report.has_value());
    if (!report->measured.empty()) solved.measured = report->measured;
    EXPECT_TRUE(shard.InstallSnapshot(shard.TakeSnapshot()).ok());
  }
  const Hierarchy hierarchy(scene);
  for (const LeafRecord& leaf : shard.TakeSnapshot().leaves) {
    const double area_m2 = std::ldexp(hierarchy.surface_area_m2(leaf.id.surface), -leaf.id.level());
    for (const double channel : leaf.irradiance) solved.arriving_w += area_m2 * channel;
  }
  return solved;
}

// What neglecting the effect costs: where it only adds light, or only takes some, all of it shows
// in the sum.
double CostOf(const Scene& scene, const std::string& effect) {
  const double with = SolveElements(scene, "all", {2e-2, 4e-3}).arriving_w;
  return std::abs(with - SolveElements(scene, "all,-" + effect, {2e-2, 4e-3}).arriving_w) / with;
}

Effect RowOf(const Scene& scene, const std::string& name, double accuracy,
             std::span<const MeasuredEffect> measured = {}) {
  const EffectsTable table = PlanEffects(Hierarchy(scene), accuracy, {}, measured);
  return *std::ranges::find(table.effects, name, &Effect::name);
}

const std::vector<MeasuredEffect>& Measured(const SolveResult& result) {
  return result.summary.rounds.front().measured;
}

std::string CommentOf(const SolveResult& result, const std::string& effect) {
  for (const auto& [key, value] : result.patch.comments) {
    if (key == "effect" && value.starts_with(effect + " ")) return value;
  }
  return {};
}

struct Case {
  const char* name;
  Scene little, much;
};

std::vector<Case> Cases() {
  return {{"mirrors", MirrorRoom(0.2), MirrorRoom(1.5)},
          {"sheets", SheetRoom(0.2, 0.3), SheetRoom(1.4, 0.5)},
          {"fluorescence", FluorescentRoom(0.3), FluorescentRoom(1.8)},
          {"clear-glass", GlassRoom(0.15), GlassRoom(1.5)},
          {"medium", MediumRoom(2e-3), MediumRoom(0.05)}};
}

TEST(Revision, WhatMattersLittleIsLeftOutAfterTheFirstRound) {
  constexpr double kAccuracy = 0.1;
  for (const Case& c : Cases()) {
    SCOPED_TRACE(c.name);
    EXPECT_TRUE(RowOf(c.little, c.name, kAccuracy).on);
    const SolveResult revised = SolveScene(c.little, kAccuracy);
    ASSERT_EQ(Measured(revised).size(), 1U);
    const MeasuredEffect& found = Measured(revised)[0];
    EXPECT_EQ(found.name, c.name);
    EXPECT_TRUE(found.off) << found.share << " " << found.amplification;
    EXPECT_LT(found.Neglect(), 0.2 * kAccuracy);
    EXPECT_LT(CostOf(c.little, c.name), found.Neglect());
    EXPECT_THAT(CommentOf(revised, c.name),
                ::testing::AllOf(::testing::HasSubstr(std::string(c.name) + " off present yes"),
                                 ::testing::HasSubstr(DecisionOf(found))));
    // The rest of the job is that of one without the effect, but for the cost in its estimate.
    SolveOptions one_round = ToAccuracy(kAccuracy);
    one_round.effects = std::string("-") + c.name;
    one_round.max_rounds = 1;
    const SolveResult without = SolveScene(c.little, one_round);
    const RoundSummary &last = revised.summary.rounds.back(),
                       &other = without.summary.rounds.front();
    EXPECT_GE(last.error_solver, found.Neglect());
    EXPECT_EQ(revised.summary.rounds.front().links, other.links);
    EXPECT_EQ(revised.summary.rounds.front().round, 1U);
    EXPECT_LE(last.error_estimate, kAccuracy);
    // Within the accuracy of what the effect brings.
    const double truth = SolveElements(c.little, "all", {2e-2, 2e-3, 5e-4}).arriving_w;
    EXPECT_NEAR(Arriving(revised) / truth, 1, kAccuracy);
  }
}

TEST(Revision, WhatMattersStays) {
  constexpr double kAccuracy = 0.1;
  for (const Case& c : Cases()) {
    SCOPED_TRACE(c.name);
    const SolveResult result = SolveScene(c.much, kAccuracy);
    ASSERT_EQ(Measured(result).size(), 1U);
    EXPECT_FALSE(Measured(result)[0].off);
    EXPECT_GE(Measured(result)[0].Neglect(), 0.2 * kAccuracy);
    EXPECT_THAT(CommentOf(result, c.name), ::testing::HasSubstr(DecisionOf(Measured(result)[0])));
    // Nothing else has changed.
    EXPECT_EQ(BytesWithoutComments(result.patch),
              BytesWithoutComments(SolveScene(c.much, kAccuracy, std::string("+") + c.name).patch));
  }
}

// Of rooms of all sizes, lamps and surfaces, with an effect of any size: the bound that the first
// round measures holds, and is not far above.
TEST(Revision, TheMeasuredBoundHoldsInRandomRooms) {
  double largest_ratio = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Scene scene = RandomRoom(seed, 1);
    Vec3 low(1e9), high(-1e9);
    for (const Vec3& v : scene.vertices) low = glm::min(low, v), high = glm::max(high, v);
    const Vec3 size = high - low;
    const double side = 0.1 + 0.5 * random.Unit();
    const Vec3 corner = low + Vec3(0.01, 0.3, 0.3) * size;
    const Vec3 u = side * Vec3(0, size.y, 0), v = side * Vec3(0, 0, size.z);
    Material material{"it", Rgb(0.2), Rgb(0.0)};
    const char* name = Cases()[seed % 5].name;
    if (seed % 5 == 4) {
      scene.medium.extinction_per_m = Rgb(0.01 + 0.05 * random.Unit());
    } else if (seed % 5 == 3) {
      scene.glazing.glasses = {GlassOf(Rgb(random.Unit()), 1)};
      Pane pane;
      pane.corners = {corner + 0.4 * size, corner + 0.4 * size + u, corner + 0.4 * size + u + v,
                      corner + 0.4 * size + v};
      pane.count = 4;
      scene.glazing.panes = {pane};
    } else {
      if (seed % 5 == 0) material.specular = 0.7;
      if (seed % 5 == 1) material.transmittance = Rgb(0.6);
      if (seed % 5 == 2) material.reradiation = {0.3, 0.2, 0.4};
      AddRectangle(scene, corner, u, v, material,
                   seed % 5 == 1 ? kFrontTakesPart | kBackTakesPart : kFrontTakesPart);
    }
    const Solved coarse = SolveElements(scene, "auto", {2e-2});
    ASSERT_EQ(coarse.measured.size(), 1U) << "seed " << seed;
    const double bound = coarse.measured[0].Neglect(), cost = CostOf(scene, name);
    EXPECT_GE(bound, cost) << name << ", seed " << seed;
    std::printf("seed %2d %-12s bound %.4f cost %.4f\n", static_cast<int>(seed), name, bound, cost);
    if (cost > 5e-3) largest_ratio = std::max(largest_ratio, bound / cost);
  }
  EXPECT_LT(largest_ratio, 8);
}

SolveOptions Fixed() {
  SolveOptions options = ToAccuracy(0.1);
  options.epsilons = {0.1, 0.02, 0.01};
  return options;
}

TEST(Revision, TheSameBitsOnOneAndThreeWorkers) {
  for (const Scene& scene : {MirrorRoom(0.2), SheetRoom(0.2, 0.3)}) {
    const SolveResult one = SolveScene(scene, Fixed(), 1), three = SolveScene(scene, Fixed(), 3);
    EXPECT_TRUE(Measured(one)[0].off);
    EXPECT_EQ(Measured(one), Measured(three));
    EXPECT_TRUE(BytesWithoutComments(one.patch) == BytesWithoutComments(three.patch));
  }
}

// Whether somebody is lost after it, or the coordinator starts again from what it has stored.
TEST(Revision, SurvivesLossesAndRestarts) {
  const Scene scene = MirrorRoom(0.2);
  JobInput stored = MakeJobInput(scene, Fixed());
  LocalCluster cluster(2, 1);
  JobCallbacks callbacks;
  callbacks.on_snapshot = [&](const Snapshot& snapshot) {
    if (snapshot.round <= 2) stored.snapshots.push_back(snapshot);
    return Status();
  };
  callbacks.on_round = [&](const RoundSummary& row) {
    if (row.round <= 2) stored.rounds.push_back(row);
    if (row.round == 1) cluster.Kill(1);
  };
  const auto result = RunJob(cluster, MakeJobInput(scene, Fixed()), callbacks);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_TRUE(Measured(*result)[0].off);
  ASSERT_EQ(stored.rounds.size(), 2U);
  EXPECT_EQ(stored.rounds[0].measured, Measured(*result));
  const std::string bytes = BytesWithoutComments(SolveScene(scene, Fixed()).patch);
  EXPECT_TRUE(BytesWithoutComments(result->patch) == bytes);

  LocalCluster another(1, 1);
  const auto resumed = RunJob(another, std::move(stored));
  ASSERT_TRUE(resumed.has_value()) << resumed.error().message();
  EXPECT_EQ(Measured(*resumed), Measured(*result));
  EXPECT_TRUE(BytesWithoutComments(resumed->patch) == bytes);
  EXPECT_EQ(CommentOf(*resumed, "mirrors"), CommentOf(*result, "mirrors"));
}

TEST(Revision, WhoInsistsOrHasNoSuchEffectMeasuresNothing) {
  const Scene scene = MirrorRoom(0.2);
  for (const char* effects : {"+mirrors", "all", "-mirrors"}) {
    const SolveResult result = SolveScene(scene, 0.1, effects);
    EXPECT_TRUE(Measured(result).empty()) << effects;
    const bool on = CommentOf(result, "mirrors").starts_with("mirrors on");
    EXPECT_EQ(on, std::string(effects) != "-mirrors");
  }
  EXPECT_TRUE(Measured(SolveScene(LitRoom(Rgb(0.5)), 0.1)).empty());
}

// More planes of mirrors than are simulated: the row says what that costs.
TEST(Revision, SaysWhatMirrorsCostThatAreNotSimulated) {
  Scene scene = LitRoom(Rgb(0.5));
  Material mirror{"mirror", Rgb(0.1), Rgb(0.0)};
  mirror.specular = 0.5;
  for (int i = 0; i < 520; ++i) {
    const double x = 0.2 + 0.006 * i;
    AddRectangle(scene, {x, 2.9, 0.5}, {0.004, 0.0001 * (1 + i % 7), 0}, {0, 0, 0.01}, mirror,
                 kFrontTakesPart);
  }
  SolveOptions options = ToAccuracy(0.2);
  options.max_rounds = 1;
  const SolveResult result = SolveScene(scene, options);
  ASSERT_EQ(Measured(result).size(), 1U);
  EXPECT_FALSE(Measured(result)[0].off);
  EXPECT_GT(Measured(result)[0].Neglect(), 0);
  EXPECT_THAT(CommentOf(result, "mirrors"),
              ::testing::AllOf(::testing::HasSubstr("mirrors not-simulated"),
                               ::testing::HasSubstr(" measured ")));
}

}  // namespace
}  // namespace isolux::testing
