// The same bits through real processes: with any number of workers, and whatever happens to them on
// the way.
#include <gtest/gtest.h>

#include <csignal>

#include "tests/support/processes.h"

namespace isolux::testing {
namespace {

const std::string kScene = ScenePath("cornell_box/cornell_box.obj");

// Many short rounds, so that something can happen in between; the gather is cheap.
const std::string kEpsilons = "1e-3,5e-4,3e-4,2e-4,1.5e-4,1.2e-4,1e-4,9e-5,8e-5,7e-5,6e-5,5e-5";
constexpr size_t kRounds = 12;

std::vector<std::string> SubmitCommand(const std::vector<std::string>& extra = {}) {
  std::vector<std::string> arguments = {"submit",     kScene, "--unit",     "mm",
                                        "--accuracy", "0.5",  "--epsilons", kEpsilons};
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  return arguments;
}

// The answer, computed once by one worker that nothing happens to.
const std::string& Undisturbed() {
  static const std::string physics = [] {
    Programs programs;
    programs.StartServer();
    programs.StartWorker();
    const std::string path = programs.Path("one.ply");
    const CommandResult result = programs.Isolux(SubmitCommand({"--wait", "-o", path}));
    EXPECT_EQ(result.code, 0) << result.error;
    return Physics(path);
  }();
  return physics;
}

class FaultsTest : public ::testing::Test {
 protected:
  void Start(int workers, const std::vector<std::string>& server_flags = {}) {
    programs_.StartServer(server_flags);
    for (int i = 0; i < workers; ++i) programs_.StartWorker();
  }
  void Submit(const std::vector<std::string>& extra = {}) {
    const CommandResult submitted = programs_.Isolux(SubmitCommand(extra));
    ASSERT_EQ(submitted.output, "1\n") << submitted.error;
  }
  // Waits until the job is well under way, and not yet at its end.
  void WaitUntilUnderWay() {
    const JobInfo job = programs_.WaitForRounds(1, 3);
    ASSERT_EQ(job.state, JobState::kRunning);
    ASSERT_LT(job.summary.rounds.size(), kRounds) << "too late for this test to mean anything";
  }
  void ExpectSameBits() {
    const JobInfo job = programs_.WaitForEnd(1);
    ASSERT_EQ(job.state, JobState::kDone) << job.error.message();
    EXPECT_EQ(job.summary.rounds.size(), kRounds);
    const std::string path = programs_.Path("result.ply");
    ASSERT_EQ(programs_.Isolux({"fetch", "1", "-o", path}).code, 0);
    EXPECT_TRUE(Physics(path) == Undisturbed()) << "other bits";
  }

  Programs programs_;
};

TEST_F(FaultsTest, TwoWorkers) {
  Start(2);
  Submit();
  ExpectSameBits();
}

TEST_F(FaultsTest, ThreeWorkersThatMoveEverythingEveryRound) {
  Start(3);
  Submit({"--balance", "rotate", "--distribution", "random"});
  ExpectSameBits();
}

TEST_F(FaultsTest, AWorkerIsKilled) {
  Start(3);
  Submit();
  WaitUntilUnderWay();
  programs_.worker(1).Signal(SIGKILL);
  ExpectSameBits();
  EXPECT_NE(programs_.ServerLog().find("is lost"), std::string::npos);
}

TEST_F(FaultsTest, AllWorkersAreKilledAndAnotherComes) {
  Start(2);
  Submit();
  WaitUntilUnderWay();
  programs_.worker(0).Signal(SIGKILL);
  programs_.worker(1).Signal(SIGKILL);
  programs_.WaitForWorkers(0);
  programs_.StartWorker();
  ExpectSameBits();
}

TEST_F(FaultsTest, AWorkerDrains) {
  Start(2);
  Submit();
  WaitUntilUnderWay();
  programs_.worker(0).Signal(SIGTERM);
  EXPECT_TRUE(programs_.worker(0).Wait(300));
  EXPECT_EQ(programs_.worker(0).exit_code(), 0);
  ExpectSameBits();
  EXPECT_EQ(programs_.ServerLog().find("is lost"), std::string::npos) << "it left in order";
}

TEST_F(FaultsTest, AWorkerHangs) {
  Start(3, {"--lease", "2"});
  Submit();
  WaitUntilUnderWay();
  programs_.worker(2).Signal(SIGSTOP);
  ExpectSameBits();
  programs_.worker(2).Signal(SIGCONT);
  programs_.WaitForWorkers(3);  // it comes back as a new one
}

TEST_F(FaultsTest, TheCoordinatorIsStoppedAndStartedAgain) {
  Start(1);
  Submit();
  WaitUntilUnderWay();
  programs_.server().Signal(SIGTERM);
  ASSERT_TRUE(programs_.server().Wait(60)) << "it stops whatever is under way";
  EXPECT_EQ(programs_.server().exit_code(), 0);
  programs_.StartServer();
  const JobState state = programs_.client().Get(1)->state;
  EXPECT_TRUE(state == JobState::kQueued || state == JobState::kRunning)
      << "not its turn, or on it";
  EXPECT_GE(programs_.client().Get(1)->summary.rounds.size(), 3u) << "it goes on where it was";
  programs_.StartWorker();
  ExpectSameBits();
}

TEST_F(FaultsTest, TheCoordinatorIsKilledAndStartedAgain) {
  Start(1);
  Submit();
  WaitUntilUnderWay();
  programs_.server().Signal(SIGKILL);
  ASSERT_TRUE(programs_.server().Wait(60));
  programs_.StartServer();
  programs_.StartWorker();
  ExpectSameBits();
}

TEST_F(FaultsTest, AnIdleWorkerLeavesAtOnce) {
  Start(1);
  programs_.worker(0).Signal(SIGTERM);
  EXPECT_TRUE(programs_.worker(0).Wait(60));
  EXPECT_EQ(programs_.worker(0).exit_code(), 0);
  programs_.WaitForWorkers(0);
}

TEST_F(FaultsTest, AWorkerComesBackToACoordinatorThatWasAway) {
  Start(1);
  const std::string address = programs_.address();
  programs_.server().Signal(SIGKILL);
  programs_.server().Wait(60);
  programs_.StartServer({}, address);
  programs_.WaitForWorkers(1);
}

}  // namespace
}  // namespace isolux::testing
