// The same bits: what a job gives depends on the scene and its thresholds, and on nothing else; and
// what it costs to spread it: a value travels once, links move and are not made again.
#include <gtest/gtest.h>

#include <atomic>

#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

// Rounds enough for elements below surfaces on every wall, few enough for a second.
SolveOptions ShortSolve() {
  SolveOptions options;
  options.accuracy = 0.1;
  options.epsilons = {0.2, 0.02, 0.003};
  options.cut_size = 64;
  return options;
}

const Scene& TestScene() {
  static const Scene* scene = new Scene(CornellBox(false));
  return *scene;
}

struct Outcome {
  std::string bytes;
  SolveSummary summary;
  Traffic traffic;
};

Outcome Solve(const SolveOptions& options, int workers, int threads) {
  LocalCluster cluster(workers, threads);
  Outcome outcome;
  Result<SolveResult> result =
      RunJob(cluster, MakeJobInput(TestScene(), options), {}, &outcome.traffic);
  EXPECT_TRUE(result.has_value()) << result.error().message();
  if (!result.has_value()) return outcome;
  outcome.summary = result->summary;
  outcome.bytes = BytesWithoutComments(std::move(result->patch));
  return outcome;
}

const Outcome& Reference() {
  static const Outcome* outcome = new Outcome(Solve(ShortSolve(), 1, 1));
  return *outcome;
}

TEST(ClusterBitsTest, TheReferenceIsASolution) {
  ASSERT_FALSE(Reference().bytes.empty());
  ASSERT_EQ(Reference().summary.rounds.size(), 3u);
  const RoundSummary& last = Reference().summary.rounds.back();
  EXPECT_GT(last.elements, 200u);
  EXPECT_GT(last.links, 1000u);
  EXPECT_LT(last.energy_imbalance, 0.2);
}

TEST(ClusterBitsTest, AnyNumberOfWorkersAndThreads) {
  for (const int workers : {1, 2, 3, 7}) {
    for (const int threads : {1, 2}) {
      const Outcome outcome = Solve(ShortSolve(), workers, threads);
      EXPECT_EQ(outcome.bytes == Reference().bytes, true) << workers << " workers, " << threads;
      EXPECT_EQ(outcome.summary.rounds.back().links, Reference().summary.rounds.back().links);
      EXPECT_EQ(outcome.summary.workers, static_cast<uint32_t>(workers));
    }
  }
}

TEST(ClusterBitsTest, AnyDistribution) {
  for (const Distribution distribution : {Distribution::kOctree, Distribution::kRandom,
                                          Distribution::kInput, Distribution::kBalanced}) {
    SolveOptions options = ShortSolve();
    options.distribution = distribution;
    EXPECT_EQ(Solve(options, 3, 1).bytes == Reference().bytes, true)
        << "distribution " << static_cast<int>(distribution);
  }
}

TEST(ClusterBitsTest, AnyStrategyCutAndSplits) {
  for (const BalanceStrategy strategy :
       {BalanceStrategy::kNone, BalanceStrategy::kRotate, BalanceStrategy::kGreedyRefine}) {
    for (const uint32_t cut_size : {64u, 256u}) {
      for (const uint32_t splits : {0u, 5u}) {
        SolveOptions options = ShortSolve();
        options.balance = strategy;
        options.balance_threshold = 1.0;
        options.cut_size = cut_size;
        options.forced_splits = splits;
        EXPECT_EQ(Solve(options, 2, 1).bytes == Reference().bytes, true)
            << "strategy " << static_cast<int>(strategy) << ", cut " << cut_size << ", splits "
            << splits;
      }
    }
  }
}

