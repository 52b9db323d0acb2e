// The clients' calls over gRPC on loopback, with jobs that only pretend.
#include "server/coordinator_service.h"

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <thread>

#include "common/rpc/channel.h"
#include "common/rpc/convert.h"
#include "common/rpc/convert_options.h"
#include "common/util/digest.h"
#include "isolux/v1/job_service.grpc.pb.h"
#include "server/grpc_server.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

using grpc::StatusCode;

constexpr double kLong = 60;

class CoordinatorServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto folder = TemporaryDirectory::Make("isolux-test-");
    ASSERT_TRUE(folder.has_value());
    folder_ = std::make_unique<TemporaryDirectory>(std::move(*folder));
    store_ = std::move(*Store::Open(folder_->path()));
    queue_ = std::make_unique<JobQueue>(
        store_.get(), [this](const JobInfo& job, const JobHooks& hooks) { return Run(job, hooks); },
        JobQueue::Limits());
    ASSERT_TRUE(queue_->Start().ok());
    sessions_ = std::make_unique<WorkerSessions>(WorkerSessions::Options());
    CoordinatorService::Options options;
    options.idle_upload_s = 0.5;
    service_ = std::make_unique<CoordinatorService>(
        queue_.get(), store_.get(), sessions_.get(),
        [](const JobInfo& job) -> Result<std::string> {
          if (job.name != "cube.obj") return Error(isolux::StatusCode::kNotFound, "gone");
          return std::string(300'000, 'n');
        },
        options);
    GrpcServerOptions listen;
    listen.listen = "127.0.0.1:0";
    auto server = GrpcServer::Start(listen, {service_->service(), sessions_->service()});
    ASSERT_TRUE(server.has_value()) << server.error().message();
    server_ = std::move(*server);
    ChannelOptions channel;
    channel.server = server_->address();
    stub_ = v1::JobService::NewStub(MakeChannel(channel));
    encoded_ = Encode(testing::FurnaceCube(0.5, 1.0));
  }

  void TearDown() override {
    queue_->Stop();
    sessions_->Shutdown();
    server_->Shutdown(5);
    server_.reset();
    service_.reset();
  }

  // Jobs wait for `go_`, tell two rounds, and give a result of 600,000 bytes.
  Result<JobOutcome> Run(const JobInfo&, const JobHooks& hooks) {
    while (!go_ && !hooks.cancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (hooks.cancelled()) return Error(isolux::StatusCode::kCancelled, "cancelled");
    JobOutcome outcome;
    for (uint32_t number = 1; number <= 2; ++number) {
      RoundSummary round;
      round.round = number;
      hooks.on_round(round);
      outcome.summary.rounds.push_back(round);
    }
    for (int i = 0; i < 100'000; ++i) outcome.result += fmt::format("{:6}", i);
    return outcome;
  }

  v1::SubmitJobRequest Header(const std::string& id) const {
    v1::SubmitJobRequest request;
    v1::SubmitJobHeader* header = request.mutable_header();
    header->set_request_id(id);
    header->set_name("cube.obj");
    *header->mutable_options() = ToProto(SolveOptions());
    header->set_total_bytes(encoded_.size());
    header->set_digest(HashOf(encoded_));
    header->set_polygons(6);
    return request;
  }
  v1::SubmitJobRequest Chunk() const {
    v1::SubmitJobRequest request;
    request.mutable_chunk()->set_data(encoded_);
    request.mutable_chunk()->set_checksum(Checksum(encoded_));
    return request;
  }

  grpc::Status Submit(const std::vector<v1::SubmitJobRequest>& parts,
                      v1::SubmitJobResponse* response, bool done = true) {
    grpc::ClientContext context;
    SetDeadline(context, kLong);
    auto stream = stub_->SubmitJob(&context, response);
    for (const auto& part : parts) {
      if (!stream->Write(part)) break;
    }
    if (done) stream->WritesDone();
    return stream->Finish();
  }
  uint64_t SubmitCube(const std::string& id) {
    v1::SubmitJobResponse response;
    const grpc::Status status = Submit({Header(id), Chunk()}, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.job();
  }

  struct Watched {
    std::vector<v1::WatchJobResponse> events;
    grpc::Status status;
  };
  Watched Watch(uint64_t job, uint64_t after) {
    grpc::ClientContext context;
    SetDeadline(context, kLong);
    v1::WatchJobRequest request;
    request.set_job(job);
    request.set_after_sequence(after);
    auto stream = stub_->WatchJob(&context, request);
    Watched watched;
    v1::WatchJobResponse event;
    while (stream->Read(&event)) watched.events.push_back(event);
    watched.status = stream->Finish();
    return watched;
  }

  grpc::Status Fetch(uint64_t job, uint64_t offset, std::string* bytes, std::string* digest,
                     bool latest = false) {
    grpc::ClientContext context;
    SetDeadline(context, kLong);
    v1::FetchResultRequest request;
    request.set_job(job);
    request.set_offset(offset);
    request.set_latest(latest);
    auto stream = stub_->FetchResult(&context, request);
    v1::FetchResultResponse part;
    while (stream->Read(&part)) {
      EXPECT_EQ(part.offset(), offset + bytes->size());
      EXPECT_EQ(part.checksum(), Checksum(part.data()));
      if (!part.digest().empty()) *digest = part.digest();
      *bytes += part.data();
    }
    return stream->Finish();
  }

  std::unique_ptr<TemporaryDirectory> folder_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<WorkerSessions> sessions_;
  std::unique_ptr<CoordinatorService> service_;
  std::unique_ptr<GrpcServer> server_;
  std::unique_ptr<v1::JobService::Stub> stub_;
  std::string encoded_;
  std::atomic<bool> go_{true};
};

TEST_F(CoordinatorServiceTest, AJobIsSubmittedWatchedAndFetched) {
  const uint64_t job = SubmitCube("a");
  const Watched watched = Watch(job, 0);
  ASSERT_TRUE(watched.status.ok()) << watched.status.error_message();
  std::vector<v1::WatchJobResponse> kept;
  for (const auto& event : watched.events) {
    if (!event.has_progress()) kept.push_back(event);
  }
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_EQ(kept[0].round().round(), 1u);
  EXPECT_EQ(kept[1].sequence(), 2u);
  EXPECT_EQ(kept[2].ended().state(), v1::JOB_STATE_DONE);

  std::string bytes, digest;
  ASSERT_TRUE(Fetch(job, 0, &bytes, &digest).ok());
  EXPECT_EQ(bytes.size(), 600'000u);
  EXPECT_EQ(HashOf(bytes), digest);
  std::string rest;
  ASSERT_TRUE(Fetch(job, 599'990, &rest, &digest).ok());
  EXPECT_EQ(rest, bytes.substr(599'990));
  EXPECT_EQ(Fetch(job, 600'001, &rest, &digest).error_code(), StatusCode::OUT_OF_RANGE);

  const Watched again = Watch(job, 2);
  ASSERT_EQ(again.events.size(), 1u);
  EXPECT_TRUE(again.events[0].has_ended());
}

TEST_F(CoordinatorServiceTest, TheSameRequestGivesTheSameJob) {
  const uint64_t job = SubmitCube("a");
  v1::SubmitJobResponse response;
  ASSERT_TRUE(Submit({Header("a"), Chunk()}, &response).ok());
  EXPECT_EQ(response.job(), job);
  EXPECT_TRUE(response.existing());
  v1::SubmitJobRequest other = Header("a");
  other.mutable_header()->mutable_options()->set_accuracy(0.3);
  EXPECT_EQ(Submit({other}, &response).error_code(), StatusCode::ALREADY_EXISTS);
}

TEST_F(CoordinatorServiceTest, BadUploadsAreRefusedByTheRightCode) {
  v1::SubmitJobResponse response;
  EXPECT_EQ(Submit({}, &response).error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Submit({Chunk()}, &response).error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Submit({Header("a")}, &response).error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Submit({v1::SubmitJobRequest()}, &response).error_code(), StatusCode::INVALID_ARGUMENT);
  v1::SubmitJobRequest wrong = Chunk();
  wrong.mutable_chunk()->set_checksum(1);
  EXPECT_EQ(Submit({Header("a"), wrong}, &response).error_code(), StatusCode::DATA_LOSS);
  v1::SubmitJobRequest large = Header("a");
  large.mutable_header()->set_total_bytes(1ULL << 40);
  EXPECT_EQ(Submit({large}, &response).error_code(), StatusCode::RESOURCE_EXHAUSTED);
  v1::SubmitJobRequest option = Header("a");
  option.mutable_header()->mutable_options()->set_accuracy(0);
  EXPECT_EQ(Submit({option}, &response).error_code(), StatusCode::INVALID_ARGUMENT);
  v1::SubmitJobRequest huge = Chunk();
  huge.mutable_chunk()->set_data(std::string(5 << 20, 'x'));
  EXPECT_EQ(Submit({Header("a"), huge}, &response).error_code(), StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_TRUE(queue_->List(10, 0).empty());
}

TEST_F(CoordinatorServiceTest, AnUploadThatStallsIsEnded) {
  v1::SubmitJobResponse response;
  EXPECT_EQ(Submit({Header("a")}, &response, /*done=*/false).error_code(), StatusCode::CANCELLED);
}

TEST_F(CoordinatorServiceTest, UnknownJobsAreNotFound) {
  grpc::ClientContext get_context, cancel_context;
  v1::GetJobRequest get;
  get.set_job(9);
  v1::GetJobResponse got;
  EXPECT_EQ(stub_->GetJob(&get_context, get, &got).error_code(), StatusCode::NOT_FOUND);
  v1::CancelJobRequest cancel;
  cancel.set_job(9);
  v1::CancelJobResponse cancelled;
  EXPECT_EQ(stub_->CancelJob(&cancel_context, cancel, &cancelled).error_code(),
            StatusCode::NOT_FOUND);
  EXPECT_EQ(Watch(9, 0).status.error_code(), StatusCode::NOT_FOUND);
  std::string bytes, digest;
  EXPECT_EQ(Fetch(9, 0, &bytes, &digest).error_code(), StatusCode::NOT_FOUND);
}

TEST_F(CoordinatorServiceTest, ARunningJobIsListedCancelledAndHasNoResult) {
  go_ = false;
  const uint64_t job = SubmitCube("a");
  std::string bytes, digest;
  EXPECT_EQ(Fetch(job, 0, &bytes, &digest).error_code(), StatusCode::FAILED_PRECONDITION);
  v1::CancelJobRequest request;
  request.set_job(job);
  v1::CancelJobResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(stub_->CancelJob(&context, request, &response).ok());
  const Watched watched = Watch(job, 0);
  ASSERT_TRUE(watched.status.ok());
  EXPECT_EQ(watched.events.back().ended().state(), v1::JOB_STATE_CANCELLED);
  grpc::ClientContext list_context;
  v1::ListJobsResponse jobs;
  ASSERT_TRUE(stub_->ListJobs(&list_context, {}, &jobs).ok());
  ASSERT_EQ(jobs.jobs_size(), 1);
  EXPECT_EQ(jobs.jobs(0).state(), v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(jobs.jobs(0).name(), "cube.obj");
}

TEST_F(CoordinatorServiceTest, WhatIsNewestIsFetchedWhileAJobRunsAndItsResultAfterwards) {
  go_ = false;
  const uint64_t job = SubmitCube("a");
  std::string bytes, digest;
  ASSERT_TRUE(Fetch(job, 0, &bytes, &digest, /*latest=*/true).ok());
  EXPECT_EQ(bytes, std::string(300'000, 'n'));
  EXPECT_EQ(HashOf(bytes), digest);
  std::string none;
  EXPECT_EQ(Fetch(job, 5, &none, &digest, true).error_code(), StatusCode::INVALID_ARGUMENT);
  go_ = true;
  ASSERT_TRUE(Watch(job, 0).status.ok());
  bytes.clear();
  ASSERT_TRUE(Fetch(job, 0, &bytes, &digest, true).ok());
  EXPECT_EQ(bytes.size(), 600'000u);
  EXPECT_EQ(Fetch(9, 0, &none, &digest, true).error_code(), StatusCode::NOT_FOUND);
}

TEST_F(CoordinatorServiceTest, StoppingEndsAWatchAsUnavailable) {
  go_ = false;
  const uint64_t job = SubmitCube("a");
  std::thread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    queue_->Stop();
  });
  EXPECT_EQ(Watch(job, 0).status.error_code(), StatusCode::UNAVAILABLE);
  stopper.join();
  v1::SubmitJobResponse response;
  EXPECT_EQ(Submit({Header("b"), Chunk()}, &response).error_code(), StatusCode::UNAVAILABLE);
}

TEST_F(CoordinatorServiceTest, AWatcherThatLeavesIsForgotten) {
  go_ = false;
  const uint64_t job = SubmitCube("a");
  for (int i = 0; i < 300; ++i) {
    grpc::ClientContext context;
    v1::WatchJobRequest request;
    request.set_job(job);
    auto stream = stub_->WatchJob(&context, request);
    v1::WatchJobResponse event;
    if (i % 3 == 0) stream->Read(&event);
    context.TryCancel();
    (void)stream->Finish();
  }
  go_ = true;
  EXPECT_TRUE(Watch(job, 0).status.ok());
}

TEST_F(CoordinatorServiceTest, CompressedMessagesAreNotUnpacked) {
  v1::SubmitJobResponse response;
  grpc::ClientContext context;
  context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  auto stream = stub_->SubmitJob(&context, &response);
  stream->Write(Header("a"));
  stream->WritesDone();
  EXPECT_EQ(stream->Finish().error_code(), StatusCode::UNIMPLEMENTED);
}

TEST_F(CoordinatorServiceTest, APortHasOneServer) {
  GrpcServerOptions options;
  options.listen = server_->address();
  auto second = GrpcServer::Start(options, {});
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().code(), isolux::StatusCode::kFailedPrecondition);
  EXPECT_NE(second.error().message().find("--listen"), std::string::npos);
}

TEST(GrpcServerTest, AnAddressForOthersNeedsToBeAllowed) {
  GrpcServerOptions options;
  options.listen = "0.0.0.0:0";
  auto server = GrpcServer::Start(options, {});
  ASSERT_FALSE(server.has_value());
  EXPECT_EQ(server.error().code(), isolux::StatusCode::kInvalidArgument);
  EXPECT_NE(server.error().message().find("--insecure"), std::string::npos);
  for (const char* bad : {"", "7400", "localhost:", "127.0.0.1:70000", "127.0.0.1:x", ":1"}) {
    options.listen = bad;
    EXPECT_EQ(GrpcServer::Start(options, {}).error().code(), isolux::StatusCode::kInvalidArgument)
        << bad;
  }
}

}  // namespace
}  // namespace isolux
