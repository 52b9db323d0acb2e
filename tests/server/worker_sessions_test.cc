// Worker sessions over gRPC on loopback, both ends in this process.
#include "server/worker_sessions.h"

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <thread>

#include "common/rpc/channel.h"
#include "common/util/build_info.h"
#include "isolux/v1/worker_service.grpc.pb.h"
#include "worker/session.h"

namespace isolux {
namespace {

constexpr double kLong = 60;

class WorkerSessionsTest : public ::testing::Test {
 protected:
  void Start(WorkerSessions::Options options = {}) {
    sessions_ = std::make_unique<WorkerSessions>(options);
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(sessions_->service());
    server_ = builder.BuildAndStart();
    channel_.server = "127.0.0.1:" + std::to_string(port_);
  }
  void TearDown() override {
    if (sessions_ == nullptr) return;
    sessions_->Shutdown();
    server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(5));
    server_.reset();
  }
  std::unique_ptr<WorkerSession> Connect(const std::string& name) {
    auto session = WorkerSession::Connect(channel_, {name, 2}, kLong);
    EXPECT_TRUE(session.has_value()) << session.error().message();
    return session ? std::move(*session) : nullptr;
  }

  int port_ = 0;
  ChannelOptions channel_;
  std::unique_ptr<WorkerSessions> sessions_;
  std::unique_ptr<grpc::Server> server_;
};

TEST_F(WorkerSessionsTest, MessagesTravelBothWays) {
  Start();
  EXPECT_FALSE(sessions_->WaitForWorker(0.001));
  auto worker = Connect("anna");
  ASSERT_TRUE(sessions_->WaitForWorker(kLong));
  const ConnectedWorker connected = sessions_->Connected().at(0);
  EXPECT_EQ(connected.name, "anna");
  EXPECT_EQ(connected.threads, 2u);
  EXPECT_EQ(connected.id, worker->id());
  for (const size_t size : {0, 10, 3'000'000, 40'000'000}) {
    std::thread echo([&] {
      auto message = worker->port().Receive(kLong);
      ASSERT_TRUE(message.has_value()) << message.error().message();
      message->epoch += 1;
      EXPECT_TRUE(worker->port().Send(std::move(*message)).ok());
    });
    const std::string payload(size, 'z');
    EXPECT_TRUE(connected.port->Send({7, 5, payload}).ok());
    auto answer = connected.port->Receive(kLong);
    echo.join();
    ASSERT_TRUE(answer.has_value()) << answer.error().message();
    EXPECT_EQ(answer->kind, 7u);
    EXPECT_EQ(answer->epoch, 6u);
    EXPECT_EQ(answer->payload, payload);
  }
}

TEST_F(WorkerSessionsTest, AWorkerThatLeavesIsGoneAfterItsLastMessage) {
  Start();
  auto worker = Connect("anna");
  ASSERT_TRUE(sessions_->WaitForWorker(kLong));
  const ConnectedWorker connected = sessions_->Connected().at(0);
  ASSERT_TRUE(worker->port().Send({3, 1, "last words"}).ok());
  worker->port().Close(Status());
  worker.reset();
  auto message = connected.port->Receive(kLong);
  ASSERT_TRUE(message.has_value()) << message.error().message();
  EXPECT_EQ(message->payload, "last words");
  EXPECT_EQ(connected.port->Receive(kLong).error().code(), StatusCode::kUnavailable);
  EXPECT_FALSE(connected.port->Send({}).ok());
  EXPECT_TRUE(sessions_->Connected().empty());
}

TEST_F(WorkerSessionsTest, ReleaseAndDropEndTheWorkersStream) {
  Start();
  auto first = Connect("first");
  auto second = Connect("second");
  sessions_->Release(first->id());
  sessions_->Drop(second->id(), MakeStatus(StatusCode::kUnavailable, "test"));
  EXPECT_EQ(first->port().Receive(kLong).error().code(), StatusCode::kUnavailable);
  EXPECT_EQ(second->port().Receive(kLong).error().code(), StatusCode::kUnavailable);
  EXPECT_TRUE(sessions_->Connected().empty());
}

TEST_F(WorkerSessionsTest, ASilentWorkerIsGivenUp) {
  WorkerSessions::Options options;
  options.lease_s = 1;
  options.heartbeat_s = 1000;  // it is told to be silent
  Start(options);
  auto worker = Connect("quiet");
  ASSERT_NE(worker, nullptr);
  auto message = worker->port().Receive(kLong);
  ASSERT_FALSE(message.has_value());
  EXPECT_EQ(message.error().code(), StatusCode::kUnavailable);
  EXPECT_TRUE(sessions_->Connected().empty());
}

TEST_F(WorkerSessionsTest, AWorkerThatBeatsIsKeptHoweverLittleItSays) {
  WorkerSessions::Options options;
  options.lease_s = 1;
  options.heartbeat_s = 0.05;
  Start(options);
  auto worker = Connect("steady");
  ASSERT_NE(worker, nullptr);
  EXPECT_EQ(worker->port().Receive(2).error().code(), StatusCode::kDeadlineExceeded);
  EXPECT_EQ(sessions_->Connected().size(), 1u);
}

TEST_F(WorkerSessionsTest, OnlySoManyWorkers) {
  WorkerSessions::Options options;
  options.max_workers = 1;
  Start(options);
  auto worker = Connect("one");
  ASSERT_NE(worker, nullptr);
  auto second = WorkerSession::Connect(channel_, {"two", 1}, kLong);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().code(), StatusCode::kResourceExhausted) << second.error().message();
}

