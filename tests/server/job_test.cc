// How a job ends, other than well: cancelled, finished early, out of budget, out of workers.
#include "server/job.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

SolveOptions Coarse() {
  SolveOptions options;
  options.accuracy = 0.2;
  return options;
}

TEST(JobTest, ReportsWhatItDid) {
  LocalCluster cluster(2, 1);
  JobCallbacks callbacks;
  std::vector<uint32_t> rounds, snapshots;
  std::vector<JobProgress::Stage> stages;
  callbacks.on_round = [&](const RoundSummary& row) { rounds.push_back(row.round); };
  callbacks.on_snapshot = [&](const Snapshot& snapshot) {
    snapshots.push_back(snapshot.round);
    return Status();
  };
  callbacks.on_progress = [&](const JobProgress& progress) { stages.push_back(progress.stage); };
  Traffic traffic;
  const auto result =
      RunJob(cluster, MakeJobInput(CornellBox(false), Coarse()), callbacks, &traffic);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_EQ(result->summary.end_reason, EndReason::kAccuracy);
  EXPECT_LE(result->summary.rounds.back().error_estimate, 0.2);
  EXPECT_EQ(rounds.size(), result->summary.rounds.size());
  EXPECT_EQ(rounds, snapshots);
  EXPECT_EQ(stages.front(), JobProgress::Stage::kStarting);
  EXPECT_EQ(stages.back(), JobProgress::Stage::kGathering);
  const RoundSummary& last = result->summary.rounds.back();
  EXPECT_EQ(last.worker_cpu_s.size(), 2u);
  EXPECT_GT(last.bytes_in, 0u);
  EXPECT_GT(last.bytes_out, 0u);
  EXPECT_GE(last.load_max_over_mean, 1.0);
  const PatchFile& patch = result->patch;
  for (const char* key : {"version", "unit", "scene_hash", "accuracy", "error_estimate", "rounds",
                          "epsilons", "links", "seconds", "end_reason", "workers", "round"}) {
    EXPECT_FALSE(patch.Comment(key).empty()) << key;
  }
  EXPECT_EQ(patch.Comment("end_reason"), "accuracy reached");
  EXPECT_EQ(patch.Comment("workers"), "2");
  EXPECT_TRUE(DecodePatchFile(Encode(patch), "room.ply").has_value());
}

TEST(JobTest, CommentsTellTheSceneItsRepairsAndTheBytesOfEachConnection) {
  LocalCluster cluster(2, 1);
  Scene scene = CornellBox(false);
  scene.repairs.entries = {{"faces divided", 3, "box.obj:17"}, {"quads merged", 1, ""}};
  JobInput input = MakeJobInput(scene, Coarse());
  input.name = "box.obj";
  const auto result = RunJob(cluster, std::move(input));
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_EQ(result->patch.Comment("scene"), "box.obj");
  std::vector<std::string> repairs;
  std::map<std::string, uint64_t> total, by_connection;  // bytes, in and out, of a phase
  std::set<int> connections;
  for (const auto& [key, value] : result->patch.comments) {
    if (key == "repair") repairs.push_back(value);
    if (key != "traffic" && key != "worker_traffic") continue;
    std::istringstream words(value);
    int connection = 0;
    if (key == "worker_traffic") words >> connection;
    std::string phase, in_word, out_word;
    uint64_t in = 0, out = 0;
    words >> phase >> in_word >> in >> out_word >> out;
    EXPECT_EQ(in_word + " " + out_word, "bytes_in bytes_out") << value;
    (connection == 0 ? total : by_connection)[phase] += in + out;
    if (connection != 0) connections.insert(connection);
  }
  EXPECT_EQ(repairs, (std::vector<std::string>{"3 faces divided (box.obj:17)", "1 quads merged"}));
  EXPECT_EQ(connections, (std::set<int>{1, 2}));
  for (const auto& [phase, bytes] : total) EXPECT_EQ(by_connection[phase], bytes) << phase;
  EXPECT_GT(total["values"], 0u);
}

TEST(JobTest, TheThresholdsInTheFileReplayToTheSameBits) {
  const Scene scene = CornellBox(false);
  SolveOptions options = Coarse();
  options.max_links = 1500;
  const auto first = SolveInProcess(scene, options, 2, 1);
  ASSERT_TRUE(first.has_value()) << first.error().message();
  SolveOptions again = Coarse();
  std::istringstream epsilons(first->patch.Comment("epsilons"));
  for (double epsilon = 0; epsilons >> epsilon;) again.epsilons.push_back(epsilon);
  ASSERT_EQ(again.epsilons.size(), first->summary.rounds.size());
  const auto second = SolveInProcess(scene, again, 1, 1);
  ASSERT_TRUE(second.has_value()) << second.error().message();
  EXPECT_EQ(BytesWithoutComments(second->patch) == BytesWithoutComments(first->patch), true);
}

