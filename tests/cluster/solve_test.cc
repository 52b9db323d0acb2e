// `isolux solve`, which starts everything itself and must leave nothing behind.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/support/processes.h"

namespace isolux::testing {
namespace {

const std::string kScene = ScenePath("cornell_box/cornell_box.obj");

// Processes that were started in the test's folder for temporary files, by their command lines.
std::vector<std::string> ProcessesOf(const Programs& programs) {
  std::vector<std::string> found;
  const std::string folder = programs.Path("tmp");
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "environ");
    std::ifstream line(entry.path() / "cmdline");
    std::string environment, command;
    std::getline(file, environment, '\x01');
    std::getline(line, command, '\0');
    const bool ours = environment.find("TMPDIR=" + folder) != std::string::npos;
    if (ours && command.find("isolux") != std::string::npos) found.push_back(command);
  }
  return found;
}

void ExpectNothingLeft(const Programs& programs) {
  for (int i = 0; i < 3000 && !(ProcessesOf(programs).empty() && programs.TemporaryFiles().empty());
       ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(ProcessesOf(programs), std::vector<std::string>());
  EXPECT_EQ(programs.TemporaryFiles(), std::vector<std::string>());
}

TEST(SolveTest, SolvesAndLeavesOnlyThePatchFile) {
  Programs programs;
  const std::string output = programs.Path("room.ply");
  const CommandResult result = programs.Run({"isolux", "solve", kScene, "--unit", "mm", "--workers",
                                             "2", "--accuracy", "0.2", "-o", output, "--json"});
  ASSERT_EQ(result.code, 0) << result.error;
  EXPECT_EQ(result.Json()["state"], "done");
  EXPECT_EQ(result.Json()["workers"], 2);
  EXPECT_EQ(result.Json()["output"], output);
  EXPECT_GT(Physics(output).size(), 10'000u);
  ExpectNothingLeft(programs);
}

TEST(SolveTest, ABudgetEndsItWithAResult) {
  Programs programs;
  const CommandResult result =
      programs.Run({"isolux", "solve", kScene, "--unit", "mm", "--accuracy", "0.01", "--max-rounds",
                    "2", "-o", programs.Path("room.ply"), "--json"});
  ASSERT_EQ(result.code, 0) << result.error;
  EXPECT_EQ(result.Json()["end_reason"], "all rounds done");
  EXPECT_EQ(result.Json()["rounds"], 2);
}

TEST(SolveTest, AFailureLeavesNothing) {
  Programs programs;
  const CommandResult unwritable = programs.Run(
      {"isolux", "solve", kScene, "--unit", "mm", "--accuracy", "0.3", "-o", "/absent/room.ply"});
  EXPECT_NE(unwritable.code, 0);
  EXPECT_NE(unwritable.error.find("/absent/room.ply"), std::string::npos) << unwritable.error;
  ExpectNothingLeft(programs);
}

// Starts a long solve and returns once its coordinator and its worker run.
ChildProcess StartLongSolve(Programs& programs) {
  ChildProcess solve = programs.Start({"isolux", "solve", kScene, "--unit", "mm", "--accuracy",
                                       "0.002", "-o", programs.Path("room.ply")},
                                      "solve.log");
  while (solve.Running() && ProcessesOf(programs).size() < 3) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  return solve;
}

TEST(SolveTest, AnInterruptCleansUp) {
  Programs programs;
  ChildProcess solve = StartLongSolve(programs);
  solve.Signal(SIGINT);
  EXPECT_TRUE(solve.Wait(60));
  EXPECT_EQ(solve.exit_code(), 130);
  ExpectNothingLeft(programs);
  EXPECT_FALSE(std::filesystem::exists(programs.Path("room.ply")));
  EXPECT_FALSE(std::filesystem::exists(programs.Path("room.ply.part")));
}

TEST(SolveTest, EvenWhenKilledNothingStays) {
  Programs programs;
  ChildProcess solve = StartLongSolve(programs);
  solve.Signal(SIGKILL);
  EXPECT_TRUE(solve.Wait(60));
  ExpectNothingLeft(programs);
}

}  // namespace
}  // namespace isolux::testing
