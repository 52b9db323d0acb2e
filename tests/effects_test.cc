// What neglecting an effect costs, measured on whole solves, against the bound that is stated for
// it; and that an effect which is off leaves no trace.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "client/output/comparison.h"
#include "common/hierarchy/effects/plan.h"
#include "tests/support/glass.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "tests/support/textured_room.h"

namespace isolux {
namespace {

SolveResult SolveWith(const Scene& scene, const std::string& effects, int workers = 1) {
  SolveOptions options;
  options.accuracy = 0.1;
  double emitted_w = 0;
  const Hierarchy hierarchy(scene);
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    emitted_w += hierarchy.surface_area_m2(s) * Sum(hierarchy.surfaces()[s].exitance);
  }
  options.epsilons = {1e-2 * emitted_w, 1e-3 * emitted_w};
  options.effects = effects;
  // Nodes that move by measured times change how many values travel.
  options.balance = BalanceStrategy::kNone;
  auto result = testing::SolveInProcess(scene, options, workers, 2);
  EXPECT_TRUE(result.has_value()) << result.error().message();
  return result.has_value() ? std::move(*result) : SolveResult{};
}

// Power that arrives, Σ A H, over the channels: what an effect adds or takes away in all.
double Arriving(const SolveResult& result) {
  const RoundSummary& last = result.summary.rounds.back();
  double sum = 0;
  for (const double absorbed : last.absorbed_w) sum += absorbed;
  return sum;
}

double BoundOf(const Scene& scene, const char* name) {
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.02, {});
  const auto found = std::ranges::find(table.effects, name, &Effect::name);
  EXPECT_NE(found, table.effects.end());
  EXPECT_TRUE(found->bound.has_value());
  return *found->bound;
}

TEST(Effects, NothingIsCastInAConvexRoom) {
  const Scene scene = testing::FurnaceCube(0.5, 1);
  EXPECT_EQ(SolveWith(scene, "auto").summary.rays, 0U);
  EXPECT_GT(SolveWith(testing::RandomRoom(1, 4), "auto").summary.rays, 0U);
}

// A box that reflects ρ + tint, ρ and ρ − tint, with one wall that emits.
Scene TintedBox(double rho, double tint, const Rgb& exitance) {
  Scene scene = testing::FurnaceCube(rho, 0);
  for (Material& material : scene.materials) material.reflectance += tint * Rgb(1, 0, -1);
  scene.materials.push_back(scene.materials[0]);
  scene.materials.back().exitance = exitance;
  scene.polygons[4].material = static_cast<uint32_t>(scene.materials.size()) - 1;
  scene.polygons[4].sides |= kFrontEmits;
  return scene;
}

TEST(Effects, DirectLightAloneMissesNoMoreThanItsBound) {
  for (const double rho : {0.004, 0.05, 0.3}) {
    const Scene scene = TintedBox(rho, 0, {1, 1, 1});
    const SolveResult whole = SolveWith(scene, "all"),
                      direct = SolveWith(scene, "-interreflection");
    const double bound = BoundOf(scene, "interreflection");
    const double missing = 1 - Arriving(direct) / Arriving(whole);
    EXPECT_GT(missing, 0) << rho;
    EXPECT_LE(missing, bound + 0.01) << rho;  // two sets of links
    // The gather adds the first bounce.
    EXPECT_LE(Compare(direct.patch, whole.patch, {.samples = 1 << 14}).value().l1_relative,
              std::max(0.01, bound));
    EXPECT_EQ(direct.summary.rounds.back().iterations, 1U);
    EXPECT_GT(whole.summary.rounds.back().iterations, 2U);
    // What is left out shows as residual.
    EXPECT_NEAR(direct.summary.rounds.back().residual, rho, 0.005 * rho + 1e-4);
  }
}

