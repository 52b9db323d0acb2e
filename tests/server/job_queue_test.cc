#include "server/job_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <future>

#include "server/upload.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

RoundSummary Round(uint32_t number) {
  RoundSummary round;
  round.round = number;
  round.links = 100 * number;
  round.worker_cpu_s = {0.5, 0.25};
  return round;
}

// A queue whose jobs do what the test says.
class JobQueueTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto folder = TemporaryDirectory::Make("isolux-test-");
    ASSERT_TRUE(folder.has_value());
    folder_ = std::make_unique<TemporaryDirectory>(std::move(*folder));
    encoded_ = Encode(testing::FurnaceCube(0.5, 1.0));
  }

  void Open(RunJob run, JobQueue::Limits limits = {}) {
    auto store = Store::Open(folder_->path() + "/data");
    ASSERT_TRUE(store.has_value()) << store.error().message();
    store_ = std::move(*store);
    queue_ = std::make_unique<JobQueue>(store_.get(), std::move(run), limits);
    ASSERT_TRUE(queue_->Start().ok());
  }
  void Close() {
    queue_.reset();
    store_.reset();
  }

  JobRequest Request(const std::string& id) const {
    JobRequest request;
    request.request_id = id;
    request.name = "cube.obj";
    request.total_bytes = encoded_.size();
    request.digest = HashOf(encoded_);
    request.polygons = 6;
    request.repairs.entries = {{"zero-area faces dropped", 2, "cube.obj:7"}};
    return request;
  }

  // Hands it in as a client would; the code of what went wrong.
  Result<JobQueue::Submitted> Submit(const JobRequest& request) {
    Upload upload(store_.get(), queue_.get());
    RETURN_IF_ERROR(upload.Begin(request));
    for (size_t offset = 0; offset < encoded_.size(); offset += 100) {
      const std::string chunk = encoded_.substr(offset, 100);
      RETURN_IF_ERROR(upload.Add(offset, chunk, Checksum(chunk)));
    }
    return upload.Finish();
  }

  JobInfo WaitForEnd(uint64_t job) {
    std::promise<void> ended;
    std::atomic<bool> told{false};
    std::shared_ptr<JobWatch> watch;
    JobInfo info;
    // Events are taken in the thread that brings them.
    std::mutex mutex;
    const auto look = [&] {
      std::lock_guard lock(mutex);
      while (watch != nullptr && !told) {
        auto event = watch->Next();
        if (!event || event->kind == JobEvent::Kind::kNone) return;
        if (event->kind != JobEvent::Kind::kEnd) continue;
        info = event->job;
        told = true;
        ended.set_value();
      }
    };
    auto made = queue_->Watch(job, 0, look);
    EXPECT_TRUE(made.has_value());
    {
      std::lock_guard lock(mutex);
      watch = *made;
    }
    look();
    ended.get_future().wait();
    (*made)->Close();
    return info;
  }

  std::unique_ptr<TemporaryDirectory> folder_;
  std::string encoded_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<JobQueue> queue_;
};

Result<JobOutcome> Succeed(const JobInfo&, const JobHooks& hooks) {
  JobOutcome outcome;
  for (uint32_t round = 1; round <= 3; ++round) {
    hooks.on_activity({"refining", round, 2, 0.5});
    hooks.on_round(Round(round));
    outcome.summary.rounds.push_back(Round(round));
  }
  outcome.summary.workers = 2;
  outcome.result = "the patch file";
  return outcome;
}

