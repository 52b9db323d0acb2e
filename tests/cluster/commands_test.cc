// The commands against a real coordinator with real workers: what they print and how they exit.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/support/processes.h"

namespace isolux::testing {
namespace {

using nlohmann::json;

const std::string kScene = ScenePath("cornell_box/cornell_box.obj");

std::vector<std::string> Submit(std::vector<std::string> extra) {
  std::vector<std::string> arguments = {"submit", kScene, "--unit", "mm", "--accuracy", "0.2"};
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  return arguments;
}

TEST(CommandsTest, SubmitWatchStatusJobsFetch) {
  Programs programs;
  programs.StartServer();
  programs.StartWorker();
  programs.StartWorker();
  const CommandResult submitted = programs.Isolux(Submit({}));
  EXPECT_EQ(submitted.code, 0) << submitted.error;
  EXPECT_EQ(submitted.output, "1\n");

  const CommandResult watched = programs.Isolux({"watch", "1", "--json"});
  EXPECT_EQ(watched.code, 0) << watched.error;
  EXPECT_NE(watched.error.find("round 1:"), std::string::npos);
  EXPECT_EQ(watched.Json()["state"], "done");

  const CommandResult status = programs.Isolux({"status", "1", "--json"});
  EXPECT_EQ(status.code, 0);
  const json job = status.Json();
  for (const char* key :
       {"job", "state", "accuracy", "error_estimate", "elements", "links", "rounds", "rays",
        "seconds", "energy_imbalance", "residual", "workers", "end_reason"}) {
    EXPECT_TRUE(job.contains(key) && !job[key].is_null()) << key;
  }
  EXPECT_EQ(job["workers"], 2);
  EXPECT_LE(job["error_estimate"], 0.2);
  EXPECT_NE(programs.Isolux({"status", "1"}).output.find("done"), std::string::npos);

  const CommandResult jobs = programs.Isolux({"jobs", "--json"});
  ASSERT_EQ(jobs.Json()["jobs"].size(), 1u);
  EXPECT_EQ(jobs.Json()["jobs"][0]["name"], "cornell_box.obj");
  EXPECT_NE(programs.Isolux({"jobs"}).output.find("cornell_box.obj"), std::string::npos);

  const CommandResult fetched = programs.Isolux({"fetch", "1", "-o", programs.Path("room.ply")});
  EXPECT_EQ(fetched.code, 0) << fetched.error;
  EXPECT_TRUE(fetched.output.empty()) << "standard output is data";
  EXPECT_GT(Physics(programs.Path("room.ply")).size(), 10'000u);
  EXPECT_FALSE(std::filesystem::exists(programs.Path("room.ply.part")));
}

TEST(CommandsTest, ReportOfAJobAndOfItsPatchFile) {
  Programs programs;
  programs.StartServer();
  EXPECT_EQ(programs.Isolux(Submit({})).code, 0);
  const std::string page = programs.Path("report.html");
  const CommandResult early = programs.Isolux({"report", "1", "-o", page});
  EXPECT_EQ(early.code, 1);
  EXPECT_NE(early.error.find("isolux watch 1"), std::string::npos) << early.error;
  programs.StartWorker();
  EXPECT_EQ(programs.Isolux({"watch", "1"}).code, 0);
  const CommandResult made = programs.Isolux({"report", "1", "-o", page});
  EXPECT_EQ(made.code, 0) << made.error;
  EXPECT_TRUE(made.output.empty()) << "standard output is data";
  const std::string text = ReadFile(page).value_or("");
  EXPECT_NE(text.find("<title>cornell_box.obj: report</title>"), std::string::npos);
  EXPECT_NE(text.find("\"state\":\"done\""), std::string::npos);

  // The file alone does as well; the job is then not known.
  ASSERT_EQ(programs.Isolux({"fetch", "1", "-o", programs.Path("box.ply")}).code, 0);
  EXPECT_EQ(programs.Run({"isolux", "report", programs.Path("box.ply"), "-o", page}).code, 0);
  EXPECT_NE(ReadFile(page).value_or("").find("\"job\":null"), std::string::npos);
  EXPECT_TRUE(programs.TemporaryFiles().empty());
}

TEST(CommandsTest, ReportSaysWhatIsWrong) {
  Programs programs;
  programs.StartServer();
  const std::string page = programs.Path("report.html");
  const auto report = [&](const std::string& source) {
    return programs.Isolux({"report", source, "-o", page});
  };
  const CommandResult unknown = report("77");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.error.find("no job 77"), std::string::npos) << unknown.error;
  const CommandResult missing = report(programs.Path("no.ply"));
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.error.find("no.ply"), std::string::npos) << missing.error;
  const CommandResult scene = report(kScene);
  EXPECT_EQ(scene.code, 2);
  EXPECT_NE(scene.error.find("cornell_box.obj:1"), std::string::npos) << scene.error;
  EXPECT_EQ(programs.Isolux({"report", "1"}).code, 2) << "without -o";
  EXPECT_FALSE(std::filesystem::exists(page));
}

TEST(CommandsTest, JobsQueueAndARequestIdGivesOneJob) {
  Programs programs;
  programs.StartServer();
  // No worker yet: all wait.
  const CommandResult first = programs.Isolux(Submit({"--request-id", "mine", "--json"}));
  EXPECT_EQ(first.Json()["job"], 1);
  EXPECT_EQ(first.Json()["existing"], false);
  const CommandResult again = programs.Isolux(Submit({"--request-id", "mine", "--json"}));
  EXPECT_EQ(again.Json()["job"], 1);
  EXPECT_EQ(again.Json()["existing"], true);
  const CommandResult other =
      programs.Isolux(Submit({"--request-id", "mine", "--max-rounds", "3"}));
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.error.find("new request id"), std::string::npos) << other.error;
  EXPECT_EQ(programs.Isolux(Submit({})).output, "2\n");
  EXPECT_EQ(programs.Isolux(Submit({})).output, "3\n");
  EXPECT_EQ(programs.Isolux({"cancel", "2"}).output, "job 2 cancelled\n");
  EXPECT_EQ(programs.client().Get(3)->state, JobState::kQueued);
  programs.StartWorker();
  EXPECT_EQ(programs.Isolux({"watch", "3"}).code, 0);
  EXPECT_EQ(programs.client().Get(1)->state, JobState::kDone);
  EXPECT_EQ(programs.Isolux({"watch", "2"}).code, 1) << "it was cancelled";
  EXPECT_EQ(programs.Isolux({"fetch", "2", "-o", programs.Path("no.ply")}).code, 1);
  EXPECT_FALSE(std::filesystem::exists(programs.Path("no.ply")));
  EXPECT_FALSE(std::filesystem::exists(programs.Path("no.ply.part")));
}