TEST(Effects, OneChannelOfTintedLightIsOffByNoMoreThanItsBound) {
  for (const double tint : {0.02, 0.1}) {
    const Scene scene = TintedBox(0.6, tint, {2, 1, 0.5});
    const SolveResult coloured = SolveWith(scene, "+colour"), grey = SolveWith(scene, "-colour");
    const double off =
        Compare(grey.patch, coloured.patch, {.samples = 1 << 14}).value().l1_relative;
    EXPECT_GT(off, 0.1 * tint) << tint;
    EXPECT_LE(off, BoundOf(scene, "colour")) << tint;
    EXPECT_GE(grey.summary.rounds.back().error_solver, BoundOf(scene, "colour"));
  }
}

// A box of tinted walls with a scrap of a translucent sheet and one of glass, each of which costs
// so much at most.
struct Three {
  Scene scene;
  std::array<double, 3> bounds{};
};
constexpr const char* kThree[] = {"colour", "sheets", "clear-glass"};

Three ThreeThatCost(const std::array<double, 3>& wanted) {
  constexpr double kRho = 0.4;
  double side_m[] = {0.01, 0.01};
  Three three;
  for (int pass = 0; pass < 2; ++pass) {
    three.scene = TintedBox(kRho, wanted[0] * (1 - kRho) / (1 + wanted[0]), Rgb(1.0));
    const double s = side_m[0], g = side_m[1];
    const auto first = static_cast<uint32_t>(three.scene.vertices.size());
    for (const Vec3& v : {Vec3(.5, .5, .5), Vec3(.5 + s, .5, .5), Vec3(.5, .5 + s, .5)}) {
      three.scene.vertices.push_back(v);
    }
    Polygon scrap;
    scrap.vertices = {first, first + 1, first + 2, kNoVertex};
    scrap.material = static_cast<uint32_t>(three.scene.materials.size());
    scrap.file_polygon = three.scene.file_polygon_count++;
    three.scene.polygons.push_back(scrap);
    three.scene.materials.push_back({"sheet", Rgb(0.1), Rgb(0.0)});
    three.scene.materials.back().transmittance = Rgb(0.3);
    Pane pane;
    pane.corners = {Vec3(.2, .2, .7), Vec3(.2 + g, .2, .7), Vec3(.2 + g, .2 + g, .7),
                    Vec3(.2, .2 + g, .7)};
    pane.count = 4;
    three.scene.glazing.glasses = {testing::GlassOf(Rgb(0.5), 1)};
    three.scene.glazing.panes = {pane};
    for (size_t k = 0; k < 3; ++k) three.bounds[k] = BoundOf(three.scene, kThree[k]);
    for (size_t k = 1; k < 3; ++k) side_m[k - 1] *= std::sqrt(wanted[k] / three.bounds[k]);
  }
  return three;
}

// Each may be left out by itself, but not all: the largest is switched on, and what the others cost
// together is stated.
TEST(Effects, WhatIsLeftOutAddsUpToNoMoreThanHalfOfTheAccuracy) {
  constexpr double kAccuracy = 0.1;
  const Three three = ThreeThatCost({0.0170, 0.0185, 0.0175});
  for (const double bound : three.bounds) {
    EXPECT_LT(bound, kAccuracy / 5);
    EXPECT_GT(bound, kAccuracy / 6);
  }
  const Three two = ThreeThatCost({0.0150, 0.0160, 0.0140});
  for (const Three* of : {&three, &two}) {
    const double sum = of->bounds[0] + of->bounds[1] + of->bounds[2];
    const EffectsTable table = PlanEffects(Hierarchy(of->scene), kAccuracy, {});
    EXPECT_EQ(sum > kAccuracy / 2, of == &three);
    for (size_t k = 0; k < 3; ++k) {
      const auto row = std::ranges::find(table.effects, kThree[k], &Effect::name);
      EXPECT_EQ(row->on, of == &three && k == 1) << kThree[k];
      EXPECT_EQ(row->reason.find("adds up to more than half") != std::string::npos, row->on);
    }
    EXPECT_NEAR(table.neglected, of == &three ? sum - of->bounds[1] : sum, 1e-12);
  }
}