TEST(JobTest, CancelledInARoundOrInTheGather) {
  for (const auto stage : {JobProgress::Stage::kSolving, JobProgress::Stage::kGathering}) {
    LocalCluster cluster(2, 1);
    JobCallbacks callbacks;
    bool cancel = false;
    callbacks.on_progress = [&](const JobProgress& progress) { cancel |= progress.stage == stage; };
    callbacks.cancelled = [&] { return cancel; };
    auto result = RunJob(cluster, MakeJobInput(CornellBox(false), Coarse()), callbacks);
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code(), StatusCode::kCancelled);
    // The workers are as good as new.
    JobCallbacks next;
    uint32_t epoch = 10;
    next.next_epoch = [&epoch] { return epoch++; };
    result = RunJob(cluster, MakeJobInput(CornellBox(false), Coarse()), next);
    EXPECT_TRUE(result.has_value()) << result.error().message();
  }
}

TEST(JobTest, FinishGathersWhatThereIs) {
  LocalCluster cluster(1, 1);
  JobCallbacks callbacks;
  callbacks.finish = [] { return true; };
  SolveOptions options;
  options.accuracy = 0.001;
  const auto result = RunJob(cluster, MakeJobInput(CornellBox(false), options), callbacks);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_EQ(result->summary.end_reason, EndReason::kFinished);
  EXPECT_EQ(result->summary.rounds.size(), 1u);
  EXPECT_FALSE(result->patch.faces.empty());
}

TEST(JobTest, BudgetsEndTheRounds) {
  SolveOptions options;
  options.accuracy = 0.001;
  options.max_links = 3000;
  auto result = SolveInProcess(CornellBox(false), options, 2, 1);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_EQ(result->summary.end_reason, EndReason::kLinks);
  EXPECT_LE(result->summary.rounds.back().links, 3150u);
  EXPECT_GE(result->summary.rounds.back().links, 2700u);
  options.max_links = 0;
  options.max_rounds = 2;
  result = SolveInProcess(CornellBox(false), options, 2, 1);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_EQ(result->summary.end_reason, EndReason::kRounds);
}

TEST(JobTest, NobodyThereIsUnavailable) {
  JobRunner runner(MakeJobInput(CornellBox(false), Coarse()), {});
  const auto result = runner.Run();
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code(), StatusCode::kUnavailable);
}

TEST(JobTest, AStoreThatFailsFailsTheJob) {
  LocalCluster cluster(2, 1);
  JobCallbacks callbacks;
  callbacks.on_snapshot = [](const Snapshot&) {
    return Status(StatusCode::kResourceExhausted, "the disk is full");
  };
  const auto result = RunJob(cluster, MakeJobInput(CornellBox(false), Coarse()), callbacks);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().message(), "the disk is full");
}

TEST(JobTest, AWorkersErrorNamesTheWorker) {
  LocalCluster cluster(1, 1);
  JobInput input = MakeJobInput(CornellBox(false), Coarse());
  input.encoded_scene = std::make_shared<const std::string>("another scene");
  const auto result = RunJob(cluster, std::move(input));
  ASSERT_FALSE(result.has_value());
  EXPECT_NE(result.error().message().find("worker w1"), std::string::npos)
      << result.error().message();
  EXPECT_EQ(result.error().code(), StatusCode::kDataLoss);
}

TEST(JobTest, AJobThatLosesWorkerAfterWorkerGivesUp) {
  JobCallbacks callbacks;
  uint64_t id = 0;
  callbacks.workers = [&id] {
    auto [mine, others] = MakeLocalPorts();
    others->Close(Status(StatusCode::kUnavailable, "crashed"));
    return std::vector<WorkerSlot>{{++id, fmt::format("w{}", id), std::move(mine)}};
  };
  JobRunner runner(MakeJobInput(CornellBox(false), Coarse()), callbacks);
  const auto result = runner.Run();
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code(), StatusCode::kAborted);
  EXPECT_LT(id, 20u);
}

