// The table of effects: what is found in a scene, and what is decided about it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/hierarchy/effects/plan.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

using ::testing::HasSubstr;

const Effect& Find(const EffectsTable& table, const std::string& name) {
  const auto found = std::ranges::find(table.effects, name, &Effect::name);
  EXPECT_NE(found, table.effects.end()) << name;
  return *found;
}

EffectsTable Plan(const Scene& scene, double accuracy = 0.02, const char* choice = "auto") {
  return PlanEffects(Hierarchy(scene), accuracy, ParseEffectsChoice(choice).value());
}

TEST(EffectsChoice, ReadsWordsInOrder) {
  const EffectsChoice none = ParseEffectsChoice("none, +closure").value();
  EXPECT_EQ(none.base, EffectsChoice::Base::kNone);
  EXPECT_TRUE(none.on.contains("closure"));
  const EffectsChoice last = ParseEffectsChoice("+closure,-closure").value();
  EXPECT_EQ(last.base, EffectsChoice::Base::kAuto);
  EXPECT_TRUE(last.off.contains("closure"));
  EXPECT_FALSE(last.on.contains("closure"));
  EXPECT_EQ(ParseEffectsChoice("").value().base, EffectsChoice::Base::kAuto);
  for (const char* bad : {"some", "+closure,all", "+", "-ghosts", ",", "closure"}) {
    const auto refused = ParseEffectsChoice(bad);
    ASSERT_FALSE(refused.has_value()) << bad;
    EXPECT_EQ(refused.error().code(), StatusCode::kInvalidArgument);
  }
  EXPECT_THAT(ParseEffectsChoice("-ghosts").error().message(), HasSubstr("interreflection"));
}

TEST(Effects, EveryRowIsComplete) {
  for (const char* choice : {"auto", "all", "none", "+closure,-occlusion"}) {
    const EffectsTable table = Plan(testing::CornellBox(true), 0.02, choice);
    for (const Effect& effect : table.effects) {
      EXPECT_FALSE(effect.evidence.empty()) << effect.name;
      EXPECT_FALSE(effect.reason.empty()) << effect.name;
      EXPECT_EQ(effect.on, effect.decision == "on") << effect.name;
    }
    for (const std::string_view name : kSwitchableEffects) {
      EXPECT_EQ(Find(table, std::string(name)).support, Support::kSwitchable);
    }
  }
}

TEST(Effects, FurnaceCallsForLittle) {
  const EffectsTable table = Plan(testing::FurnaceCube(0.5, 1));
  EXPECT_FALSE(Find(table, "colour").present);
  EXPECT_FALSE(Find(table, "occlusion").present);
  EXPECT_EQ(Find(table, "occlusion").bound, 0.0);
  EXPECT_FALSE(table.plan.occlusion);
  EXPECT_TRUE(Find(table, "interreflection").present);
  EXPECT_EQ(Find(table, "interreflection").bound, 0.5);
  EXPECT_EQ(table.plan.channels, 1);
  EXPECT_TRUE(table.plan.interreflection);
  EXPECT_TRUE(table.plan.closure);
  EXPECT_FALSE(Find(table, "two-sided").present);
  EXPECT_FALSE(Find(table, "mirrors").present);
}

TEST(Effects, CornellBoxCallsForColourShadowsAndBacks) {
  const EffectsTable table = Plan(testing::CornellBox(true));
  EXPECT_TRUE(Find(table, "colour").present);
  EXPECT_GT(Find(table, "colour").bound.value_or(0), 0.3);
  EXPECT_TRUE(Find(table, "occlusion").on);
  EXPECT_TRUE(Find(table, "two-sided").on);
  EXPECT_EQ(table.plan.channels, 3);
}