Result<JobOutcome> UntilCancelled(const JobInfo&, const JobHooks& hooks) {
  while (!hooks.cancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return Error(StatusCode::kCancelled, "cancelled");
}

TEST_F(JobQueueTest, AJobRunsToItsResult) {
  Open(Succeed);
  auto submitted = Submit(Request("a"));
  ASSERT_TRUE(submitted.has_value()) << submitted.error().message();
  EXPECT_EQ(submitted->job, 1u);
  EXPECT_FALSE(submitted->existing);
  const JobInfo job = WaitForEnd(1);
  EXPECT_EQ(job.state, JobState::kDone);
  EXPECT_EQ(job.summary.rounds.size(), 3u);
  EXPECT_EQ(job.summary.rounds[2].links, 300u);
  EXPECT_EQ(job.repairs.entries.at(0).example, "cube.obj:7");
  EXPECT_EQ(job.result_bytes, 14u);
  EXPECT_EQ(*store_->ReadResult(1, 4, 5), "patch");
  EXPECT_EQ(*store_->ReadResult(1, 10, 500), "file");
  EXPECT_EQ(*store_->ReadScene(job.digest), encoded_);
}

TEST_F(JobQueueTest, FailuresAreKeptWithTheirReason) {
  Open([](const JobInfo&, const JobHooks&) -> Result<JobOutcome> {
    return Error(StatusCode::kInternal, "the crowns differ");
  });
  ASSERT_TRUE(Submit(Request("a")).has_value());
  const JobInfo job = WaitForEnd(1);
  EXPECT_EQ(job.state, JobState::kFailed);
  EXPECT_EQ(job.error.code(), StatusCode::kInternal);
  EXPECT_EQ(job.error.message(), "the crowns differ");
}

TEST_F(JobQueueTest, ARequestIdGivesOneJob) {
  Open(Succeed);
  EXPECT_EQ(Submit(Request("a"))->job, 1u);
  auto again = Submit(Request("a"));
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->job, 1u);
  EXPECT_TRUE(again->existing);
  JobRequest other = Request("a");
  other.options.accuracy = 0.5;
  EXPECT_EQ(Submit(other).error().code(), StatusCode::kAlreadyExists);
  other = Request("a");
  other.digest[0] = other.digest[0] == '0' ? '1' : '0';
  EXPECT_EQ(Submit(other).error().code(), StatusCode::kAlreadyExists);
  EXPECT_EQ(Submit(Request("b"))->job, 2u);
}

TEST_F(JobQueueTest, JobsRunOneAfterAnother) {
  std::atomic<int> running{0}, most{0};
  Open([&](const JobInfo& job, const JobHooks& hooks) {
    most = std::max<int>(most, ++running);
    auto outcome = Succeed(job, hooks);
    --running;
    return outcome;
  });
  for (const char* id : {"a", "b", "c"}) ASSERT_TRUE(Submit(Request(id)).has_value());
  for (uint64_t job = 1; job <= 3; ++job) EXPECT_EQ(WaitForEnd(job).state, JobState::kDone);
  EXPECT_EQ(most, 1);
  const auto jobs = queue_->List(2, 0);
  ASSERT_EQ(jobs.size(), 2u);
  EXPECT_EQ(jobs[0].id, 3u);
  EXPECT_EQ(queue_->List(10, 3).size(), 2u);
  EXPECT_TRUE(queue_->List(10, 1).empty());
}

TEST_F(JobQueueTest, CancelsWhatRunsAndWhatWaits) {
  Open(UntilCancelled);
  for (const char* id : {"a", "b"}) ASSERT_TRUE(Submit(Request(id)).has_value());
  EXPECT_EQ(*queue_->Cancel(2), JobState::kCancelled);
  ASSERT_TRUE(queue_->Cancel(1).has_value());
  EXPECT_EQ(WaitForEnd(1).state, JobState::kCancelled);
  EXPECT_EQ(WaitForEnd(2).state, JobState::kCancelled);
  EXPECT_EQ(*queue_->Cancel(1), JobState::kCancelled) << "of an ended job: no error";
  EXPECT_EQ(queue_->Cancel(7).error().code(), StatusCode::kNotFound);
}