// A queue that holds a single message: whoever waits for room must never be waited for.
TEST(JobTest, NarrowQueuesSlowTheJobAndDoNotBlockIt) {
  LocalPortLimits narrow;
  narrow.messages = 1;
  narrow.bytes = 1;
  LocalCluster cluster(3, 1, narrow);
  SolveOptions options = Coarse();
  options.balance = BalanceStrategy::kRotate;
  const auto result = RunJob(cluster, MakeJobInput(CornellBox(false), options));
  EXPECT_TRUE(result.has_value()) << result.error().message();
}

TEST(JobTest, MoreWorkersThanTheSceneHasParts) {
  const auto result = SolveInProcess(FurnaceCube(0.5, 1.0), Coarse(), 10, 1);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  for (const PatchFace& face : result->patch.faces) {
    EXPECT_NEAR(face.radiosity[0], 2.0, 0.4);
  }
}

TEST(JobTest, GoesOnWhereTheGatherFindsWhatLinksMissed) {
  SolveOptions options;
  options.accuracy = 0.1;
  std::string bytes;
  uint64_t rays = 0;
  for (const int lost : {0, 1, 2}) {  // in the first gather, in the second
    SCOPED_TRACE(lost);
    LocalCluster cluster(lost == 0 ? 1 : 3, 1);
    JobCallbacks callbacks;
    std::vector<RoundSummary> told;
    callbacks.on_round = [&](const RoundSummary& row) { told.push_back(row); };
    callbacks.on_progress = [&](const JobProgress& progress) {
      if (progress.stage != JobProgress::Stage::kGathering || lost == 0) return;
      if (progress.round == 2U + static_cast<uint32_t>(lost)) cluster.Kill(1);
    };
    const auto result =
        RunJob(cluster, MakeJobInput(RoomWithStrip(0.005, 0.03), options), callbacks);
    ASSERT_TRUE(result.has_value()) << result.error().message();
    // The second round's links state less than 10 %, the gather more: it is told again.
    ASSERT_EQ(told.size(), 4U);
    EXPECT_EQ(told[2].round, 2U);
    EXPECT_LT(told[2].error_estimate, 0.1);
    EXPECT_EQ(told[2].error_estimate, told[1].error_estimate);
    EXPECT_EQ(told[1].error_unseen, 0);
    EXPECT_GT(std::hypot(told[2].error_estimate, told[2].error_unseen), 0.1);
    EXPECT_GT(told[2].rays, told[1].rays);
    const RoundSummary& last = result->summary.rounds.back();
    EXPECT_EQ(last.round, 3U);
    EXPECT_GT(last.error_unseen, 0);
    EXPECT_LE(last.error_estimate, 0.1);
    EXPECT_EQ(result->summary.end_reason, EndReason::kAccuracy);
    if (lost == 0) {
      bytes = BytesWithoutComments(result->patch);
      rays = result->summary.rays;
    }
    EXPECT_EQ(BytesWithoutComments(result->patch) == bytes, true);
    EXPECT_GE(result->summary.rays, rays);
  }
}

// A coordinator that comes back goes on from what it was told.
TEST(JobTest, GoesOnAfterTheGatherFromWhatIsStored) {
  SolveOptions options;
  options.accuracy = 0.1;
  std::string whole;
  for (const bool stops : {false, true}) {
    JobInput input = MakeJobInput(RoomWithStrip(0.005, 0.03), options);
    if (stops) {
      LocalCluster cluster(1, 1);
      JobCallbacks callbacks;
      bool cancel = false;
      callbacks.on_round = [&](const RoundSummary& row) {
        if (row.error_unseen > 0) {
          cancel = true;
          input.rounds.back() = row;
        } else {
          input.rounds.push_back(row);
        }
      };
      callbacks.on_snapshot = [&](const Snapshot& snapshot) {
        input.snapshots.push_back(snapshot);
        return Status();
      };
      callbacks.cancelled = [&] { return cancel; };
      const auto first =
          RunJob(cluster, MakeJobInput(RoomWithStrip(0.005, 0.03), options), callbacks);
      ASSERT_FALSE(first.has_value());
      ASSERT_EQ(input.rounds.size(), 2U);
    }
    LocalCluster cluster(1, 1);
    const auto result = RunJob(cluster, std::move(input));
    ASSERT_TRUE(result.has_value()) << result.error().message();
    EXPECT_EQ(result->summary.rounds.size(), 3U);
    const std::string bytes = BytesWithoutComments(result->patch);
    if (!stops) whole = bytes;
    EXPECT_EQ(bytes == whole, true);
  }
}

}  // namespace
}  // namespace isolux::testing