TEST(Effects, LampsOfSeveralColoursNeedChannels) {
  Scene scene = testing::FurnaceCube(0.5, 1);
  for (Material& material : scene.materials) material.exitance = {1, 0.5, 0.5};
  EXPECT_FALSE(Find(Plan(scene), "colour").present);  // all of one colour
  EXPECT_EQ(Plan(scene).plan.light_colour, Rgb(1, 0.5, 0.5));
  scene.materials[0].exitance = {1, 1, 0.5};
  EXPECT_TRUE(Find(Plan(scene), "colour").present);
  EXPECT_FALSE(Find(Plan(scene), "colour").bound.has_value());
}

TEST(Effects, AFifthOfTheAccuracyDecides) {
  const Scene scene = testing::FurnaceCube(0.01, 1);
  EXPECT_TRUE(Plan(scene, 0.04).plan.interreflection);
  const EffectsTable coarse = Plan(scene, 0.06);
  EXPECT_FALSE(coarse.plan.interreflection);
  EXPECT_FALSE(coarse.plan.closure);
  EXPECT_EQ(coarse.neglected, 0.01);
  EXPECT_THAT(Find(coarse, "closure").reason, HasSubstr("direct light alone"));
}

// Colour and interreflection are left out by their bounds, 0.3 and 0.15 of an accuracy that lets
// both pass; what the first round says of sheets may not bring them back.
TEST(Effects, WhatIsMeasuredDecidesAndSwitchesNothingOn) {
  Scene scene = testing::FurnaceCube(0.01, 1);
  Material sheet{"sheet", Rgb(0.0), Rgb(0.0)};
  sheet.transmittance = Rgb(0.9);
  scene.polygons.push_back(scene.polygons[0]);
  for (uint32_t& v : scene.polygons.back().vertices) {
    scene.vertices.push_back(0.5 * scene.vertices[v] + Vec3(0.2));
    v = static_cast<uint32_t>(scene.vertices.size() - 1);
  }
  scene.polygons.back().sides = kFrontTakesPart | kBackTakesPart;
  scene.polygons.back().material = static_cast<uint32_t>(scene.materials.size());
  scene.materials.push_back(sheet);
  const double accuracy = 0.6;  // a fifth is above 0.01 / (1 − 0.9), and below 0.9
  const EffectsTable before = Plan(scene, accuracy);
  EXPECT_EQ(before.to_measure, std::vector<std::string>{"sheets"});
  EXPECT_FALSE(before.plan.interreflection);
  const auto with = [&](double neglect) {
    MeasuredEffect found{.name = "sheets", .share = neglect / kMeasuredSafety};
    std::vector<MeasuredEffect> measured{found};
    const EffectsTable table = PlanEffects(Hierarchy(scene), accuracy, {}, measured);
    EXPECT_EQ(NoteDecisions(table, &measured), !table.plan.sheets);
    EXPECT_EQ(measured[0].off, !table.plan.sheets);
    EXPECT_EQ(measured[0].bound, Find(before, "sheets").bound);
    EXPECT_FALSE(table.plan.interreflection);
    return table;
  };
  EXPECT_FALSE(with(0.1).plan.sheets);
  EXPECT_EQ(with(0.1).plan.measured_error, 0.1);
  EXPECT_THAT(Find(with(0.1), "sheets").reason, HasSubstr("on, then off: measured 0.1"));
  EXPECT_TRUE(with(0.13).plan.sheets);
  EXPECT_EQ(with(0.13).plan.measured_error, 0);
  EXPECT_THAT(Find(with(0.13), "sheets").reason, HasSubstr("measured 0.13 after round 1"));
}

TEST(Effects, TheUserHasTheLastWord) {
  const Scene scene = testing::FurnaceCube(0.01, 1);
  EXPECT_TRUE(Plan(scene, 0.5, "+interreflection").plan.interreflection);
  const EffectsTable all = Plan(scene, 0.5, "all");
  EXPECT_TRUE(all.plan.occlusion && all.plan.interreflection && all.plan.closure);
  const EffectsTable none = Plan(testing::CornellBox(true), 0.02, "none,+occlusion");
  EXPECT_TRUE(none.plan.occlusion);
  EXPECT_FALSE(none.plan.interreflection || none.plan.closure);
}

}  // namespace
}  // namespace isolux