TEST(ClusterBitsTest, EverySolver) {
  const auto& expected = Reference().summary.rounds.back();
  for (const SolverMethod method : {SolverMethod::kJacobi, SolverMethod::kGaussSeidel,
                                    SolverMethod::kChebyshev, SolverMethod::kSouthwell}) {
    SolveOptions options = ShortSolve();
    options.solver = method;
    const Outcome alone = Solve(options, 1, 2), three = Solve(options, 3, 1);
    ASSERT_FALSE(alone.bytes.empty() || three.bytes.empty()) << ToText(method);
    // Those that only multiply have the same bits; those that go leaf by leaf, the same light.
    if (method == SolverMethod::kJacobi || method == SolverMethod::kChebyshev) {
      EXPECT_EQ(alone.bytes == three.bytes, true) << ToText(method);
    }
    for (const Outcome* outcome : {&alone, &three}) {
      const auto& last = outcome->summary.rounds.back();
      EXPECT_LE(last.error_solver, 0.1 * options.accuracy) << ToText(method);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(last.absorbed_w[c], expected.absorbed_w[c], 0.01 * expected.absorbed_w[c])
            << ToText(method);
      }
    }
  }
}

TEST(ClusterBitsTest, ASceneOfTwoSidesWithWorkersThatRotate) {
  const Scene scene = RandomRoom(7, 3);
  SolveOptions options;
  options.accuracy = 0.2;
  options.max_rounds = 3;
  const Result<SolveResult> alone = SolveInProcess(scene, options, 1, 2);
  ASSERT_TRUE(alone.has_value()) << alone.error().message();
  for (const RoundSummary& row : alone->summary.rounds) options.epsilons.push_back(row.epsilon);
  options.balance = BalanceStrategy::kRotate;
  options.forced_splits = 3;
  const Result<SolveResult> three = SolveInProcess(scene, options, 3, 1);
  ASSERT_TRUE(three.has_value()) << three.error().message();
  EXPECT_EQ(BytesWithoutComments(three->patch) == BytesWithoutComments(alone->patch), true);
}

TEST(ClusterBitsTest, AWorkerLostInTheMidst) {
  for (const uint32_t in_round : {1u, 2u, 3u}) {
    LocalCluster cluster(3, 1);
    JobCallbacks callbacks;
    std::atomic<int> lost{0};
    bool done = false;
    callbacks.on_progress = [&](const JobProgress& progress) {
      if (done || progress.round != in_round || progress.stage != JobProgress::Stage::kSolving)
        return;
      done = true;
      cluster.Kill(1);
    };
    callbacks.on_lost = [&](const WorkerSlot&, const Status&) { ++lost; };
    const Result<SolveResult> result =
        RunJob(cluster, MakeJobInput(TestScene(), ShortSolve()), callbacks);
    ASSERT_TRUE(result.has_value()) << result.error().message();
    EXPECT_EQ(lost, 1);
    EXPECT_EQ(result->summary.workers, 2u);
    EXPECT_EQ(result->summary.rounds.size(), 3u);
    EXPECT_EQ(BytesWithoutComments(result->patch) == Reference().bytes, true)
        << "lost in round " << in_round;
  }
}

TEST(ClusterBitsTest, AWorkerThatLeavesInOrderIsReleased) {
  LocalCluster cluster(2, 1);
  JobCallbacks callbacks;
  std::vector<std::string> released;
  bool asked = false;
  callbacks.on_progress = [&](const JobProgress& progress) {
    if (asked || progress.stage != JobProgress::Stage::kSolving) return;
    asked = true;
    cluster.Drain(0);
  };
  callbacks.on_snapshot = [&](const Snapshot& snapshot) {
    // The worker says so within a heartbeat; the rounds go by faster.
    if (snapshot.round < 3) std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return Status();
  };
  callbacks.on_released = [&](const WorkerSlot& slot) { released.push_back(slot.name); };
  const Result<SolveResult> result =
      RunJob(cluster, MakeJobInput(TestScene(), ShortSolve()), callbacks);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_EQ(released, std::vector<std::string>{"w1"});
  const Status left = cluster.Join(0);
  EXPECT_TRUE(left.ok()) << left.message();
  EXPECT_EQ(result->summary.workers, 1u);
  EXPECT_EQ(BytesWithoutComments(result->patch) == Reference().bytes, true);
}