TEST(CommandsTest, ARunningJobIsCancelledAndTheNextOneRuns) {
  Programs programs;
  programs.StartServer();
  programs.StartWorker();
  EXPECT_EQ(programs.Isolux({"submit", kScene, "--unit", "mm", "--accuracy", "0.005"}).code, 0);
  programs.WaitForRounds(1, 1);
  const CommandResult cancelled = programs.Isolux({"cancel", "1", "--json"});
  EXPECT_EQ(cancelled.code, 0) << cancelled.error;
  EXPECT_EQ(cancelled.Json()["state"], "cancelled");
  const CommandResult next = programs.Isolux(Submit({"--wait", "--json"}));
  EXPECT_EQ(next.code, 0) << next.error;
  EXPECT_EQ(next.Json()["state"], "done");
}

TEST(CommandsTest, UnknownJobs) {
  Programs programs;
  programs.StartServer();
  for (const char* command : {"status", "watch", "cancel"}) {
    const CommandResult result = programs.Isolux({command, "77"});
    EXPECT_EQ(result.code, 2) << command;
    EXPECT_NE(result.error.find("no job 77"), std::string::npos) << result.error;
  }
  const CommandResult fetched = programs.Isolux({"fetch", "77", "-o", programs.Path("no.ply")});
  EXPECT_EQ(fetched.code, 2);
  EXPECT_FALSE(std::filesystem::exists(programs.Path("no.ply")));
}

