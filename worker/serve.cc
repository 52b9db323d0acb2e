#include "worker/serve.h"

#include <chrono>
#include <condition_variable>
#include <ctime>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "common/rpc/protocol.h"
#include "worker/inbox.h"
#include "worker/port_exchange.h"
#include "worker/shard.h"

namespace isolux {
namespace {

constexpr double kIdleSlice_s = 0.25;  // how often an idle worker looks whether to leave

double ProcessCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Says Progress while there is a job, and Drain once a job when the worker is to leave. A thread of
// its own, for sending may block.
class Heartbeat {
 public:
  Heartbeat(MessagePort& port, double period_s, const std::atomic<bool>& drain)
      : port_(port), period_s_(period_s), drain_(drain), thread_([this] { Run(); }) {}
  ~Heartbeat() {
    {
      std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  void Begin(uint32_t epoch, uint64_t job) { Set({true, epoch, job, 0}); }
  void SetRound(uint32_t round) {
    std::lock_guard lock(mutex_);
    state_.round = round;
  }
  void End() { Set({}); }

 private:
  struct State {
    bool active = false;
    uint32_t epoch = 0;
    uint64_t job = 0;
    uint32_t round = 0;
  };

  void Set(const State& state) {
    std::lock_guard lock(mutex_);
    state_ = state;
  }

  void Run() {
    bool told = false;  // Drain, in told_epoch
    uint32_t told_epoch = 0;
    std::unique_lock lock(mutex_);
    while (!stop_) {
      changed_.wait_for(lock, std::chrono::duration<double>(period_s_), [this] { return stop_; });
      if (stop_ || !state_.active) continue;
      const State state = state_;
      lock.unlock();
      // A port that fails is noticed by the reader.
      (void)port_.Send(MakeMessage(MessageKind::kProgress, state.epoch,
                                   Progress{state.job, state.round, ProcessCpuSeconds()}));
      if (drain_ && !(told && told_epoch == state.epoch)) {
        (void)port_.Send({static_cast<uint32_t>(MessageKind::kDrain), state.epoch, {}});
        told = true;
        told_epoch = state.epoch;
      }
      lock.lock();
    }
  }

  MessagePort& port_;
  const double period_s_;
  const std::atomic<bool>& drain_;
  std::mutex mutex_;
  std::condition_variable changed_;
  State state_;  // guarded by mutex_
  bool stop_ = false;
  std::thread thread_;
};

// The job under way.
struct Job {
  uint64_t number = 0;
  uint32_t epoch = 0;
  std::shared_ptr<const Scene> scene;
  std::unique_ptr<Shard> shard;
  std::unique_ptr<PortExchange> exchange;
};

class Server {
 public:
  Server(MessagePort& port, const WorkerOptions& options, WorkerState& state)
      : port_(port),
        options_(options),
        state_(state),
        inbox_(port, state.stale_messages),
        heartbeat_(port, options.heartbeat_s, state.drain) {}

  Status Run();

 private:
  // What a command did to the job; errors are told to the coordinator.
  Status Handle(const Message& message);
  Status Start(const Message& message);
  Result<std::shared_ptr<const Scene>> FindScene(const StartJob& start, uint32_t epoch);
  Status RunRound(const Message& message);
  Status SolveGroup(const Message& message);
  Status Install(const Message& message);
  Status Reassign(const Message& message);
  Status Absorb(const Message& message);
  Status Gather(const Message& message);

  template <typename T>
  Status Reply(MessageKind kind, const T& content) {
    return port_.Send(MakeMessage(kind, job_->epoch, content));
  }
  void End() {
    heartbeat_.End();
    job_.reset();
  }

  MessagePort& port_;
  const WorkerOptions& options_;
  WorkerState& state_;
  std::unique_ptr<Job> job_;
  // The heartbeat may be blocked in sending: ServeJobs closes the port before it ends these.
  Inbox inbox_;
  Heartbeat heartbeat_;
};

Status Server::Run() {
  while (true) {
    if (job_ == nullptr && state_.drain) return {};
    Result<Message> message = inbox_.Next(kIdleSlice_s);
    if (!message.has_value()) {
      if (message.error().code() == StatusCode::kDeadlineExceeded) continue;
      return message.error();
    }
    const auto kind = static_cast<MessageKind>(message->kind);
    if (kind == MessageKind::kStartJob) {
      End();
    } else if (job_ == nullptr || message->epoch != job_->epoch) {
      continue;  // of a job that has failed or ended here
    }
    if (kind == MessageKind::kRelease) return {};
    if (kind == MessageKind::kEndJob || kind == MessageKind::kCancelJob) {
      End();
      continue;
    }
    const Status status = Handle(*message);
    if (status.ok()) continue;
    const bool unwanted = inbox_.Superseded(message->epoch);
    End();
    if (!unwanted)
      (void)port_.Send(MakeMessage(MessageKind::kFailed, message->epoch, Failed{status}));
  }
}

Status Server::Handle(const Message& message) {
  switch (static_cast<MessageKind>(message.kind)) {
    case MessageKind::kStartJob:
      return Start(message);
    case MessageKind::kRound:
      return RunRound(message);
    case MessageKind::kSolveGroup:
      return SolveGroup(message);
    case MessageKind::kInstallSnapshot:
      return Install(message);
    case MessageKind::kReassign:
      return Reassign(message);
    case MessageKind::kAbsorb:
      return Absorb(message);
    case MessageKind::kGather:
      return Gather(message);
    case MessageKind::kCountErrors:
      return Reply(MessageKind::kLinkErrors,
                   LinkErrors{job_->shard->CountErrors(), job_->shard->memory_bytes()});
    default:
      return MakeStatus(StatusCode::kInternal, "{} (kind {}) is no command for a worker",
                        ToText(static_cast<MessageKind>(message.kind)), message.kind);
  }
}

Result<std::shared_ptr<const Scene>> Server::FindScene(const StartJob& start, uint32_t epoch) {
  if (auto cached = state_.scenes.Find(start.scene_hash)) return cached;
  RETURN_IF_ERROR(
      port_.Send(MakeMessage(MessageKind::kNeedScene, epoch, NeedScene{start.scene_hash})));
  ASSIGN_OR_RETURN(const Message message, inbox_.NextOf(epoch, options_.reply_limit_s));
  if (message.kind != static_cast<uint32_t>(MessageKind::kSceneData)) {
    return Error(StatusCode::kInternal, "{} while waiting for the scene",
                 ToText(static_cast<MessageKind>(message.kind)));
  }
  ASSIGN_OR_RETURN(const SceneData data, DecodeMessage<SceneData>(message.payload));
  if (data.scene_hash != start.scene_hash || HashOf(data.scene) != start.scene_hash) {
    return Error(StatusCode::kDataLoss, "the scene that came is not {}", start.scene_hash);
  }
  ASSIGN_OR_RETURN(Scene scene, Decode(data.scene, options_.scene_limits));
  RETURN_IF_ERROR(Validate(scene, options_.scene_limits));
  auto shared = std::make_shared<const Scene>(std::move(scene));
  state_.scenes.Insert(start.scene_hash, shared, data.scene.size());
  return shared;
}

Status Server::Start(const Message& message) {
  ASSIGN_OR_RETURN(const StartJob start, DecodeMessage<StartJob>(message.payload));
  heartbeat_.Begin(message.epoch, start.job);
  ++state_.jobs;
  job_ = std::make_unique<Job>();
  job_->number = start.job;
  job_->epoch = message.epoch;
  ASSIGN_OR_RETURN(job_->scene, FindScene(start, message.epoch));
  job_->shard = std::make_unique<Shard>(job_->scene, &state_.pool);
  job_->exchange = std::make_unique<PortExchange>(port_, inbox_, message.epoch, start.self,
                                                  options_.reply_limit_s);
  job_->exchange->SetAssignment(start.assignment);
  RETURN_IF_ERROR(job_->shard->Start(start.options, start.assignment, start.self, start.measured));
  const Rgb emitted_w = job_->shard->EmittedPower();
  return Reply(MessageKind::kStarted, Started{{emitted_w.x, emitted_w.y, emitted_w.z}});
}

Status Server::RunRound(const Message& message) {
  ASSIGN_OR_RETURN(const RoundCommand command, DecodeMessage<RoundCommand>(message.payload));
  heartbeat_.SetRound(command.round);
  if (command.replay) {
    RETURN_IF_ERROR(job_->shard->ReplayRound(command.epsilon, *job_->exchange));
    return Reply(MessageKind::kReplayed, Replayed{command.round});
  }
  ASSIGN_OR_RETURN(RoundReport report,
                   job_->shard->RunRound(command.epsilon, command.accuracy, *job_->exchange));
  report.round = command.round;
  report.epsilon = command.epsilon;
  RETURN_IF_ERROR(Reply(MessageKind::kRoundReport, report));
  Snapshot snapshot = job_->shard->TakeSnapshot();
  snapshot.round = command.round;
  snapshot.epsilon = command.epsilon;
  return Reply(MessageKind::kSnapshotPart, SnapshotData{Encode(snapshot)});
}

Status Server::SolveGroup(const Message& message) {
  ASSIGN_OR_RETURN(const isolux::SolveGroup command,
                   DecodeMessage<isolux::SolveGroup>(message.payload));
  ASSIGN_OR_RETURN(const Snapshot start, DecodeSnapshot(command.start));
  ASSIGN_OR_RETURN(
      const RoundReport report,
      job_->shard->SolveGroup(command.group, start, command.accuracy, *job_->exchange));
  RETURN_IF_ERROR(Reply(MessageKind::kRoundReport, report));
  return Reply(MessageKind::kSnapshotPart, SnapshotData{Encode(job_->shard->TakeSnapshot())});
}

Status Server::Install(const Message& message) {
  ASSIGN_OR_RETURN(const SnapshotData data, DecodeMessage<SnapshotData>(message.payload));
  ASSIGN_OR_RETURN(const Snapshot snapshot, DecodeSnapshot(data.snapshot));
  return job_->shard->InstallSnapshot(snapshot);
}

Status Server::Reassign(const Message& message) {
  ASSIGN_OR_RETURN(const isolux::Reassign next, DecodeMessage<isolux::Reassign>(message.payload));
  ASSIGN_OR_RETURN(auto parcels, job_->shard->Reassign(next.assignment));
  job_->exchange->SetAssignment(next.assignment);
  return Reply(MessageKind::kParcels, Parcels{std::move(parcels)});
}

Status Server::Absorb(const Message& message) {
  ASSIGN_OR_RETURN(const isolux::Absorb content, DecodeMessage<isolux::Absorb>(message.payload));
  for (const std::string& parcel : content.parcels) {
    RETURN_IF_ERROR(job_->shard->Absorb(parcel));
  }
  return {};
}

Status Server::Gather(const Message& message) {
  ASSIGN_OR_RETURN(const GatherRequest request, DecodeMessage<GatherRequest>(message.payload));
  ASSIGN_OR_RETURN(const GatherPart part,
                   job_->shard->Gather(request.elements, request.corners, request.accuracy));
  return Reply(MessageKind::kGatherPart, part);
}

}  // namespace

Status ServeJobs(MessagePort& port, const WorkerOptions& options, WorkerState& state) {
  Server server(port, options, state);
  const Status status = server.Run();
  port.Close(
      Status(StatusCode::kUnavailable, status.ok() ? "the worker has left" : status.message()));
  return status;
}

}  // namespace isolux
