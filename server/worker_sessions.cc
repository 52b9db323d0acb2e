#include "server/worker_sessions.h"

#include <utility>

#include "common/rpc/channel.h"
#include "common/rpc/convert.h"
#include "common/util/build_info.h"
#include "common/util/log.h"
#include "isolux/v1/worker_service.grpc.pb.h"

namespace isolux {
namespace {

constexpr size_t kMaxNameBytes = 128;

Status CheckHello(const v1::Hello& hello) {
  if (hello.name().size() > kMaxNameBytes) {
    return MakeStatus(StatusCode::kInvalidArgument, "the name of a worker has at most {} bytes",
                      kMaxNameBytes);
  }
  if (hello.build_id() != BuildId()) {
    return MakeStatus(StatusCode::kFailedPrecondition,
                      "worker '{}' is of build {}, the coordinator of {}: install the same build "
                      "on both, or they would compute different bits",
                      hello.name(), hello.build_id().substr(0, kMaxNameBytes), BuildId());
  }
  if (hello.instruction_set() != InstructionSet()) {
    return MakeStatus(StatusCode::kFailedPrecondition,
                      "worker '{}' computes with {}, the coordinator with {}: build both alike",
                      hello.name(), hello.instruction_set().substr(0, kMaxNameBytes),
                      InstructionSet());
  }
  return {};
}

}  // namespace

// The stream of one worker. Deletes itself when gRPC is done with it.
class WorkerSessions::Reactor final
    : public grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse>,
      public StreamWire {
 public:
  Reactor(WorkerSessions* owner, grpc::CallbackServerContext* context)
      : owner_(owner),
        context_(context),
        port_(std::make_shared<StreamPort>(this, "worker at " + context->peer(),
                                           owner->options_.port)),
        id_(owner->Add(port_)) {
    port_->Start();
  }

  void StartWrite(FrameData frame) override {
    *response_.mutable_frame() = ToProto(std::move(frame));
    ServerBidiReactor::StartWrite(&response_);
  }

  // From this side the only one is the welcome.
  void StartControl() override {
    v1::Welcome* welcome = response_.mutable_welcome();
    welcome->set_session(id_);
    welcome->set_heartbeat_s(owner_->options_.heartbeat_s);
    welcome->set_lease_s(owner_->options_.lease_s);
    ServerBidiReactor::StartWrite(&response_);
  }

  void StartRead() override { ServerBidiReactor::StartRead(&request_); }
  void Abort() override { context_->TryCancel(); }
  void Finish(const Status& status) override {
    ServerBidiReactor::Finish(ToGrpc(refusal_.ok() ? status : refusal_));
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      port_->OnReadEnd(MakeStatus(StatusCode::kUnavailable, "the worker has left"));
      return;
    }
    switch (request_.part_case()) {
      case v1::SessionRequest::kHello:
        TakeHello(request_.hello());
        break;
      case v1::SessionRequest::kFrame:
        if (!greeted_) {
          Refuse(MakeStatus(StatusCode::kInvalidArgument, "a worker says hello first"));
          break;
        }
        port_->OnFrame(FromProto(std::move(*request_.mutable_frame())));
        break;
      default:
        port_->OnControl();
    }
  }

  void OnWriteDone(bool ok) override { port_->OnWriteDone(ok); }

  // Reading may be paused and nothing written: nobody else would notice.
  void OnCancel() override {
    port_->Abort(MakeStatus(StatusCode::kUnavailable, "the connection to the worker broke"));
  }

  void OnDone() override {
    owner_->Remove(id_);
    delete this;
  }

 private:
  void TakeHello(const v1::Hello& hello) {
    Status status =
        greeted_ ? MakeStatus(StatusCode::kInvalidArgument, "a second hello") : CheckHello(hello);
    if (status.ok()) {
      greeted_ = true;
      status = owner_->Admit(id_, hello.name(), hello.threads());
    }
    if (!status.ok()) return Refuse(std::move(status));
    port_->OnControl();
  }

  // The reason reaches the worker as the status of the stream; there is no further read.
  void Refuse(Status status) {
    LogWarn("refused a worker at {}: {}", context_->peer(), status.message());
    refusal_ = std::move(status);
    port_->Close(refusal_);
  }

  WorkerSessions* const owner_;
  grpc::CallbackServerContext* const context_;
  const std::shared_ptr<StreamPort> port_;
  const uint64_t id_;
  v1::SessionRequest request_;    // of the read under way
  v1::SessionResponse response_;  // of the write under way
  // Of the reads' reactions.
  bool greeted_ = false;
  Status refusal_;
};

class WorkerSessions::Service final : public v1::WorkerService::CallbackService {
 public:
  explicit Service(WorkerSessions* owner) : owner_(owner) {}

  grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse>* Session(
      grpc::CallbackServerContext* context) override {
    return new Reactor(owner_, context);
  }

