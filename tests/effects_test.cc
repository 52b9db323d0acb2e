// What neglecting an effect costs, measured on whole solves, against the bound that is stated for
// it; and that an effect which is off leaves no trace.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/hierarchy/effects/plan.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"

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

// Σ A |H − H'| / Σ A H over the leaves, which must be the same.
TEST(Effects, DirectLightAloneMissesNoMoreThanItsBound) {
  for (const double rho : {0.004, 0.05, 0.3}) {
    Scene scene = testing::FurnaceCube(rho, 0);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].exitance = {1, 1, 1};
    scene.polygons[4].material = 1;
    scene.polygons[4].sides |= kFrontEmits;
    const SolveResult whole = SolveWith(scene, "all"),
                      direct = SolveWith(scene, "-interreflection");
    // In a closed box Σ A H = Σ A E / (1 − ρ); all is grey.
    const double missing = 1 - Arriving(direct) / Arriving(whole);
    EXPECT_GT(missing, 0) << rho;
    EXPECT_LE(missing, BoundOf(scene, "interreflection") + 0.01) << rho;
    EXPECT_EQ(direct.summary.rounds.back().iterations, 1U);
    EXPECT_GT(whole.summary.rounds.back().iterations, 2U);
    // What is left out shows as residual.
    EXPECT_NEAR(direct.summary.rounds.back().residual, rho, 0.05 * rho + 1e-3);
  }
}

TEST(Effects, NothingIsCastInAConvexRoom) {
  const Scene scene = testing::FurnaceCube(0.5, 1);
  EXPECT_EQ(SolveWith(scene, "auto").summary.rays, 0U);
  EXPECT_GT(SolveWith(scene, "+occlusion").summary.rays, 0U);
}

}  // namespace
}  // namespace isolux
