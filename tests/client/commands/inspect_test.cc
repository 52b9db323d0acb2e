#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "client/commands/commands.h"
#include "client/commands/import_flags.h"
#include "common/hierarchy/effects/plan.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::TempDir;

struct Outcome {
  int code = 0;
  std::string out, err;
};

// Runs `isolux ARGS...` in this process.
Outcome RunCommand(std::vector<std::string> args) {
  CLI::App app("isolux");
  Run run;
  AddInspectCommand(app, run);
  std::reverse(args.begin(), args.end());  // as CLI11 wants it
  try {
    app.parse(args);
  } catch (const CLI::ParseError& error) {
    return {2, "", error.what()};
  }
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const int code = run();
  std::fflush(stdout);
  Outcome outcome{code, ::testing::internal::GetCapturedStdout(), {}};
  outcome.err = ::testing::internal::GetCapturedStderr();
  return outcome;
}

std::string OwnScene(const std::string& name) {
  return std::string(ISOLUX_SOURCE_DIR) + "/scenes/" + name;
}

Effect Find(const std::vector<Effect>& effects, const std::string& name) {
  const auto found = std::find_if(effects.begin(), effects.end(),
                                  [&](const Effect& effect) { return effect.name == name; });
  EXPECT_NE(found, effects.end()) << name;
  return found == effects.end() ? Effect() : *found;
}

TEST(Inspect, JsonHasTheAgreedKeys) {
  const Outcome outcome =
      RunCommand({"inspect", OwnScene("cornell_box/cornell_box.obj"), "--unit", "mm", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json figures = json::parse(outcome.out);
  EXPECT_EQ(figures["polygons"], 28);  // the floor is cut round the blocks
  EXPECT_EQ(figures["triangles"], 2);
  EXPECT_EQ(figures["surfaces"], 56);
  EXPECT_EQ(figures["emitters"], 1);
  EXPECT_EQ(figures["materials"], 4);
  EXPECT_EQ(figures["repairs"].size(), 3U);
  EXPECT_TRUE(figures["solvable"]);
  EXPECT_NEAR(figures["bounds"]["high"][0].get<double>(), 556, 1e-9);
  EXPECT_EQ(figures["scene_hash"].get<std::string>().size(), 32U);
  ASSERT_GT(figures["effects"].size(), 5U);
  for (const json& effect : figures["effects"]) {
    for (const char* key : {"name", "present", "evidence", "bound", "decision", "reason"}) {
      EXPECT_TRUE(effect.contains(key)) << key;
    }
  }
}

TEST(Inspect, TextGoesToStandardOutput) {
  const Outcome outcome = RunCommand({"inspect", OwnScene("furnace_cube.obj")});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("polygons               6 (0 triangles, 6 quads)"));
  EXPECT_THAT(outcome.out, HasSubstr("6 m²"));
  EXPECT_THAT(outcome.out, HasSubstr("repairs: none"));
  EXPECT_THAT(outcome.out, HasSubstr("interreflection"));
  EXPECT_EQ(outcome.err, "");
}

TEST(Inspect, ShowsDarkScenesAndSaysSo) {
  const TempDir dir;
  const std::string path = dir.Write("dark.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n");
  const Outcome outcome = RunCommand({"inspect", path, "--json"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("nothing emits light"));
  const json figures = json::parse(outcome.out);
  EXPECT_FALSE(figures["solvable"]);
  EXPECT_EQ(figures["file_polygons"], 2);
  EXPECT_EQ(figures["repairs"][0]["count"], 1);
}

TEST(Inspect, JudgesEffectsByTheAccuracyAndTheChoice) {
  const auto decision = [](const std::vector<std::string>& flags, const char* name) {
    std::vector<std::string> args = {"inspect", OwnScene("furnace_cube.obj"), "--json"};
    args.insert(args.end(), flags.begin(), flags.end());
    const Outcome outcome = RunCommand(args);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const json figures = json::parse(outcome.out);
    for (const json& effect : figures["effects"]) {
      if (effect["name"] == name) return effect["decision"].get<std::string>();
    }
    return std::string("missing");
  };
  EXPECT_EQ(decision({}, "occlusion"), "off");
  EXPECT_EQ(decision({}, "interreflection"), "on");
  EXPECT_EQ(decision({"--effects", "all"}, "occlusion"), "on");
  EXPECT_EQ(decision({"--effects=-interreflection"}, "interreflection"), "off");
}

TEST(Inspect, BadInputEndsWithTwo) {
  EXPECT_EQ(RunCommand({"inspect"}).code, 2);
  EXPECT_EQ(RunCommand({"inspect", OwnScene("room.obj"), "--unit", "yd"}).code, 2);
  EXPECT_EQ(RunCommand({"inspect", OwnScene("room.obj"), "--emit", "back"}).code, 2);
  EXPECT_EQ(RunCommand({"inspect", OwnScene("room.obj"), "--effects", "+ghosts"}).code, 2);
  const Outcome gone = RunCommand({"inspect", OwnScene("gone.obj")});
  EXPECT_EQ(gone.code, 2);
  EXPECT_THAT(gone.err, HasSubstr("gone.obj"));
  EXPECT_EQ(gone.out, "");
}

TEST(ImportFlags, ReachTheOptions) {
  CLI::App app("test");
  ImportOptions options;
  AddImportFlags(app, &options);
  std::vector<std::string> args = {"--strict",  "ft",   "--unit", "front",
                                   "--reflect", "both", "--emit"};
  app.parse(args);
  EXPECT_TRUE(options.emit_both);
  EXPECT_TRUE(options.reflect_front);
  EXPECT_TRUE(options.strict);
  EXPECT_EQ(options.unit, "ft");
}

TEST(Effects, WhatTheImporterReplacedIsNamed) {
  const TempDir dir;
  dir.Write("a.mtl", "newmtl m\nKd 0.1 0.1 0.1\nillum 3\nnewmtl l\nKe 1 1 1\nd 0.5\nTd 0.3\n");
  const auto scene = ImportScene(dir.Write("a.obj",
                                           "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 "
                                           "1\nusemtl m\nf 1 2 3\nusemtl l\nf 1 3 4\n"),
                                 {});
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  const auto effects = PlanEffects(Hierarchy(*scene), 0.02, {}).effects;
  EXPECT_TRUE(Find(effects, "mirrors").present);
  EXPECT_EQ(Find(effects, "mirrors").decision, "not simulated");
  EXPECT_THAT(Find(effects, "mirrors").evidence, HasSubstr("a.mtl:1"));
  EXPECT_TRUE(Find(effects, "clear-glass").present);
  EXPECT_EQ(Find(effects, "sheets").decision, "on");
  EXPECT_THAT(Find(effects, "sheets").evidence, HasSubstr("pass on up to 0.3"));
  EXPECT_FALSE(Find(effects, "textures").present);
}

}  // namespace
}  // namespace isolux
