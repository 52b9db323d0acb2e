#include "worker/serve.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/rpc/local_port.h"
#include "common/rpc/protocol.h"
#include "server/partition.h"
#include "tests/support/scenes.h"
#include "worker/port_exchange.h"

namespace isolux {
namespace {

constexpr double kLong_s = 120;

// One worker, and the test in the place of the coordinator.
class ServeTest : public ::testing::Test {
 protected:
  ServeTest()
      : scene_(testing::CornellBox(false)), encoded_(Encode(scene_)), hash_(HashOf(encoded_)) {
    options_.threads = 1;
    options_.heartbeat_s = 0.02;
    state_ = std::make_unique<WorkerState>(options_);
    Connect();
  }
  ~ServeTest() override {
    port_->Close(Status(StatusCode::kUnavailable, "the test is over"));
    (void)Join();
  }

  void Connect() {
    auto [mine, workers] = MakeLocalPorts();
    port_ = std::move(mine);
    worker_port_ = std::move(workers);
    thread_ = std::thread([this] { ended_ = ServeJobs(*worker_port_, options_, *state_); });
  }
  Status Join() {
    if (thread_.joinable()) thread_.join();
    return ended_;
  }

  template <typename T>
  void Send(MessageKind kind, uint32_t epoch, const T& content) {
    ASSERT_TRUE(port_->Send(MakeMessage(kind, epoch, content)).ok());
  }
  // The next message that is not about being alive.
  Message Next() {
    while (true) {
      Result<Message> message = port_->Receive(kLong_s);
      EXPECT_TRUE(message.has_value()) << message.error().message();
      if (!message.has_value()) return {};
      if (message->kind != static_cast<uint32_t>(MessageKind::kProgress)) return *message;
    }
  }
  void Expect(MessageKind kind, uint32_t epoch) {
    const Message message = Next();
    EXPECT_STREQ(ToText(static_cast<MessageKind>(message.kind)), ToText(kind));
    EXPECT_EQ(message.epoch, epoch);
  }
  Status NextFailure() {
    const Message message = Next();
    EXPECT_STREQ(ToText(static_cast<MessageKind>(message.kind)), "Failed");
    const auto failed = DecodeMessage<Failed>(message.payload);
    return failed.has_value() ? failed->status : Status();
  }

  StartJob MakeStart() const {
    StartJob start;
    start.job = 1;
    start.scene_hash = hash_;
    start.assignment = Partition(Hierarchy(scene_), start.options, 1);
    return start;
  }
  void StartWithScene(uint32_t epoch) {
    Send(MessageKind::kStartJob, epoch, MakeStart());
    Expect(MessageKind::kNeedScene, epoch);
    Send(MessageKind::kSceneData, epoch, SceneData{hash_, encoded_});
    Expect(MessageKind::kStarted, epoch);
  }

