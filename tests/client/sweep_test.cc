#include "client/sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

namespace isolux {
namespace {

// error = 0.3 seconds^-0.4 = 2 links^-0.5 of one method; another with a single run.
Sweep MakeSweep() {
  Sweep sweep;
  sweep.scene = "room.obj";
  sweep.reference = "exact values";
  sweep.points = 1000;
  sweep.workers = 2;
  for (const double error : {0.1, 0.03, 0.01}) {
    SweepRun run;
    run.method = "cg";
    run.accuracy = 2 * error;
    run.error_true = error;
    run.error_estimate = 1.5 * error;
    run.seconds = std::pow(error / 0.3, -1 / 0.4);
    run.links = static_cast<uint64_t>(std::lround(std::pow(error / 2, -1 / 0.5)));
    run.ended_by = "accuracy reached";
    sweep.runs.push_back(run);
  }
  sweep.runs.push_back(sweep.runs.front());
  sweep.runs.back().method = "jacobi";
  sweep.runs.back().error_true = 0;
  return sweep;
}

std::vector<std::string> Split(const std::string& line, char at) {
  std::vector<std::string> words;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, at);) words.push_back(word);
  return words;
}

TEST(SweepTest, FitsPowers) {
  const std::vector<double> x{1, 10, 100}, y{5, 5 * std::pow(10, -0.7), 5 * std::pow(100, -0.7)};
  ASSERT_TRUE(FitPower(x, y).has_value());
  EXPECT_NEAR(*FitPower(x, y), 0.7, 1e-12);
  const std::vector<double> with_zero{5, 0, 5 * std::pow(100, -0.7)};
  EXPECT_NEAR(*FitPower(x, with_zero), 0.7, 1e-12) << "what has no logarithm is left out";
  const std::vector<double> same{3, 3, 3};
  EXPECT_FALSE(FitPower(same, y).has_value());
  const std::vector<double> alike{3, 3.1, 3.3};
  EXPECT_FALSE(FitPower(alike, y).has_value()) << "noise would be the slope";
  EXPECT_FALSE(FitPower(std::span(x).first(1), std::span(y).first(1)).has_value());
}

TEST(SweepTest, FitsSlopesMethodByMethod) {
  const auto slopes = FitSlopes(MakeSweep());
  ASSERT_EQ(slopes.size(), 2U);
  EXPECT_EQ(slopes[0].method, "cg");
  EXPECT_NEAR(slopes[0].seconds.value(), 0.4, 1e-9);
  EXPECT_NEAR(slopes[0].links.value(), 0.5, 1e-3);
  EXPECT_EQ(slopes[1].method, "jacobi");
  EXPECT_FALSE(slopes[1].seconds.has_value());
}

TEST(SweepTest, ParsesMethods) {
  const auto method = ParseSweepMethod("jacobi+rotate+random");
  ASSERT_TRUE(method.has_value()) << method.error().message();
  SolveOptions options;
  method->Apply(&options);
  EXPECT_EQ(options.solver, SolverMethod::kJacobi);
  EXPECT_EQ(options.balance, BalanceStrategy::kRotate);
  EXPECT_EQ(options.distribution, Distribution::kRandom);
  SolveOptions as_before;
  SweepMethod().Apply(&as_before);
  EXPECT_EQ(as_before.solver, SolveOptions().solver);
  for (const char* bad : {"", "magic", "cg+jacobi", "cg+", "cg,jacobi"}) {
    const auto refused = ParseSweepMethod(bad);
    ASSERT_FALSE(refused.has_value()) << bad;
    EXPECT_NE(refused.error().message().find("southwell"), std::string::npos);
  }
}

TEST(SweepTest, CsvHasARowARunWithAllColumns) {
  const auto lines = Split(ToCsv(MakeSweep()), '\n');
  ASSERT_EQ(lines.size(), 5U);
  const auto head = Split(lines[0], ',');
  for (const char* column :
       {"method", "accuracy", "seconds", "rounds", "links", "elements", "rays", "error_estimate",
        "error_true", "error_rms", "error_p95", "ratio", "bytes"}) {
    EXPECT_NE(std::find(head.begin(), head.end(), column), head.end()) << column;
  }
  for (const std::string& line : lines) EXPECT_EQ(Split(line, ',').size(), head.size()) << line;
  const auto place = [&](const char* name) {
    return static_cast<size_t>(std::find(head.begin(), head.end(), name) - head.begin());
  };
  EXPECT_EQ(Split(lines[1], ',')[place("error_true")], "0.1");
  EXPECT_EQ(Split(lines[1], ',')[place("ratio")], "1.5");
  EXPECT_EQ(Split(lines[4], ',')[place("ratio")], "") << "there is no error to divide by";
}

TEST(SweepTest, JsonHasTheRunsAndTheSlopes) {
  const nlohmann::json json = ToJson(MakeSweep());
  ASSERT_EQ(json["runs"].size(), 4U);
  for (const char* key : {"accuracy", "seconds", "links", "error_estimate", "error_true"}) {
    EXPECT_TRUE(json["runs"][0][key].is_number()) << key;
  }
  EXPECT_NEAR(json["runs"][1]["ratio"].get<double>(), 1.5, 1e-12);
  EXPECT_TRUE(json["runs"][3]["ratio"].is_null());
  EXPECT_NEAR(json["slopes"][0]["error_over_seconds"].get<double>(), 0.4, 1e-9);
  EXPECT_TRUE(json["slopes"][1]["error_over_links"].is_null());
  EXPECT_EQ(json["reference"]["points"], 1000);
}

TEST(SweepTest, TheTableSaysWhatDidNotReachItsAccuracy) {
  Sweep sweep = MakeSweep();
  sweep.runs[1].ended_by = "time budget used";
  const std::string table = ToTable(sweep);
  EXPECT_NE(table.find("time budget used"), std::string::npos) << table;
  EXPECT_NE(table.find("seconds^-0.40"), std::string::npos) << table;
  EXPECT_EQ(table.find("accuracy reached"), std::string::npos) << table;
}

}  // namespace
}  // namespace isolux