 private:
  WorkerSessions* const owner_;
};

WorkerSessions::WorkerSessions(Options options)
    : options_(options), service_(std::make_unique<Service>(this)) {
  ticker_ = std::thread([this] { CheckLeases(); });
}

WorkerSessions::~WorkerSessions() {
  {
    std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  ticker_.join();
}

grpc::Service* WorkerSessions::service() { return service_.get(); }

std::vector<ConnectedWorker> WorkerSessions::Connected() const {
  std::lock_guard lock(mutex_);
  std::vector<ConnectedWorker> workers;
  for (const auto& [id, session] : sessions_) {
    if (session.admitted && !session.port->gone()) workers.push_back(session.worker);
  }
  return workers;
}

bool WorkerSessions::WaitForWorker(double timeout_s) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::duration<double>(timeout_s), [&] {
    for (const auto& [id, session] : sessions_) {
      if (session.admitted && !session.port->gone()) return true;
    }
    return false;
  });
}

void WorkerSessions::Release(uint64_t id) {
  std::shared_ptr<StreamPort> port;
  {
    std::lock_guard lock(mutex_);
    const auto session = sessions_.find(id);
    if (session == sessions_.end()) return;
    port = session->second.port;
  }
  port->Close(Status());
}

void WorkerSessions::Drop(uint64_t id, const Status& why) {
  std::shared_ptr<StreamPort> port;
  {
    std::lock_guard lock(mutex_);
    const auto session = sessions_.find(id);
    if (session == sessions_.end()) return;
    port = session->second.port;
  }
  port->Abort(why);
}

void WorkerSessions::Shutdown() {
  std::vector<std::shared_ptr<StreamPort>> ports;
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
    for (const auto& [id, session] : sessions_) ports.push_back(session.port);
  }
  for (const auto& port : ports) {
    port->Close(MakeStatus(StatusCode::kUnavailable, "the coordinator is stopping"));
  }
}

uint64_t WorkerSessions::Add(std::shared_ptr<StreamPort> port) {
  std::lock_guard lock(mutex_);
  const uint64_t id = ++last_id_;
  Session& session = sessions_[id];
  session.worker.id = id;
  session.worker.port = port;
  session.port = std::move(port);
  session.since = std::chrono::steady_clock::now();
  return id;
}

Status WorkerSessions::Admit(uint64_t id, const std::string& name, uint32_t threads) {
  {
    std::lock_guard lock(mutex_);
    if (stopping_) return MakeStatus(StatusCode::kUnavailable, "the coordinator is stopping");
    uint32_t admitted = 0;
    for (const auto& [other, session] : sessions_) admitted += session.admitted ? 1 : 0;
    if (admitted >= options_.max_workers) {
      return MakeStatus(StatusCode::kResourceExhausted, "{} workers are connected, the limit",
                        admitted);
    }
    Session& session = sessions_.at(id);
    session.worker.name = name.empty() ? "worker-" + std::to_string(id) : name;
    session.worker.threads = threads;
    // The welcome goes first: nobody else can send before this lock is free.
    session.port->SendControl();
    session.admitted = true;
    LogInfo("worker '{}' ({}) connected, {} threads", session.worker.name, id, threads);
  }
  changed_.notify_all();
  return {};
}

void WorkerSessions::Remove(uint64_t id) {
  std::lock_guard lock(mutex_);
  const auto session = sessions_.find(id);
  if (session->second.admitted) {
    LogInfo("worker '{}' ({}) disconnected", session->second.worker.name, id);
  }
  sessions_.erase(session);
}

void WorkerSessions::CheckLeases() {
  using Seconds = std::chrono::duration<double>;
  std::unique_lock lock(mutex_);
  while (!ended_) {
    changed_.wait_for(lock, Seconds(options_.lease_s / 10), [&] { return ended_; });
    const auto now = std::chrono::steady_clock::now();
    std::vector<std::pair<std::shared_ptr<StreamPort>, Status>> late;
    for (const auto& [id, session] : sessions_) {
      if (!session.admitted && Seconds(now - session.since).count() > options_.lease_s) {
        late.emplace_back(session.port, MakeStatus(StatusCode::kUnavailable, "it said no hello"));
      }
      const double silence_s = session.port->SilenceSeconds();
      if (session.admitted && silence_s > options_.lease_s && !session.port->gone()) {
        late.emplace_back(session.port,
                          MakeStatus(StatusCode::kUnavailable,
                                     "worker '{}' was silent for {:.1f} s, longer than its lease",
                                     session.worker.name, silence_s));
      }
    }
    lock.unlock();
    for (const auto& [port, why] : late) {
      LogWarn("gave up a worker: {}", why.message());
      port->Abort(why);
    }
    lock.lock();
  }
}

}  // namespace isolux
