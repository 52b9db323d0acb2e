#include "worker/session.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "common/rpc/convert.h"
#include "common/util/build_info.h"
#include "isolux/v1/worker_service.grpc.pb.h"

namespace isolux {

// Lives until OnDone, which is when gRPC lets go of it.
class WorkerSession::Reactor final
    : public grpc::ClientBidiReactor<v1::SessionRequest, v1::SessionResponse>,
      public StreamWire {
 public:
  Reactor(const ChannelOptions& options, WorkerIdentity identity, StreamPort::Limits limits)
      : server_(options.server),
        identity_(std::move(identity)),
        channel_(MakeChannel(options)),
        stub_(v1::WorkerService::NewStub(channel_)),
        port_(this, "the server at " + server_, limits) {
    stub_->async()->Session(&context_, this);
    // Writes begin outside of reactions, until Finish.
    AddHold();
    StartCall();
    port_.SendControl();  // hello
    port_.Start();
  }

  ~Reactor() override {
    port_.Close(Status());
    {
      std::unique_lock lock(mutex_);
      constexpr auto kGoodbye = std::chrono::seconds(2);
      if (!changed_.wait_for(lock, kGoodbye, [&] { return done_.has_value(); })) {
        lock.unlock();
        context_.TryCancel();
        lock.lock();
      }
      changed_.wait(lock, [&] { return done_.has_value(); });
    }
    if (heartbeats_.joinable()) heartbeats_.join();
  }

  Status WaitForWelcome(double timeout_s) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                      [&] { return welcome_.has_value() || done_.has_value(); });
    if (welcome_) {
      heartbeats_ = std::thread([this, period_s = welcome_->heartbeat_s()] { Beat(period_s); });
      return {};
    }
    if (!done_) {
      return MakeStatus(StatusCode::kUnavailable, "the server at {} does not answer", server_);
    }
    if (!done_->ok()) return *done_;
    return MakeStatus(StatusCode::kUnavailable, "the server at {} ended the session", server_);
  }

  StreamPort& port() { return port_; }
  uint64_t id() const {
    std::lock_guard lock(mutex_);
    return welcome_ ? welcome_->session() : 0;
  }

  void StartWrite(FrameData frame) override {
    *request_.mutable_frame() = ToProto(std::move(frame));
    ClientBidiReactor::StartWrite(&request_);
  }

  // The first is the hello.
  void StartControl() override {
    if (greeted_) {
      request_.mutable_heartbeat();
    } else {
      greeted_ = true;
      v1::Hello* hello = request_.mutable_hello();
      hello->set_build_id(BuildId());
      hello->set_instruction_set(InstructionSet());
      hello->set_name(identity_.name);
      hello->set_threads(identity_.threads);
    }
    ClientBidiReactor::StartWrite(&request_);
  }

  void StartRead() override { ClientBidiReactor::StartRead(&response_); }

  // Once the server has ended the stream its status is on the way, and cancelling would hide it.
  void Abort() override {
    if (!server_ended_) context_.TryCancel();
  }

  void Finish(const Status&) override {
    StartWritesDone();
    RemoveHold();
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      server_ended_ = true;
      port_.OnReadEnd(
          MakeStatus(StatusCode::kUnavailable, "the server at {} ended the session", server_));
      return;
    }
    if (response_.has_frame()) {
      port_.OnFrame(FromProto(std::move(*response_.mutable_frame())));
      return;
    }
    if (response_.has_welcome()) {
      std::lock_guard lock(mutex_);
      if (!welcome_) welcome_ = response_.welcome();
      changed_.notify_all();
    }
    port_.OnControl();
  }

  void OnWriteDone(bool ok) override { port_.OnWriteDone(ok); }

  void OnDone(const grpc::Status& status) override {
    const Status reason = FromGrpc(status, server_);
    std::lock_guard lock(mutex_);
    done_ = reason;
    // Under the lock: once it is free the destructor may go on.
    changed_.notify_all();
  }

 private:
  // Between frames, so that a long message or a long computation is not taken for a dead worker.
  void Beat(double period_s) {
    const auto period = std::chrono::duration<double>(std::clamp(period_s, 0.01, 60.0));
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, period, [&] { return done_.has_value(); })) {
      lock.unlock();
      port_.SendControl();
      lock.lock();
    }
  }

  const std::string server_;
  const WorkerIdentity identity_;
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<v1::WorkerService::Stub> stub_;
  grpc::ClientContext context_;
  StreamPort port_;
  v1::SessionRequest request_;    // of the write under way
  v1::SessionResponse response_;  // of the read under way
  bool greeted_ = false;          // of the writes
  std::atomic<bool> server_ended_{false};

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by mutex_.
  std::optional<v1::Welcome> welcome_;
  std::optional<Status> done_;
  std::thread heartbeats_;
};

WorkerSession::WorkerSession() = default;
WorkerSession::~WorkerSession() = default;

Result<std::unique_ptr<WorkerSession>> WorkerSession::Connect(const ChannelOptions& options,
                                                              const WorkerIdentity& identity,
                                                              double timeout_s,
                                                              StreamPort::Limits limits) {
  RETURN_IF_ERROR(options.Validate());
  std::unique_ptr<WorkerSession> session(new WorkerSession());
  session->reactor_ = std::make_unique<Reactor>(options, identity, limits);
  RETURN_IF_ERROR(session->reactor_->WaitForWelcome(timeout_s));
  return session;
}

MessagePort& WorkerSession::port() { return reactor_->port(); }
uint64_t WorkerSession::id() const { return reactor_->id(); }

}  // namespace isolux
