// `isolux sweep` with its own coordinator and workers.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "client/output/reference_points.h"
#include "common/scene/patch_file.h"
#include "tests/support/processes.h"

namespace isolux::testing {
namespace {

using nlohmann::json;

const std::string kRoom = ScenePath("cornell_box/cornell_box.obj");

// Runs a sweep that must be refused before anything is solved; gives what it says.
std::string Refused(Programs& programs, std::vector<std::string> flags) {
  flags.insert(flags.begin(), {"isolux", "sweep"});
  const CommandResult result = programs.Run(flags);
  EXPECT_EQ(result.code, 2) << result.error;
  EXPECT_TRUE(result.output.empty());
  EXPECT_EQ(result.error.find("round 1"), std::string::npos) << result.error;
  return result.error;
}

TEST(SweepTest, MeasuresAgainstARunOfItsOwn) {
  Programs programs;
  const std::string csv = programs.Path("sweep.csv");
  const CommandResult result =
      programs.Run({"isolux", "sweep", kRoom, "--unit", "mm", "--accuracies", "0.1,0.3",
                    "--methods", "cg,jacobi+rotate", "--points", "4000", "-o", csv, "--json"});
  ASSERT_EQ(result.code, 0) << result.error;
  const json runs = result.Json()["runs"];
  ASSERT_EQ(runs.size(), 4U);
  for (const json& run : runs) {
    EXPECT_GT(run["seconds"], 0);
    EXPECT_GT(run["links"], 100);
    EXPECT_GT(run["bytes"], 1000);
    EXPECT_LE(run["error_estimate"], run["accuracy"]);
    EXPECT_GT(run["error_true"], 1e-3);
    EXPECT_LE(run["error_true"], run["accuracy"]) << run;
    EXPECT_GT(run["error_rms"], run["error_true"]);
  }
  EXPECT_EQ(runs[0]["accuracy"], 0.3) << "coarse to fine";
  EXPECT_EQ(runs[2]["method"], "jacobi+rotate");
  // Another solver of the same equations, and where pieces lie, changes next to nothing.
  EXPECT_NEAR(runs[1]["error_true"], runs[3]["error_true"], 0.01);
  EXPECT_GT(result.Json()["reference"]["error_estimate"], 0);
  EXPECT_NE(result.error.find("estimate"), std::string::npos) << "a table for people";
  std::ifstream file(csv);
  std::string line;
  int lines = 0;
  while (std::getline(file, line)) ++lines;
  EXPECT_EQ(lines, 5);
  EXPECT_TRUE(programs.TemporaryFiles().empty());
}

TEST(SweepTest, MeasuresAgainstExactValues) {
  // Everything in a white furnace receives E / (1 − ρ): here π / (1 − 0.5).
  Programs programs;
  std::vector<ReferencePoint> points;
  for (int i = 0; i < 64; ++i) {
    const double u = (i % 8 + 0.4) / 8, v = (i / 8 + 0.3) / 8;
    points.push_back({{u, v, 0}, {0, 0, 1}, Rgb(0.0), Rgb(0.0)});
  }
  for (ReferencePoint& point : points) point.irradiance = Rgb(M_PI / (1 - 0.5));
  const std::string csv = programs.Path("exact.csv"), scene = ScenePath("furnace_cube.obj");
  ASSERT_TRUE(WriteReferencePoints(points, csv).ok());
  const CommandResult result =
      programs.Run({"isolux", "sweep", scene, "--accuracies", "0.1", "--reference", csv});
  ASSERT_EQ(result.code, 0) << result.error;
  EXPECT_TRUE(result.output.starts_with("method,accuracy,seconds,")) << result.output;
  EXPECT_NE(result.error.find("at 64 points against exact.csv"), std::string::npos) << result.error;
  const CommandResult again =
      programs.Run({"isolux", "sweep", scene, "--accuracies", "0.1", "--reference", csv, "--json"});
  const json run = again.Json()["runs"][0];
  EXPECT_LT(run["error_true"], 0.003);
  EXPECT_TRUE(again.Json()["slopes"][0]["error_over_seconds"].is_null());
}

TEST(SweepTest, BadReferencesAreNamedBeforeAnythingIsSolved) {
  Programs programs;
  const std::string broken = programs.Path("broken.csv"), text = programs.Path("room.txt");
  std::ofstream(broken) << "0,0,0,0,0,1,1,1,1,0,0,0\nx,y\n";
  std::ofstream(programs.Path("bad.ply")) << "ply\nformat ascii 1.0\n";
  EXPECT_NE(Refused(programs, {kRoom, "--reference", broken}).find(broken + ":2"),
            std::string::npos);
  EXPECT_NE(Refused(programs, {kRoom, "--reference", text}).find(text), std::string::npos);
  EXPECT_NE(Refused(programs, {kRoom, "--reference", programs.Path("bad.ply")}).find("bad.ply:2"),
            std::string::npos);
  EXPECT_NE(Refused(programs, {kRoom, "--reference", programs.Path("absent.ply")}).find("absent"),
            std::string::npos);
  // A solution of another scene.
  const std::string other = programs.Path("other.ply");
  PatchFile file;
  file.comments = {{"scene_hash", "0123"}};
  ASSERT_TRUE(WritePatchFile(file, other).ok());
  const std::string says = Refused(programs, {kRoom, "--reference", other});
  EXPECT_NE(says.find(other), std::string::npos) << says;
  EXPECT_NE(says.find("import flags"), std::string::npos) << says;
}

TEST(SweepTest, BadFlagsExitWithTwo) {
  Programs programs;
  EXPECT_NE(Refused(programs, {kRoom, "--accuracies", "0.1,0"}).find("accuracy 0"),
            std::string::npos);
  EXPECT_NE(Refused(programs, {kRoom, "--accuracies", "a"}).find("--accuracies"),
            std::string::npos);
  EXPECT_NE(Refused(programs, {kRoom, "--methods", "magic"}).find("magic"), std::string::npos);
  EXPECT_NE(Refused(programs, {kRoom, "-o", "sweep.png"}).find("sweep.png"), std::string::npos);
  EXPECT_NE(Refused(programs, {kRoom, "--accuracy", "0.1"}).find("--accuracy"), std::string::npos);
  EXPECT_NE(Refused(programs, {programs.Path("absent.obj")}).find("absent.obj"), std::string::npos);
}

TEST(InspectTest, SaysWhatAccuraciesShouldCost) {
  Programs programs;
  const CommandResult result =
      programs.Run({"isolux", "inspect", kRoom, "--unit", "mm", "--cost", "--json"});
  ASSERT_EQ(result.code, 0) << result.error;
  const json cost = result.Json()["cost"];
  EXPECT_EQ(cost["workers"], 1);
  EXPECT_GE(cost["rounds"], 2);
  ASSERT_EQ(cost["accuracies"].size(), 6U);
  double links = 0, seconds = 0;
  for (const json& row : cost["accuracies"]) {
    for (const char* key : {"seconds", "links", "elements", "memory_bytes"}) {
      EXPECT_GT(row[key]["low"], 0) << row;
      EXPECT_LE(row[key]["low"], row[key]["likely"]) << row;
      EXPECT_LE(row[key]["likely"], row[key]["high"]) << row;
    }
    EXPECT_GT(row["links"]["likely"], links) << "finer takes more";
    EXPECT_GE(row["seconds"]["likely"], seconds);
    links = row["links"]["likely"];
    seconds = row["seconds"]["likely"];
  }
  EXPECT_TRUE(programs.TemporaryFiles().empty());
  programs.StartServer();
  programs.StartWorker();
  const CommandResult text = programs.Isolux({"inspect", kRoom, "--unit", "mm", "--cost"});
  EXPECT_EQ(text.code, 0) << text.error;
  EXPECT_NE(text.output.find("0.5 %"), std::string::npos) << text.output;
  EXPECT_EQ(programs.WaitForEnd(1).state, JobState::kCancelled) << "its rounds are all it is for";
  EXPECT_EQ(programs.Run({"isolux", "inspect", kRoom, "--workers", "2"}).code, 2);
}

}  // namespace
}  // namespace isolux::testing
