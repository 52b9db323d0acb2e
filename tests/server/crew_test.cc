#include "server/crew.h"

#include <gtest/gtest.h>

#include "common/rpc/local_port.h"

namespace isolux {
namespace {

// A crew whose workers are played by the test: what they say is queued before it is collected.
class CrewTest : public ::testing::Test {
 protected:
  Crew MakeCrew(int workers, JobLimits limits = {}, std::function<bool()> cancelled = {}) {
    std::vector<WorkerSlot> slots;
    for (int i = 0; i < workers; ++i) {
      auto [coordinators, workers_end] = MakeLocalPorts();
      far_.push_back(std::move(workers_end));
      slots.push_back(
          {static_cast<uint64_t>(i + 1), fmt::format("w{}", i + 1), std::move(coordinators)});
    }
    return Crew(std::move(slots), kEpoch, limits, &traffic_, std::move(cancelled));
  }
  template <typename T>
  void Say(size_t worker, MessageKind kind, const T& content, uint32_t epoch = kEpoch) {
    ASSERT_TRUE(far_[worker]->Send(MakeMessage(kind, epoch, content)).ok());
  }

  static constexpr uint32_t kEpoch = 4;
  std::vector<std::unique_ptr<MessagePort>> far_;
  Traffic traffic_;
};

TEST_F(CrewTest, CollectsOneMessageOfEach) {
  Crew crew = MakeCrew(3);
  for (size_t w = 0; w < 3; ++w) Say(w, MessageKind::kReplayed, Replayed{static_cast<uint32_t>(w)});
  const auto messages = crew.CollectAll(MessageKind::kReplayed);
  ASSERT_TRUE(messages.has_value());
  for (uint32_t w = 0; w < 3; ++w) {
    EXPECT_EQ(DecodeMessage<Replayed>((*messages)[w]->payload)->round, w);
  }
  EXPECT_EQ(traffic_.Total(Phase::kReport).messages_in, 3u);
}

TEST_F(CrewTest, SignsOfLifeAndOldEpochsAreNoAnswers) {
  Crew crew = MakeCrew(1);
  Say(0, MessageKind::kProgress, Progress{});
  Say(0, MessageKind::kReplayed, Replayed{1}, kEpoch - 1);
  ASSERT_TRUE(far_[0]->Send({static_cast<uint32_t>(MessageKind::kDrain), kEpoch, {}}).ok());
  Say(0, MessageKind::kReplayed, Replayed{2});
  const auto messages = crew.CollectAll(MessageKind::kReplayed);
  ASSERT_TRUE(messages.has_value());
  EXPECT_EQ(DecodeMessage<Replayed>((*messages)[0]->payload)->round, 2u);
  EXPECT_TRUE(crew.draining(0));
  EXPECT_EQ(traffic_.stale_messages, 1u);
}

TEST_F(CrewTest, WorkersThatSayDifferentThingsFailTheJob) {
  Crew crew = MakeCrew(2);
  Say(0, MessageKind::kReplayed, Replayed{1});
  Say(1, MessageKind::kSums, Sums{});
  const auto messages = crew.CollectAll(MessageKind::kReplayed);
  ASSERT_FALSE(messages.has_value());
  EXPECT_EQ(messages.error().code(), StatusCode::kInternal);
  EXPECT_FALSE(crew.loss());
}

TEST_F(CrewTest, AWorkersErrorIsTheJobs) {
  Crew crew = MakeCrew(2);
  Say(0, MessageKind::kReplayed, Replayed{1});
  Say(1, MessageKind::kFailed, Failed{Status(StatusCode::kUnavailable, "out of paper")});
  const auto messages = crew.CollectAll(MessageKind::kReplayed);
  ASSERT_FALSE(messages.has_value());
  EXPECT_EQ(messages.error().message(), "worker w2: out of paper");
  EXPECT_EQ(messages.error().code(),
            StatusCode::kInternal);  // it is not the worker that is missing
  EXPECT_FALSE(crew.loss());
}

TEST_F(CrewTest, AClosedPortIsALoss) {
  Crew crew = MakeCrew(2);
  far_[1]->Close(Status(StatusCode::kUnavailable, "killed"));
  Say(0, MessageKind::kReplayed, Replayed{1});
  const auto messages = crew.CollectAll(MessageKind::kReplayed);
  ASSERT_FALSE(messages.has_value());
  EXPECT_EQ(messages.error().code(), StatusCode::kUnavailable);
  ASSERT_TRUE(crew.loss());
  EXPECT_EQ(crew.loss()->worker, 1u);
}

TEST_F(CrewTest, SilenceBeyondTheLeaseIsALoss) {
  JobLimits limits;
  limits.lease_s = 0.05;
  Crew crew = MakeCrew(1, limits);
  const auto messages = crew.CollectAll(MessageKind::kReplayed);
  ASSERT_FALSE(messages.has_value());
  ASSERT_TRUE(crew.loss());
  EXPECT_EQ(crew.loss()->why.code(), StatusCode::kUnavailable);
}

TEST_F(CrewTest, LifeWithoutAnAnswerHasALimitToo) {
  JobLimits limits;
  limits.step_limit_s = 0.05;
  Crew crew = MakeCrew(1, limits);
  Say(0, MessageKind::kProgress, Progress{});
  const auto messages = crew.CollectAll(MessageKind::kReplayed);
  ASSERT_FALSE(messages.has_value());
  EXPECT_TRUE(crew.loss());
}

TEST_F(CrewTest, WaitingEndsWhenTheJobIsCancelled) {
  int asked = 0;
  Crew crew = MakeCrew(1, {}, [&asked] { return ++asked > 2; });
  const auto messages = crew.CollectAll(MessageKind::kReplayed);
  ASSERT_FALSE(messages.has_value());
  EXPECT_EQ(messages.error().code(), StatusCode::kCancelled);
}

TEST_F(CrewTest, WhoIsReleasedIsNeitherSentToNorWaitedFor) {
  Crew crew = MakeCrew(2);
  crew.Release(0);
  EXPECT_EQ(crew.present_count(), 1u);
  EXPECT_EQ(far_[0]->Receive(60)->kind, static_cast<uint32_t>(MessageKind::kRelease));
  ASSERT_TRUE(crew.SendAll(MessageKind::kEndJob, EndJob{1}).ok());
  EXPECT_FALSE(far_[0]->Receive(0).has_value());
  EXPECT_TRUE(far_[1]->Receive(60).has_value());
  Say(1, MessageKind::kReplayed, Replayed{1});
  EXPECT_TRUE(crew.CollectAll(MessageKind::kReplayed).has_value());
}

}  // namespace
}  // namespace isolux