  const Scene scene_;
  const std::string encoded_, hash_;
  WorkerOptions options_;
  std::unique_ptr<WorkerState> state_;
  std::unique_ptr<MessagePort> port_, worker_port_;
  Status ended_;
  std::thread thread_;
};

TEST_F(ServeTest, AsksForASceneOnce) {
  StartWithScene(1);
  Send(MessageKind::kEndJob, 1, EndJob{1});
  Send(MessageKind::kStartJob, 2, MakeStart());
  Expect(MessageKind::kStarted, 2);
  EXPECT_EQ(state_->jobs, 2u);
  EXPECT_EQ(state_->scenes.size(), 1u);
}

TEST_F(ServeTest, RefusesASceneThatIsNotTheOneNamed) {
  Send(MessageKind::kStartJob, 1, MakeStart());
  Expect(MessageKind::kNeedScene, 1);
  std::string damaged = encoded_;
  damaged[damaged.size() / 2] ^= 1;
  Send(MessageKind::kSceneData, 1, SceneData{hash_, damaged});
  EXPECT_EQ(NextFailure().code(), StatusCode::kDataLoss);
  StartWithScene(2);  // and goes on
}

TEST_F(ServeTest, TellsWhatIsWrongWithACommand) {
  ASSERT_TRUE(port_->Send({static_cast<uint32_t>(MessageKind::kStartJob), 1, "garbage"}).ok());
  EXPECT_FALSE(NextFailure().ok());
  StartWithScene(2);
  ASSERT_TRUE(port_->Send({9999, 2, {}}).ok());
  EXPECT_EQ(NextFailure().code(), StatusCode::kInternal);
  StartJob start = MakeStart();
  start.assignment.cut.pop_back();  // covers not all
  start.assignment.home.pop_back();
  Send(MessageKind::kStartJob, 3, start);
  EXPECT_FALSE(NextFailure().ok());
}

TEST_F(ServeTest, CommandsOfAFailedJobAreIgnored) {
  ASSERT_TRUE(port_->Send({static_cast<uint32_t>(MessageKind::kStartJob), 1, "garbage"}).ok());
  EXPECT_FALSE(NextFailure().ok());
  Send(MessageKind::kRound, 1, RoundCommand{1, 1.0, 0.1, false});
  StartWithScene(2);
}

TEST_F(ServeTest, RunsARoundAndWaitsInItsCollectives) {
  StartWithScene(1);
  Send(MessageKind::kRound, 1, RoundCommand{1, 0.5, 0.1, false});
  const Message first = Next();
  EXPECT_EQ(first.epoch, 1u);
  EXPECT_TRUE(first.kind == static_cast<uint32_t>(MessageKind::kReduce) ||
              first.kind == static_cast<uint32_t>(MessageKind::kSubscribe));
}

TEST_F(ServeTest, CancelEndsARoundAtOnce) {
  StartWithScene(1);
  Send(MessageKind::kRound, 1, RoundCommand{1, 0.5, 0.1, false});
  (void)Next();  // now it waits for the others
  Send(MessageKind::kCancelJob, 1, EndJob{1});
  Send(MessageKind::kStartJob, 2, MakeStart());
  Expect(MessageKind::kStarted, 2);  // and no Failed before
}

TEST_F(ServeTest, ANewerEpochSupersedesWhatIsUnderWay) {
  StartWithScene(5);
  Send(MessageKind::kRound, 5, RoundCommand{1, 0.5, 0.1, false});
  (void)Next();
  Send(MessageKind::kStartJob, 6, MakeStart());
  Expect(MessageKind::kStarted, 6);
}

TEST_F(ServeTest, MessagesOfAnOldEpochAreDroppedAndCounted) {
  StartWithScene(5);
  Send(MessageKind::kRound, 4, RoundCommand{1, 0.5, 0.1, false});
  Send(MessageKind::kStartJob, 3, MakeStart());
  Send(MessageKind::kStartJob, 6, MakeStart());
  Expect(MessageKind::kStarted, 6);
  EXPECT_EQ(state_->stale_messages, 2u);
}

TEST_F(ServeTest, SaysThatItIsAliveOnlyDuringAJob) {
  EXPECT_EQ(port_->Receive(0.1).error().code(), StatusCode::kDeadlineExceeded);
  StartWithScene(1);
  const Result<Message> alive = port_->Receive(kLong_s);
  ASSERT_TRUE(alive.has_value());
  EXPECT_EQ(alive->kind, static_cast<uint32_t>(MessageKind::kProgress));
  const auto progress = DecodeMessage<Progress>(alive->payload);
  EXPECT_EQ(progress->job, 1u);
}

TEST_F(ServeTest, AnIdleWorkerLeavesAtOnce) {
  state_->drain = true;
  EXPECT_TRUE(Join().ok());
  EXPECT_EQ(port_->Receive(kLong_s).error().code(), StatusCode::kUnavailable);
}

TEST_F(ServeTest, AWorkerWithAJobAsksAndStaysUntilReleased) {
  StartWithScene(1);
  state_->drain = true;
  Expect(MessageKind::kDrain, 1);
  ASSERT_TRUE(port_->Send({static_cast<uint32_t>(MessageKind::kRelease), 1, {}}).ok());
  EXPECT_TRUE(Join().ok());
}

TEST_F(ServeTest, AWorkerWithAJobLeavesWhenItEnds) {
  StartWithScene(1);
  state_->drain = true;
  Expect(MessageKind::kDrain, 1);
  Send(MessageKind::kEndJob, 1, EndJob{1});
  EXPECT_TRUE(Join().ok());
}

TEST_F(ServeTest, ALostCoordinatorEndsTheLoopWithItsReason) {
  StartWithScene(1);
  Send(MessageKind::kRound, 1, RoundCommand{1, 0.5, 0.1, false});
  (void)Next();
  port_->Close(Status(StatusCode::kUnavailable, "the cable is out"));
  const Status status = Join();
  EXPECT_EQ(status.code(), StatusCode::kUnavailable);
  EXPECT_EQ(status.message(), "the cable is out");
  // It comes back with its scene.
  Connect();
  Send(MessageKind::kStartJob, 7, MakeStart());
  Expect(MessageKind::kStarted, 7);
}

TEST_F(ServeTest, AnAnswerOfAnotherKindFailsTheJob) {
  StartWithScene(1);
  Send(MessageKind::kRound, 1, RoundCommand{1, 0.5, 0.1, false});
  (void)Next();
  Send(MessageKind::kSumsReply, 1, SumsReply{});
  EXPECT_EQ(NextFailure().code(), StatusCode::kInternal);
}

TEST(SceneCacheTest, KeepsTheMostRecentWithinItsLimit) {
  SceneCache cache(100);
  const auto scene = std::make_shared<const Scene>();
  cache.Insert("a", scene, 40);
  cache.Insert("b", scene, 40);
  EXPECT_NE(cache.Find("a"), nullptr);
  cache.Insert("c", scene, 40);  // b was not used for longest
  EXPECT_EQ(cache.Find("b"), nullptr);
  EXPECT_NE(cache.Find("a"), nullptr);
  EXPECT_EQ(cache.bytes(), 80u);
  cache.Insert("large", scene, 500);  // alone, but kept
  EXPECT_EQ(cache.size(), 1u);
  EXPECT_NE(cache.Find("large"), nullptr);
}

}  // namespace
}  // namespace isolux