TEST(CommandsTest, ADeadServer) {
  Programs programs;
  programs.StartServer();
  programs.server().Signal(SIGKILL);
  programs.server().Wait(60);
  for (const std::vector<std::string>& command : {std::vector<std::string>{"jobs"},
                                                  {"status", "1"},
                                                  {"watch", "1"},
                                                  {"cancel", "1"},
                                                  {"fetch", "1", "-o", programs.Path("no.ply")},
                                                  Submit({"--wait"})}) {
    const CommandResult result = programs.Isolux(command);
    EXPECT_EQ(result.code, 1) << command[0];
    EXPECT_NE(result.error.find(programs.address()), std::string::npos) << result.error;
    EXPECT_TRUE(result.output.empty());
  }
  const CommandResult worker = programs.Run({"isolux-worker", "--server", programs.address()});
  EXPECT_EQ(worker.code, 1);
  EXPECT_NE(worker.error.find("isolux-server"), std::string::npos) << worker.error;
  EXPECT_FALSE(std::filesystem::exists(programs.Path("no.ply.part")));
}

TEST(CommandsTest, OneServerAPortAndAFolder) {
  Programs programs;
  programs.StartServer();
  const CommandResult port = programs.Run(
      {"isolux-server", "--listen", programs.address(), "--data-dir", programs.Path("data2")});
  EXPECT_EQ(port.code, 1);
  EXPECT_NE(port.error.find("--listen"), std::string::npos) << port.error;
  const CommandResult folder = programs.Run(
      {"isolux-server", "--listen", "127.0.0.1:0", "--data-dir", programs.Path("data")});
  EXPECT_EQ(folder.code, 1);
  EXPECT_NE(folder.error.find("--data-dir"), std::string::npos) << folder.error;
  const CommandResult open = programs.Run(
      {"isolux-server", "--listen", "0.0.0.0:0", "--data-dir", programs.Path("data3")});
  EXPECT_EQ(open.code, 2);
  EXPECT_NE(open.error.find("--insecure"), std::string::npos) << open.error;
}

TEST(CommandsTest, AnOversizeSceneIsRefused) {
  Programs programs;
  programs.StartServer({"--max-polygons", "5"});
  const CommandResult result = programs.Isolux(Submit({}));
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.error.find("polygons; the limit of this coordinator is 5"), std::string::npos)
      << result.error;
  EXPECT_TRUE(programs.client().List(10)->empty());
  EXPECT_TRUE(std::filesystem::is_empty(programs.Path("data/incoming")));
}

TEST(CommandsTest, BadInputAndBadUsageExitWithTwo) {
  Programs programs;
  programs.StartServer();
  std::ofstream(programs.Path("bad.obj")) << "v 0 0 nan\nf 1 2 3\n";
  std::ofstream(programs.Path("empty.obj")) << "";
  const std::string good = kScene;
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"submit", programs.Path("bad.obj")},
                                             {"submit", programs.Path("empty.obj")},
                                             {"submit", programs.Path("absent.obj")},
                                             {"submit", good, "--accuracy", "0"},
                                             {"submit", good, "--accuracy", "x"},
                                             {"submit", good, "--unit", "miles"},
                                             {"submit", good, "--distribution", "none"},
                                             {"submit", good, "--request-id", "a b"},
                                             {"submit", good, "-o", programs.Path("x.ply")},
                                             {"submit"},
                                             {"status", "one"},
                                             {"fetch", "1"},
                                             {"frobnicate"}}) {
    const CommandResult result = programs.Isolux(command);
    EXPECT_EQ(result.code, 2) << command[0] << " " << command.back() << ": " << result.error;
    EXPECT_TRUE(result.output.empty());
    EXPECT_FALSE(result.error.empty());
  }
  EXPECT_EQ(programs.Run({"isolux", "jobs", "--server", "nowhere"}).code, 2);
  EXPECT_EQ(programs.Run({"isolux-server", "--log-level", "loud"}).code, 2);
  EXPECT_EQ(programs.Run({"isolux-worker", "--threads", "-1"}).code, 2);
  for (const char* program : {"isolux", "isolux-server", "isolux-worker"}) {
    EXPECT_EQ(programs.Run({program, "--help"}).code, 0);
  }
}

}  // namespace
}  // namespace isolux::testing
