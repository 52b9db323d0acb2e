#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "client/commands/commands.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using testing::TempDir;

struct Outcome {
  int code = 0;
  std::string out, err;
};

// Runs `isolux ARGS...` in this process.
Outcome RunCommand(std::vector<std::string> args) {
  CLI::App app("isolux");
  Run run;
  AddFactorsCommand(app, run);
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

std::string ReadText(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// A closed unit cube without any light, fronts inwards, one of its faces twice, and a dropped one.
std::string WriteCube(const TempDir& folder) {
  const std::string path = folder.path() + "/cube.obj";
  std::ofstream(path) << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                         "f 1 2 3 4\nf 1 2 2\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\n"
                         "f 4 8 5 1\n";
  return path;
}

TEST(Factors, JsonHasTheAgreedKeys) {
  const TempDir folder;
  const Outcome outcome =
      RunCommand({"factors", WriteCube(folder), "--tolerance", "1e-8", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json table = json::parse(outcome.out);
  EXPECT_EQ(table["polygons"], 7);  // the dropped one keeps its number
  ASSERT_EQ(table["rows"].size(), 6U);
  EXPECT_EQ(table["rows"][1]["polygon"], 2);
  std::map<int, double> sums;
  for (const json& factor : table["factors"]) {
    sums[factor[0]] += factor[2].get<double>();
    const bool opposite = factor[0] == 0 && factor[1] == 2;
    if (opposite) {
      EXPECT_NEAR(factor[2].get<double>(), 0.1998248956983874, 1e-8);
    }
    EXPECT_LE(factor[3].get<double>(), 1e-8);
  }
  EXPECT_EQ(table["factors"].size(), 30U);
  for (const json& row : table["rows"]) {
    EXPECT_NEAR(row["row_sum"].get<double>(), 1, 1e-7);
    EXPECT_NEAR(sums[row["polygon"]], row["row_sum"].get<double>(), 1e-10);
  }
  EXPECT_THAT(outcome.err, HasSubstr("15 pairs"));
  EXPECT_THAT(outcome.err, HasSubstr("reciprocity"));
}

TEST(Factors, WritesCsvAndRows) {
  const TempDir folder;
  const std::string file = folder.path() + "/F.csv";
  const Outcome outcome = RunCommand({"factors", WriteCube(folder), "-o", file});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(ReadText(file), StartsWith("p,q,F_pq,C_pq_m2,error\n0,2,0.19982"));
  EXPECT_THAT(ReadText(folder.path() + "/F.rows.csv"),
              StartsWith("polygon,area_m2,row_sum,missing,row_sum_before,row_error\n0,1,"));
}

TEST(Factors, CsvOnStandardOutputAndJsonInAFile) {
  const TempDir folder;
  const Outcome csv = RunCommand({"factors", WriteCube(folder)});
  EXPECT_THAT(csv.out, StartsWith("p,q,F_pq,C_pq_m2,error\n"));
  const std::string file = folder.path() + "/F.json";
  const Outcome quiet = RunCommand({"factors", WriteCube(folder), "-o", file, "--threads", "1"});
  EXPECT_EQ(quiet.out, "");
  EXPECT_EQ(json::parse(ReadText(file))["rows"].size(), 6U);
}

TEST(Factors, BothSidesAreToldApart) {
  const TempDir folder;
  const Outcome outcome = RunCommand({"factors", WriteCube(folder), "--reflect", "both"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, StartsWith("p,q,F_pq,C_pq_m2,error,side_p,side_q\n"));
  EXPECT_THAT(outcome.out, HasSubstr(",front,front\n"));
  EXPECT_THAT(outcome.out, ::testing::Not(HasSubstr("back")));  // backs see nothing of each other
}

TEST(Factors, BadInputIsTwo) {
  const TempDir folder;
  const std::string cube = WriteCube(folder);
  EXPECT_EQ(RunCommand({"factors", "missing.obj"}).code, 2);
  EXPECT_EQ(RunCommand({"factors", cube, "--tolerance", "0"}).code, 2);
  const Outcome unknown = RunCommand({"factors", cube, "-o", folder.path() + "/F.txt"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr(".csv"));
  EXPECT_EQ(RunCommand({"factors", cube, "-o", folder.path() + "/no/such/folder/F.csv"}).code, 1);
}

}  // namespace
}  // namespace isolux