Result<JobOutcome> UntilFinished(const JobInfo& job, const JobHooks& hooks) {
  hooks.on_round(Round(1));
  while (!hooks.finish()) {
    if (hooks.cancelled()) return Error(StatusCode::kCancelled, "cancelled");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return Succeed(job, hooks);
}

TEST_F(JobQueueTest, FinishesWhatRunsAndNothingElse) {
  Open(UntilFinished);
  for (const char* id : {"a", "b"}) ASSERT_TRUE(Submit(Request(id)).has_value());
  const auto queued = queue_->Finish(2);
  ASSERT_FALSE(queued.has_value());
  EXPECT_EQ(queued.error().code(), StatusCode::kFailedPrecondition);
  EXPECT_NE(queued.error().message().find("cancel 2"), std::string::npos);
  while (queue_->Get(1)->summary.rounds.empty()) std::this_thread::yield();
  EXPECT_EQ(*queue_->Finish(1), JobState::kRunning);
  EXPECT_EQ(WaitForEnd(1).state, JobState::kDone);
  EXPECT_EQ(*queue_->Finish(1), JobState::kDone) << "of an ended job: no error";
  EXPECT_EQ(queue_->Finish(7).error().code(), StatusCode::kNotFound);
  ASSERT_TRUE(queue_->Cancel(2).has_value());
}

TEST_F(JobQueueTest, ARestartRemembersThatAJobIsToFinish) {
  std::promise<void> begun;
  Open([&](const JobInfo&, const JobHooks& hooks) -> Result<JobOutcome> {
    hooks.on_round(Round(1));
    begun.set_value();
    while (!hooks.cancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return Error(StatusCode::kCancelled, "the coordinator stops");
  });
  ASSERT_TRUE(Submit(Request("a")).has_value());
  begun.get_future().wait();
  ASSERT_TRUE(queue_->Finish(1).has_value());
  Close();
  Open(UntilFinished);
  EXPECT_EQ(WaitForEnd(1).state, JobState::kDone);
}

TEST_F(JobQueueTest, WatchingGoesOnWhereItBrokeOff) {
  Open(Succeed);
  ASSERT_TRUE(Submit(Request("a")).has_value());
  WaitForEnd(1);
  auto watch = queue_->Watch(1, 2, [] {});
  ASSERT_TRUE(watch.has_value());
  auto event = (*watch)->Next();
  ASSERT_TRUE(event.has_value());
  EXPECT_EQ(event->kind, JobEvent::Kind::kRound);
  EXPECT_EQ(event->sequence, 3u);
  EXPECT_EQ(event->round.round, 3u);
  event = (*watch)->Next();
  EXPECT_EQ(event->kind, JobEvent::Kind::kEnd);
  EXPECT_EQ(event->sequence, 4u);
  EXPECT_EQ((*watch)->Next()->kind, JobEvent::Kind::kNone);
  EXPECT_EQ(queue_->Watch(9, 0, [] {}).error().code(), StatusCode::kNotFound);
}

TEST_F(JobQueueTest, ARestartRunsWhatHadNotEnded) {
  std::promise<void> begun;
  Open([&](const JobInfo& job, const JobHooks& hooks) -> Result<JobOutcome> {
    if (job.id == 1) return Succeed(job, hooks);
    hooks.on_round(Round(1));
    EXPECT_TRUE(store_->SaveSnapshot(job.id, 1, "S1").ok());
    begun.set_value();
    return UntilCancelled(job, hooks);
  });
  for (const char* id : {"a", "b", "c"}) ASSERT_TRUE(Submit(Request(id)).has_value());
  begun.get_future().wait();
  Close();

  std::vector<uint64_t> ran;
  Open([&](const JobInfo& job, const JobHooks& hooks) {
    ran.push_back(job.id);
    if (job.id == 2) {
      EXPECT_EQ(job.summary.rounds.size(), 1u);
      EXPECT_EQ(store_->LoadSnapshots(2)->size(), 1u);
    }
    return Succeed(job, hooks);
  });
  EXPECT_EQ(WaitForEnd(2).summary.rounds.size(), 3u);
  WaitForEnd(3);
  EXPECT_EQ(WaitForEnd(1).state, JobState::kDone);
  EXPECT_EQ(ran, (std::vector<uint64_t>{2, 3}));
  EXPECT_TRUE(store_->LoadSnapshots(2)->empty()) << "kept only until the job ends";
  EXPECT_EQ(Submit(Request("a"))->job, 1u) << "request ids survive";
}

TEST_F(JobQueueTest, TwoCoordinatorsDoNotShareAFolder) {
  Open(Succeed);
  auto second = Store::Open(folder_->path() + "/data");
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().code(), StatusCode::kFailedPrecondition);
}

TEST_F(JobQueueTest, LimitsAreCheckedBeforeAnythingIsTaken) {
  JobQueue::Limits limits;
  limits.scene.polygons = 5;
  limits.unfinished_jobs = 1;
  Open(UntilCancelled, limits);
  EXPECT_EQ(Submit(Request("a")).error().code(), StatusCode::kResourceExhausted);
  EXPECT_NE(Submit(Request("a")).error().message().find("polygons"), std::string::npos);
  JobRequest lie = Request("a");
  lie.polygons = 5;
  EXPECT_FALSE(Submit(lie).has_value()) << "declared less than came";
  Close();
  limits.scene.polygons = 100;
  Open(UntilCancelled, limits);
  JobRequest large = Request("a");
  large.total_bytes = (1ULL << 30) + 1;
  EXPECT_EQ(Submit(large).error().code(), StatusCode::kResourceExhausted);
  large.total_bytes = ~0ULL;
  EXPECT_EQ(Submit(large).error().code(), StatusCode::kResourceExhausted);
  ASSERT_TRUE(Submit(Request("a")).has_value());
  EXPECT_EQ(Submit(Request("b")).error().code(), StatusCode::kResourceExhausted);
}

TEST_F(JobQueueTest, BadUploadsLeaveNothingBehind) {
  Open(Succeed);
  const auto code = [&](auto&& change) {
    Upload upload(store_.get(), queue_.get());
    return change(upload).code();
  };
  const std::string chunk = encoded_.substr(0, 100);
  EXPECT_EQ(code([&](Upload& u) { return u.Add(0, chunk, Checksum(chunk)); }),
            StatusCode::kInvalidArgument)
      << "no header";
  EXPECT_EQ(code([&](Upload& u) {
              EXPECT_TRUE(u.Begin(Request("a")).ok());
              return u.Begin(Request("a"));
            }),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(code([&](Upload& u) {
              EXPECT_TRUE(u.Begin(Request("a")).ok());
              return u.Add(0, chunk, Checksum(chunk) + 1);
            }),
            StatusCode::kDataLoss);
  EXPECT_EQ(code([&](Upload& u) {
              EXPECT_TRUE(u.Begin(Request("a")).ok());
              return u.Add(1, chunk, Checksum(chunk));
            }),
            StatusCode::kInvalidArgument)
      << "a gap";
  EXPECT_EQ(code([&](Upload& u) {
              EXPECT_TRUE(u.Begin(Request("a")).ok());
              EXPECT_TRUE(u.Add(0, chunk, Checksum(chunk)).ok());
              return u.Finish().error();
            }),
            StatusCode::kInvalidArgument)
      << "too short";
  JobRequest small = Request("a");
  small.total_bytes = 50;
  EXPECT_EQ(code([&](Upload& u) {
              EXPECT_TRUE(u.Begin(small).ok());
              return u.Add(0, chunk, Checksum(chunk));
            }),
            StatusCode::kInvalidArgument)
      << "more than declared";
  std::string damaged = encoded_;
  damaged[40] ^= 1;
  EXPECT_EQ(code([&](Upload& u) {
              EXPECT_TRUE(u.Begin(Request("a")).ok());
              EXPECT_TRUE(u.Add(0, damaged, Checksum(damaged)).ok());
              return u.Finish().error();
            }),
            StatusCode::kDataLoss)
      << "another scene than declared";
  for (const char* part : {"incoming", "scenes", "jobs"}) {
    EXPECT_TRUE(std::filesystem::is_empty(folder_->path() + "/data/" + part)) << part;
  }
  EXPECT_TRUE(queue_->List(10, 0).empty());
}

TEST_F(JobQueueTest, ASceneThatIsNoneIsRefusedWithItsDigestRight) {
  Open(Succeed);
  encoded_ = "this is not a scene";
  auto submitted = Submit(Request("a"));
  ASSERT_FALSE(submitted.has_value());
  EXPECT_TRUE(queue_->List(10, 0).empty());
}

TEST_F(JobQueueTest, BadRequestsAreRefused) {
  Open(Succeed);
  JobRequest request = Request("");
  EXPECT_EQ(Submit(request).error().code(), StatusCode::kInvalidArgument);
  request = Request("a/../b");
  EXPECT_EQ(Submit(request).error().code(), StatusCode::kInvalidArgument);
  request = Request("a");
  request.digest = "../../etc/passwd";
  EXPECT_EQ(Submit(request).error().code(), StatusCode::kInvalidArgument);
  request = Request("a");
  request.options.accuracy = -1;
  EXPECT_EQ(Submit(request).error().code(), StatusCode::kInvalidArgument);
  request = Request("a");
  request.name.assign(200, 'x');
  EXPECT_EQ(Submit(request).error().code(), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace isolux