TEST(Effects, OneChannelOfWhiteLightHasTheBitsOfThree) {
  const Scene scene = TintedBox(0.6, 0, {2, 2, 2});
  const SolveResult three = SolveWith(scene, "+colour");
  EXPECT_EQ(BoundOf(scene, "colour"), 0);
  for (const int workers : {1, 3}) {
    const SolveResult one = SolveWith(scene, "auto", workers);
    EXPECT_EQ(testing::BytesWithoutComments(one.patch), testing::BytesWithoutComments(three.patch));
  }
}

TEST(Effects, OneChannelOfColouredLightIsThatLightTimesOneNumber) {
  const Scene scene = TintedBox(0.6, 0, {3, 1.5, 0});
  const SolveResult one = SolveWith(scene, "auto"), three = SolveWith(scene, "+colour");
  ASSERT_GT(one.patch.faces.size(), 6U);
  for (const PatchFace& face : one.patch.faces) {
    EXPECT_EQ(face.irradiance[1], 0.5F * face.irradiance[0]);
    EXPECT_EQ(face.irradiance[2], 0);
  }
  EXPECT_LT(Compare(one.patch, three.patch, {.samples = 1 << 14}).value().l1_relative, 1e-6);
}

// The scenes of the table in docs/effects.md: what is left out is worth less than was asked for.
// The last one coarsely, since the sky takes its time.
TEST(Effects, AutoIsAsGoodAsAll) {
  SolveOptions options, coarse;
  options.accuracy = coarse.accuracy = 0.2;
  coarse.epsilons = {16, 8};
  const std::pair<Scene, SolveOptions> cases[] = {{testing::FurnaceCube(0.5, 1), options},
                                                  {testing::CornellBox(true), options},
                                                  {testing::TexturedRoom(), coarse}};
  for (const auto& each : cases) {
    const Scene& scene = each.first;
    const SolveOptions& how = each.second;
    const auto solve = [&](const char* effects) {
      SolveOptions chosen = how;
      chosen.effects = effects;
      auto result = testing::SolveInProcess(scene, chosen, 1, 2);
      EXPECT_TRUE(result.has_value()) << result.error().message();
      return result.has_value() ? std::move(*result) : SolveResult{};
    };
    const SolveResult called_for = solve("auto"), all = solve("all");
    const auto off = Compare(called_for.patch, all.patch, {.samples = 1 << 14});
    ASSERT_TRUE(off.has_value()) << off.error().message();
    EXPECT_LT(off->l1_relative, 0.05);
    EXPECT_LE(called_for.summary.rays, all.summary.rays);
  }
}

// Closed rooms are closed, open ones add up to what rays say that does not escape.
TEST(Effects, TheRowOfClosureTellsWhatEscapes) {
  const auto row = [](const Scene& scene) {
    for (const auto& [key, value] : SolveWith(scene, "auto").patch.comments) {
      if (key == "effect" && value.starts_with("closure on")) return value;
    }
    return std::string();
  };
  Scene box = TintedBox(0.5, 0, Rgb(1.0));
  EXPECT_NE(row(box).find("; no ray escapes"), std::string::npos) << row(box);
  box.polygons.erase(box.polygons.begin() + 5);  // the side opposite the lamp
  const std::string open = row(box);
  const size_t at = open.find(" of the emitted power escapes, by rays of round 2");
  ASSERT_NE(at, std::string::npos) << open;
  const double share = std::stod(open.substr(open.rfind(' ', at - 1)));
  // Straight 0.2, by way of the walls no more than half of the rest.
  EXPECT_GT(share, 0.2);
  EXPECT_LT(share, 0.6);
}

TEST(Effects, OneChannelTravelsAsOneNumber) {
  const auto bytes = [](const std::string& effects) {
    const SolveResult result = SolveWith(TintedBox(0.6, 0, {2, 2, 2}), effects, 2);
    uint64_t sum = 0;
    for (const auto& [key, value] : result.patch.comments) {
      unsigned long long in = 0;
      if (key == "traffic" && std::sscanf(value.c_str(), "values bytes_in %llu", &in) == 1)
        sum += in;
    }
    return static_cast<double>(sum);
  };
  EXPECT_LT(bytes("auto"), 0.9 * bytes("+colour"));
}

}  // namespace
}  // namespace isolux
