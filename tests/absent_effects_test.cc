// An effect that a scene does not hold leaves no trace, whether it is switched on, off or left to
// the plan: the same bytes, rays and links. All that can be switched, in two scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/hierarchy/effects/plan.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"

namespace isolux::testing {
namespace {

// A grey convex room of which nothing but the lamp's light straight calls for anything.
Scene BlackRoom() {
  BoxFaces faces;
  faces.exitance[5] = Rgb(1);
  return BoxRoom({2, 1, 1.5}, faces);
}

// A coloured room with a screen before its lamp: all that follows from polygons alone.
Scene ScreenedRoom() {
  BoxFaces faces;
  faces.reflectance = {Rgb(.6, .5, .4), Rgb(.3), Rgb(.5), Rgb(.2, .4, .6), Rgb(.6), Rgb(.4)};
  faces.exitance[5] = Rgb(1, 1, .5);
  Scene scene = BoxRoom({2, 1, 1.5}, faces);
  const auto first = static_cast<uint32_t>(scene.vertices.size());
  scene.vertices.insert(scene.vertices.end(), {{.5, .2, 1}, {1.5, .2, 1}, {1.5, .8, .9}});
  scene.polygons.push_back({.vertices = {first, first + 1, first + 2, kNoVertex},
                            .material = scene.polygons[1].material,
                            .file_polygon = scene.file_polygon_count++});
  return scene;
}

struct Trace {
  std::string bytes;
  uint64_t rays = 0, links = 0, elements = 0;

  bool operator==(const Trace&) const = default;
};

Trace Solve(const Scene& scene, const std::string& effects) {
  SolveOptions options = ToAccuracy(0.3);
  options.epsilons = {0.5, 0.1};
  options.effects = effects;
  SolveResult result = SolveScene(scene, options);
  const RoundSummary& last = result.summary.rounds.back();
  return {BytesWithoutComments(std::move(result.patch)), result.summary.rays, last.links,
          last.elements};
}

// Solves with and without each effect that is absent; names those. Two leave a trace if one
// insists: occlusion casts the rays that proofs leave to do, all in vain, and closure scales rows
// also where nothing magnifies what they miss.
std::set<std::string> AbsentWithoutTrace(const Scene& scene) {
  std::set<std::string> absent;
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.3, {});
  const Trace plain = Solve(scene, "auto");
  for (const std::string_view name : kSwitchableEffects) {
    const auto row = std::ranges::find(table.effects, name, &Effect::name);
    if (row->present) continue;
    EXPECT_FALSE(row->on) << name;
    absent.insert(row->name);
    for (const std::string sign : {"+", "-"}) {
      if (sign + row->name == "+closure") continue;
      const Trace switched = Solve(scene, sign + row->name);
      EXPECT_TRUE(switched.bytes == plain.bytes) << sign << name;
      if (sign + row->name != "+occlusion") {
        EXPECT_EQ(switched.rays, plain.rays) << sign << name;
      }
      EXPECT_EQ(switched.links, plain.links) << sign << name;
      EXPECT_EQ(switched.elements, plain.elements) << sign << name;
    }
  }
  return absent;
}

TEST(AbsentEffects, LeaveNoTraceInABlackRoom) {
  const std::set<std::string> all(kSwitchableEffects.begin(), kSwitchableEffects.end());
  EXPECT_EQ(AbsentWithoutTrace(BlackRoom()), all);
  EXPECT_EQ(Solve(BlackRoom(), "").rays, 0U);
}

TEST(AbsentEffects, LeaveNoTraceWhereOthersAreOn) {
  const std::set<std::string> absent = AbsentWithoutTrace(ScreenedRoom());
  EXPECT_EQ(absent, (std::set<std::string>{"textures", "mirrors", "lights", "sun", "sky", "medium",
                                           "clear-glass", "sheets", "fluorescence"}));
}

}  // namespace
}  // namespace isolux::testing
