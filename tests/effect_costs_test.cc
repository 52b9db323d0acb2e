// What each effect took of a job: parts of the whole, nothing of those that are off, and all rays.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"
#include "worker/radiosity/effect_shares.h"

namespace isolux::testing {
namespace {

double CpuSeconds(const SolveResult& result) {
  double sum = 0;
  const auto add = [&](const std::vector<double>& workers) {
    for (const double cpu_s : workers) sum += cpu_s;
  };
  for (const RoundSummary& row : result.summary.rounds) add(row.worker_cpu_s);
  add(result.summary.gather_cpu_s);
  return sum;
}

// A room open above, with a mirror for a wall, a point light, a sun and an even sky.
Scene EverythingRoom() {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.5));
  Scene scene = BoxRoom({2, 2, 2}, faces);
  scene.polygons.erase(scene.polygons.begin() + 5);
  Material mirror = scene.materials[scene.polygons[0].material];
  mirror.specular = 0.8;
  mirror.reflectance = {0.1, 0.05, 0.1};
  scene.polygons[0].material = static_cast<uint32_t>(scene.materials.size());
  scene.materials.push_back(mirror);
  Light point;
  point.position_m = {1, 1, 3};
  point.intensity = Rgb(1);
  Light sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = glm::normalize(Vec3(0.2, 0.1, -1));
  sun.intensity = Rgb(1);
  sun.disc_radius = 0.005;
  scene.lights = {point, sun};
  scene.sky.columns = scene.sky.rows = 1;
  scene.sky.texels = {0.2F, 0.2F, 0.3F};
  return scene;
}

// Each row of the table shows it, 0 where the effect is off.
void ExpectSound(const SolveResult& result) {
  const EffectCosts& costs = result.summary.costs;
  EXPECT_EQ(costs.Total().rays, result.summary.rays);
  EXPECT_LE(costs.Total().cpu_s, CpuSeconds(result));
  int rows = 0;
  for (const auto& [key, value] : result.patch.comments) {
    if (key != "effect") continue;
    const std::string name = value.substr(0, value.find(' '));
    const EffectCost* cost = costs.Find(name);
    if (cost == nullptr) continue;
    ++rows;
    if (value.starts_with(name + " off")) {
      EXPECT_EQ(*cost, EffectCost()) << name;
    }
    EXPECT_THAT(value, ::testing::HasSubstr(
                           fmt::format(" cpu_s {:.3f} rays {} ", cost->cpu_s, cost->rays)));
  }
  EXPECT_EQ(rows, static_cast<int>(EffectCosts::kCount));
}

TEST(EffectCosts, RaysAddUpAndPartsAreNoMoreThanTheWhole) {
  SolveOptions options = ToAccuracy(0.5);
  options.effects = "+mirrors";
  options.max_rounds = 1;
  const SolveResult result = SolveScene(EverythingRoom(), options, 2);
  ExpectSound(result);
  EffectCosts costs = result.summary.costs;
  for (const char* name : {"lights", "sun", "sky", "occlusion", "mirrors", "closure"}) {
    EXPECT_GT(costs[name].cpu_s, 0) << name;
  }
  for (const char* name : {"lights", "sun", "sky", "mirrors"}) EXPECT_GT(costs[name].rays, 0U);
  EXPECT_GT(costs["mirrors"].links, 0U);
  EXPECT_LT(costs["mirrors"].links, result.summary.rounds.back().links);
}

TEST(EffectCosts, WhatIsOffTakesNothing) {
  const SolveResult dark = SolveScene(EverythingRoom(), 0.2, "-sun,-sky,-mirrors,-closure");
  ExpectSound(dark);
  // A grey convex room casts no ray and has one channel.
  const SolveResult convex = SolveScene(FurnaceCube(0.5, 1), 0.1);
  ExpectSound(convex);
  EffectCosts costs = convex.summary.costs;
  EXPECT_EQ(costs.Total().rays, 0U);
  EXPECT_EQ(costs["colour"], EffectCost());
  EXPECT_GT(costs["interreflection"].cpu_s + costs["closure"].cpu_s, 0);
}

TEST(EffectCosts, AreTheSameRaysOnAnyNumberOfWorkers) {
  SolveOptions options = ToAccuracy(0.2);
  options.epsilons = {0.5, 0.1};
  const EffectCosts one = SolveScene(CornellBox(true), options, 1).summary.costs,
                    three = SolveScene(CornellBox(true), options, 3).summary.costs;
  for (size_t i = 0; i < EffectCosts::kCount; ++i) {
    EXPECT_EQ(one.at(i).rays, three.at(i).rays) << EffectCosts::NameOf(i);
    EXPECT_EQ(one.at(i).links, three.at(i).links);
  }
}

// Ten products in 4 s, of which three are of later passes; one channel takes a quarter of a second,
// a quarter of the links go by way of mirrors.
TEST(EffectCosts, ProductsAreSharedOut) {
  SolveTimes times;
  times.closure_s = 1;
  times.closure_products = 4;
  times.solver_s = 4;
  times.solver_products = 10;
  times.again = 3;
  times.mirrors = 0.25;
  EffectsPlan plan;
  EffectCosts costs;
  AddSolveCosts(times, plan, true, false, costs);
  EXPECT_DOUBLE_EQ(costs["mirrors"].cpu_s, 1);
  EXPECT_DOUBLE_EQ(costs["colour"].cpu_s, 0.5);
  EXPECT_DOUBLE_EQ(costs["sheets"].cpu_s, 0.75);
  EXPECT_DOUBLE_EQ(costs["interreflection"].cpu_s, 1.5);
  EXPECT_DOUBLE_EQ(costs["closure"].cpu_s, 1);
  EXPECT_DOUBLE_EQ(costs["fluorescence"].cpu_s, 0);
  plan.channels = 1;
  plan.interreflection = false;
  EffectCosts grey;
  AddSolveCosts(times, plan, true, true, grey);
  EXPECT_DOUBLE_EQ(grey["colour"].cpu_s, 0);
  EXPECT_DOUBLE_EQ(grey["interreflection"].cpu_s, 0);
  EXPECT_DOUBLE_EQ(grey["sheets"].cpu_s, grey["fluorescence"].cpu_s);
}

}  // namespace
}  // namespace isolux::testing
