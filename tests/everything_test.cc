// One small scene that calls for every effect there is, solved coarsely: where they meet nothing is
// lost, nothing overflows and the bits stay. Short enough for every sanitizer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/hierarchy/effects/plan.h"
#include "tests/support/glass.h"
#include "tests/support/same_bits.h"
#include "tests/support/scenes.h"
#include "tests/support/sheet.h"

namespace isolux::testing {
namespace {

Light LightOf(LightKind kind, const Vec3& position_m, const Vec3& direction, const Rgb& intensity) {
  Light light;
  light.kind = kind;
  light.position_m = position_m;
  light.direction = glm::normalize(direction);
  light.intensity = intensity;
  return light;
}

// A coloured room of 2 x 1 x 1.5 m whose ceiling shines and leaves a strip open: a mirror for a
// wall, a chequered floor, a fluorescent wall, a pane of glass and a sheet of paper, in thin smoke.
Scene Everything() {
  BoxFaces faces;
  faces.reflectance = {Rgb(.1), Rgb(.3), Rgb(.5), Rgb(.2, .4, .3), Rgb(.4), Rgb(.4)};
  faces.exitance[5] = Rgb(1, 1, 2);
  Scene scene = BoxRoom({2, 1, 1.5}, faces);
  for (const uint32_t v : scene.polygons[5].vertices) {
    if (scene.vertices[v].x > 1) {  // it shares its corners with the walls
      const uint32_t moved = static_cast<uint32_t>(scene.vertices.size());
      scene.vertices.push_back(scene.vertices[v] - Vec3(0.4, 0, 0));
      std::ranges::replace(scene.polygons[5].vertices, v, moved);
    }
  }
  scene.materials[scene.polygons[0].material].specular = 0.8;
  scene.materials[scene.polygons[3].material].reradiation = {0.4, 0.2, 0.2};
  Texture chequers{2, 2, Wrap::kRepeat, Wrap::kRepeat, {}};
  for (const float texel : {1.5F, 0.5F, 0.5F, 1.5F})
    chequers.texels.insert(chequers.texels.end(), 3, texel);
  scene.textures = {chequers};
  scene.coordinates = {{{1, 0, 0, 0}, {0, 1, 0, 0}}};
  scene.materials[scene.polygons[4].material].reflectance_map.texture = 0;
  scene.polygons[4].coordinates = 0;
  AddSheet(scene, {{.5, .2, .4}, {.9, .2, .4}, {.9, .8, .5}, {.5, .8, .5}}, Rgb(.3), Rgb(.4));
  AddPane(scene, {4, {Vec3(1.2, .1, .1), {1.2, .9, .1}, {1.3, .9, 1.2}, {1.3, .1, 1.2}}},
          GlassOf({.9, .7, .5}, 1.5));
  scene.medium.extinction_per_m = Rgb(.1, .1, .2);
  scene.lights = {LightOf(LightKind::kPoint, {1, .5, 1.2}, {0, 0, -1}, Rgb(.2)),
                  LightOf(LightKind::kSpot, {1.5, .5, 1}, {-1, 0, -.5}, Rgb(.3)),
                  LightOf(LightKind::kDirectional, {}, {-.2, .1, -1}, Rgb(3))};
  scene.lights[1].cosine_full = 0.9;
  scene.lights[1].cosine_none = 0.7;
  scene.lights[2].disc_radius = 0.01;
  scene.sky.columns = scene.sky.rows = 1;
  scene.sky.texels = {.5F, .6F, .8F};
  return scene;
}

TEST(Everything, IsCalledForAndMeets) {
  const Scene scene = Everything();
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.1, ParseEffectsChoice("all").value());
  for (const std::string_view name : kSwitchableEffects) {
    const auto row = std::ranges::find(table.effects, name, &Effect::name);
    EXPECT_TRUE(row->present && row->on) << name;
  }
  SolveOptions options = Rotating(1, {12});
  options.effects = "all";
  const SolveResult result = SolveToSameBits(scene, options);
  ASSERT_GT(result.patch.faces.size(), 10U);
  for (const PatchVertex& vertex : result.patch.vertices) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_TRUE(std::isfinite(vertex.irradiance[c]) && vertex.irradiance[c] >= 0);
      EXPECT_TRUE(std::isfinite(vertex.radiosity[c]) && vertex.radiosity[c] >= 0);
    }
  }
  const RoundSummary& last = result.summary.rounds.back();
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(last.medium_w[c], 0) << c;
    EXPECT_GT(last.glass_w[c], 0) << c;
    EXPECT_GT(last.escaped_w[c], 0) << c;
  }
  EXPECT_LT(last.energy_imbalance, 0.006);
}

}  // namespace
}  // namespace isolux::testing