TEST(ClusterBitsTest, AJobGoesOnFromItsSnapshots) {
  std::vector<Snapshot> snapshots;
  std::vector<RoundSummary> rounds;
  {
    LocalCluster cluster(2, 1);
    JobCallbacks callbacks;
    callbacks.on_snapshot = [&](const Snapshot& snapshot) {
      snapshots.push_back(snapshot);
      return Status();
    };
    callbacks.on_round = [&](const RoundSummary& row) {
      rounds.push_back(row);
      if (row.round != 2) return;
      cluster.Kill(0);
      cluster.Kill(1);
    };
    const Result<SolveResult> result =
        RunJob(cluster, MakeJobInput(TestScene(), ShortSolve()), callbacks);
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code(), StatusCode::kUnavailable) << result.error().message();
  }
  ASSERT_EQ(rounds.size(), 2u);
  LocalCluster cluster(3, 1);
  JobInput input = MakeJobInput(TestScene(), ShortSolve());
  input.snapshots = snapshots;
  input.rounds = rounds;
  const Result<SolveResult> result = RunJob(cluster, std::move(input));
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_EQ(result->summary.rounds.size(), 3u);
  EXPECT_EQ(BytesWithoutComments(result->patch) == Reference().bytes, true);
}

TEST(ClusterBitsTest, ARunnerWaitsForWorkersAndGoesOn) {
  LocalCluster cluster(1, 1);
  JobCallbacks callbacks;
  callbacks.workers = [&cluster] { return cluster.slots(); };
  callbacks.on_round = [&](const RoundSummary& row) {
    if (row.round == 2) cluster.Kill(0);
  };
  JobRunner runner(MakeJobInput(TestScene(), ShortSolve()), callbacks);
  const Result<SolveResult> nobody = runner.Run();
  ASSERT_FALSE(nobody.has_value());
  EXPECT_EQ(nobody.error().code(), StatusCode::kUnavailable);
  cluster.AddWorker();
  const Result<SolveResult> result = runner.Run();
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_EQ(BytesWithoutComments(result->patch) == Reference().bytes, true);
}

TEST(ClusterBitsTest, MigrationMovesLinksAndMakesNone) {
  SolveOptions options = ShortSolve();
  options.balance = BalanceStrategy::kNone;
  const Outcome still = Solve(options, 3, 1);
  options.balance = BalanceStrategy::kRotate;
  const Outcome moving = Solve(options, 3, 1);
  ASSERT_EQ(still.summary.rounds.size(), moving.summary.rounds.size());
  for (size_t i = 0; i < still.summary.rounds.size(); ++i) {
    EXPECT_EQ(still.summary.rounds[i].evaluations, moving.summary.rounds[i].evaluations);
    EXPECT_EQ(still.summary.rounds[i].proved_visible, moving.summary.rounds[i].proved_visible);
    EXPECT_EQ(still.summary.rounds[i].proved_hidden, moving.summary.rounds[i].proved_hidden);
    EXPECT_EQ(still.summary.rounds[i].rays, moving.summary.rounds[i].rays);
    EXPECT_EQ(still.summary.rounds[i].migrated_nodes, 0u);
    EXPECT_GT(moving.summary.rounds[i].migrated_nodes, 0u);
    EXPECT_GT(moving.summary.rounds[i].migrated_links, 0u);
  }
  EXPECT_EQ(still.traffic.Total(Phase::kMigrate).messages_out, 0u);
}

TEST(ClusterBitsTest, TheSceneTravelsOnceAndGeometryNever) {
  LocalCluster cluster(2, 1);
  const JobInput input = MakeJobInput(TestScene(), ShortSolve());
  Traffic first, second;
  ASSERT_TRUE(RunJob(cluster, input, {}, &first).has_value());
  JobCallbacks callbacks;
  uint32_t epoch = 100;
  callbacks.next_epoch = [&epoch] { return epoch++; };
  ASSERT_TRUE(RunJob(cluster, input, callbacks, &second).has_value());
  EXPECT_GE(first.Total(Phase::kScene).out, 2 * input.encoded_scene->size());
  EXPECT_LE(first.Total(Phase::kScene).out, 2 * (input.encoded_scene->size() + 100));
  EXPECT_EQ(second.Total(Phase::kScene).messages_out, 0u);
}

}  // namespace
}  // namespace isolux::testing