TEST_F(WorkerSessionsTest, ANewWorkerIsRefusedWhileStopping) {
  Start();
  sessions_->Shutdown();
  auto worker = WorkerSession::Connect(channel_, {"late", 1}, kLong);
  ASSERT_FALSE(worker.has_value());
  EXPECT_EQ(worker.error().code(), StatusCode::kUnavailable);
}

TEST_F(WorkerSessionsTest, NobodyAtTheAddress) {
  channel_.server = "127.0.0.1:1";
  auto worker = WorkerSession::Connect(channel_, {"lost", 1}, kLong);
  ASSERT_FALSE(worker.has_value());
  EXPECT_EQ(worker.error().code(), StatusCode::kUnavailable);
  EXPECT_NE(worker.error().message().find("127.0.0.1:1"), std::string::npos);
  EXPECT_NE(worker.error().message().find("isolux-server"), std::string::npos);
}

// What a raw client says first, and how the coordinator ends the stream.
class HelloTest : public WorkerSessionsTest {
 protected:
  grpc::Status Say(const v1::SessionRequest& request) {
    auto stub = v1::WorkerService::NewStub(MakeChannel(channel_));
    grpc::ClientContext context;
    SetDeadline(context, kLong);
    auto stream = stub->Session(&context);
    stream->Write(request);
    v1::SessionResponse response;
    while (stream->Read(&response)) {
    }
    return stream->Finish();
  }
};

TEST_F(HelloTest, AnotherBuildIsRefusedWithTheReason) {
  Start();
  v1::SessionRequest request;
  request.mutable_hello()->set_build_id("0.0.0-other");
  request.mutable_hello()->set_instruction_set(InstructionSet());
  request.mutable_hello()->set_name("stranger");
  const grpc::Status status = Say(request);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_NE(status.error_message().find("0.0.0-other"), std::string::npos);
  EXPECT_NE(status.error_message().find(BuildId()), std::string::npos);
}

TEST_F(HelloTest, AnotherInstructionSetIsRefused) {
  Start();
  v1::SessionRequest request;
  request.mutable_hello()->set_build_id(BuildId());
  request.mutable_hello()->set_instruction_set("x86-64-v4");
  EXPECT_EQ(Say(request).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(HelloTest, AFrameBeforeHelloIsRefused) {
  Start();
  v1::SessionRequest request;
  request.mutable_frame()->set_sequence(1);
  EXPECT_EQ(Say(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(HelloTest, OneThatSaysNothingIsGivenUp) {
  WorkerSessions::Options options;
  options.lease_s = 0.2;
  Start(options);
  v1::SessionRequest request;
  request.mutable_heartbeat();
  EXPECT_FALSE(Say(request).ok());
}

}  // namespace
}  // namespace isolux
