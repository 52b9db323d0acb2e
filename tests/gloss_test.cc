// Lobes between diffuse and mirror are not simulated: what that truly costs, for lobes as narrow as
// a mirror's, as wide as what is diffuse, and between, is below the bounds that are shown.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "client/output/comparison.h"
#include "common/hierarchy/effects/plan.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"

namespace isolux::testing {
namespace {

constexpr double kAccuracy = 0.1;

// A room with a lamp for its ceiling, a floor and a wall of which have lobes.
Scene GlossyRoom(double walls, const Gloss& gloss) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(walls));
  faces.reflectance[5] = Rgb(0.0);
  faces.exitance[5] = Rgb(1.0);
  Scene scene = BoxRoom({4, 3, 2.5}, faces);
  for (const size_t face : {0, 4}) scene.materials[scene.polygons[face].material].gloss = gloss;
  return scene;
}

// In truth, lobes narrow in this share and wide in the rest.
Scene Truth(Scene scene, double narrow) {
  for (Material& material : scene.materials) {
    if (material.gloss.kept) material.reflectance -= material.gloss.share;
    material.reflectance += (1 - narrow) * material.gloss.share;
    material.specular = narrow * Sum(material.gloss.share) / 3;
    material.gloss = {};
  }
  return scene;
}

Effect RowOf(const Scene& scene) {
  const EffectsTable table = PlanEffects(Hierarchy(scene), kAccuracy, {}, {});
  return *std::ranges::find(table.effects, "gloss", &Effect::name);
}

SolveResult Solve(const Scene& scene) {
  SolveOptions options = ToAccuracy(kAccuracy);
  options.max_rounds = 2;
  return SolveScene(scene, options);
}

double CostOf(const SolveResult& without, const Scene& truth) {
  const SolveResult with = Solve(truth);
  const auto found = Compare(without.patch, with.patch, {.samples = 1 << 14});
  EXPECT_TRUE(found.has_value());
  return found ? found->l1_relative : 0;
}

TEST(Gloss, CostsNoMoreThanIsShown) {
  const std::pair<double, Gloss> cases[] = {{0.2, {Rgb(0.4), false}},
                                            {0.55, {Rgb(0.1), false}},
                                            {0.5, {{0.1, 0.2, 0.4}, false}},
                                            {0.55, {{0.2, 0.3, 0.2}, true}}};
  for (const auto& [walls, gloss] : cases) {
    SCOPED_TRACE(fmt::format("{} {} {}", gloss.share.z, gloss.kept, walls));
    const Scene scene = GlossyRoom(walls, gloss);
    const Effect row = RowOf(scene);
    EXPECT_TRUE(row.present);
    EXPECT_EQ(row.decision, "not simulated");
    ASSERT_TRUE(row.bound.has_value());
    const SolveResult without = Solve(scene);
    ASSERT_EQ(without.summary.rounds[0].measured.size(), 1U);
    const double measured = without.summary.rounds[0].measured[0].Neglect();
    for (const double narrow : {0.0, 0.5, 1.0}) {
      const double cost = CostOf(without, Truth(scene, narrow));
      EXPECT_LT(cost, *row.bound) << narrow;
      EXPECT_LT(cost, measured) << narrow;
      if (gloss.kept && narrow == 0) {
        EXPECT_EQ(cost, 0);  // what is solved for
      } else {
        EXPECT_GT(cost, 0.01) << narrow;
      }
    }
  }
}

// The bounds say nothing else than they must: they are no more than some times the cost.
TEST(Gloss, BoundsAreNotFarAbove) {
  const Scene scene = GlossyRoom(0.2, {Rgb(0.3), false});
  const SolveResult without = Solve(scene);
  const double cost = CostOf(without, Truth(scene, 0));
  EXPECT_LT(*RowOf(scene).bound, 6 * cost);
  EXPECT_LT(without.summary.rounds[0].measured[0].Neglect(), 6 * cost);
}

TEST(Gloss, IsInNoBitOfTheSolution) {
  const Scene scene = GlossyRoom(0.4, {Rgb(0.3), false});
  Scene plain = scene;
  for (Material& material : plain.materials) material.gloss = {};
  EXPECT_FALSE(RowOf(plain).present);
  EXPECT_EQ(RowOf(plain).bound, 0.0);
  EXPECT_NE(Encode(plain), Encode(scene));
  EXPECT_TRUE(BytesWithoutComments(Solve(scene).patch) == BytesWithoutComments(Solve(plain).patch));
}

// Mirrors hand on light once more; what shines may shine on itself.
TEST(Gloss, BoundsKnowOfMirrorsAndLamps) {
  Scene scene = GlossyRoom(0.2, {Rgb(0.3), false});
  const double alone = *RowOf(scene).bound;
  scene.materials[scene.polygons[1].material].specular = 0.6;
  EXPECT_GT(*RowOf(scene).bound, 3 * alone);
  scene.materials[scene.polygons[1].material].specular = 0.8;
  EXPECT_FALSE(RowOf(scene).bound.has_value());  // light may go to and fro for ever
  scene.materials[scene.polygons[1].material].specular = 0;
  // Of little area: by the area, but where it is a lamp's.
  scene = GlossyRoom(0.2, {});
  Material& lamp = scene.materials[scene.polygons[5].material];
  lamp.gloss = {Rgb(0.4), false};
  EXPECT_NEAR(*RowOf(scene).bound, 0.4 / 0.8, 1e-12);
}

}  // namespace
}  // namespace isolux::testing
