#include "server/coordinator_service.h"

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "common/rpc/channel.h"
#include "common/rpc/convert.h"
#include "common/rpc/convert_options.h"
#include "common/util/digest.h"
#include "isolux/v1/job_service.grpc.pb.h"
#include "server/executor.h"
#include "server/upload.h"

namespace isolux {
namespace {

constexpr uint32_t kDefaultPage = 100;
constexpr uint32_t kMaxPage = 1000;

Result<JobRequest> FromProto(const v1::SubmitJobHeader& header) {
  JobRequest request;
  request.request_id = header.request_id();
  request.name = header.name();
  ASSIGN_OR_RETURN(request.options, isolux::FromProto(header.options()));
  request.total_bytes = header.total_bytes();
  request.digest = header.digest();
  request.polygons = header.polygons();
  ASSIGN_OR_RETURN(request.repairs, TakeRepairs(header.repairs()));
  return request;
}

// Ends calls in which nothing has come for too long; a client may have stalled with the connection
// alive.
class IdleCalls {
 public:
  explicit IdleCalls(double limit_s) : limit_(limit_s), thread_([this] { Run(); }) {}
  ~IdleCalls() {
    {
      std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  // Also to say that something has come.
  void Touch(grpc::CallbackServerContext* context) {
    std::lock_guard lock(mutex_);
    calls_[context] = Clock::now();
  }
  void Remove(grpc::CallbackServerContext* context) {
    std::lock_guard lock(mutex_);
    calls_.erase(context);
  }

 private:
  using Clock = std::chrono::steady_clock;

  void Run() {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, limit_ / 10, [&] { return stop_; })) {
      for (const auto& [context, touched] : calls_) {
        if (Clock::now() - touched > limit_) context->TryCancel();
      }
    }
  }

  const std::chrono::duration<double> limit_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<grpc::CallbackServerContext*, Clock::time_point> calls_;  // guarded by mutex_
  bool stop_ = false;                                                // guarded by mutex_
  std::thread thread_;
};

// Each step happens on the executor; the next read starts when it is done, so that a client can
// send no faster than the disk takes.
class SubmitReactor final : public grpc::ServerReadReactor<v1::SubmitJobRequest> {
 public:
  SubmitReactor(JobQueue* queue, Store* store, Executor* executor, IdleCalls* idle,
                grpc::CallbackServerContext* context, v1::SubmitJobResponse* response)
      : executor_(executor),
        idle_(idle),
        context_(context),
        response_(response),
        upload_(std::make_unique<Upload>(store, queue)) {
    idle_->Touch(context_);
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    idle_->Touch(context_);
    executor_->Post([this, ok] { ok ? Take() : End(); });
  }

  void OnDone() override {
    idle_->Remove(context_);
    delete this;
  }

 private:
  void Take() {
    const Status status = TakePart();
    // The job exists already: the answer does not wait for the scene.
    if (status.ok() && upload_->existing()) return End();
    if (!status.ok()) {
      upload_.reset();
      return Finish(ToGrpc(status));
    }
    StartRead(&request_);
  }

  Status TakePart() {
    if (request_.has_header()) {
      ASSIGN_OR_RETURN(auto header, FromProto(request_.header()));
      return upload_->Begin(std::move(header));
    }
    const v1::SubmitJobChunk& chunk = request_.chunk();
    return upload_->Add(chunk.offset(), chunk.data(), chunk.checksum());
  }

  void End() {
    // A client that went away has not said that it was done.
    if (context_->IsCancelled()) {
      upload_.reset();
      return Finish(grpc::Status::CANCELLED);
    }
    const Result<JobQueue::Submitted> submitted = upload_->Finish();
    upload_.reset();
    if (!submitted) return Finish(ToGrpc(submitted.error()));
    response_->set_job(submitted->job);
    response_->set_existing(submitted->existing);
    Finish(grpc::Status::OK);
  }

  Executor* const executor_;
  IdleCalls* const idle_;
  grpc::CallbackServerContext* const context_;
  v1::SubmitJobResponse* const response_;
  std::unique_ptr<Upload> upload_;
  v1::SubmitJobRequest request_;
};

// Writes one event after another; when there is none, waits to be told of news.
class WatchReactor final : public grpc::ServerWriteReactor<v1::WatchJobResponse> {
 public:
  WatchReactor(JobQueue* queue, const v1::WatchJobRequest& request) {
    Result<std::shared_ptr<JobWatch>> watch =
        queue->Watch(request.job(), request.after_sequence(), [this] { Continue(); });
    if (!watch) {
      finished_ = true;
      Finish(ToGrpc(watch.error()));
      return;
    }
    {
      std::lock_guard lock(mutex_);
      watch_ = std::move(*watch);
    }
    Continue();
  }

  void OnWriteDone(bool ok) override {
    {
      std::lock_guard lock(mutex_);
      writing_ = false;
    }
    ok ? Continue() : End(grpc::Status::CANCELLED);
  }

  void OnCancel() override { End(grpc::Status::CANCELLED); }

  void OnDone() override {
    if (watch_ != nullptr) watch_->Close();
    delete this;
  }

 private:
  void Continue() {
    std::unique_lock lock(mutex_);
    if (writing_ || finished_ || watch_ == nullptr) return;
    const Result<JobEvent> event = watch_->Next();
    const bool none = event && event->kind == JobEvent::Kind::kNone;
    if (none && !end_written_) return;
    if (!event || none) {
      lock.unlock();
      return End(event ? grpc::Status::OK : ToGrpc(event.error()));
    }
    response_.Clear();
    response_.set_sequence(event->sequence);
    if (event->kind == JobEvent::Kind::kRound) {
      *response_.mutable_round() = ToProto(event->round);
    } else if (event->kind == JobEvent::Kind::kActivity) {
      *response_.mutable_progress() = ToProto(event->activity);
    } else {
      *response_.mutable_ended() = ToProto(event->job, /*whole=*/true);
      end_written_ = true;
    }
    writing_ = true;
    StartWrite(&response_);
  }

  void End(const grpc::Status& status) {
    {
      std::lock_guard lock(mutex_);
      // A write under way comes back first: cancelled, it fails.
      if (finished_ || writing_) return;
      finished_ = true;
    }
    Finish(status);
  }

  std::mutex mutex_;
  // Guarded by mutex_.
  std::shared_ptr<JobWatch> watch_;
  v1::WatchJobResponse response_;
  bool writing_ = false, end_written_ = false, finished_ = false;
};

class FetchReactor final : public grpc::ServerWriteReactor<v1::FetchResultResponse> {
 public:
  FetchReactor(JobQueue* queue, Store* store, const CoordinatorService::Latest* latest,
               Executor* executor, const v1::FetchResultRequest& request)
      : queue_(queue),
        store_(store),
        latest_(request.latest() ? latest : nullptr),
        executor_(executor),
        job_(request.job()),
        offset_(request.offset()) {
    executor_->Post([this] {
      const Status status = Begin();
      if (!status.ok()) return Finish(ToGrpc(status));
      SendNext();
    });
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::CANCELLED);
    if (offset_ >= total_bytes_) return Finish(grpc::Status::OK);
    executor_->Post([this] { SendNext(); });
  }

  void OnDone() override { delete this; }

 private:
  Status Begin() {
    ASSIGN_OR_RETURN(auto info, queue_->Get(job_));
    if (latest_ != nullptr && !HasEnded(info.state)) {
      Result<std::string> made = (*latest_)(info);
      if (made) return BeginWith(std::move(*made));
      // It may have ended meanwhile, and its snapshots with it.
      if (made.error().code() != StatusCode::kNotFound) return made.error();
      ASSIGN_OR_RETURN(info, queue_->Get(job_));
    }
    if (info.state != JobState::kDone) {
      return MakeStatus(StatusCode::kFailedPrecondition, "job {} is {}: it has no result{}", job_,
                        ToText(info.state), HasEnded(info.state) ? "" : " yet");
    }
    if (offset_ > info.result_bytes) {
      return MakeStatus(StatusCode::kOutOfRange, "job {}: its result has {} bytes, not {}", job_,
                        info.result_bytes, offset_);
    }
    total_bytes_ = info.result_bytes;
    response_.set_total_bytes(info.result_bytes);
    response_.set_digest(info.result_digest);
    return {};
  }

  Status BeginWith(std::string bytes) {
    if (offset_ != 0) {
      return {StatusCode::kInvalidArgument, "what is newest is fetched from its beginning"};
    }
    Digest digest;
    digest.Add(bytes);
    total_bytes_ = bytes.size();
    response_.set_total_bytes(bytes.size());
    response_.set_digest(digest.Finish());
    made_ = std::move(bytes);
    return {};
  }

  void SendNext() {
    Result<std::string> data = made_.empty() ? store_->ReadResult(job_, offset_, kFrameBytes)
                                             : made_.substr(offset_, kFrameBytes);
    if (data && data->empty() && offset_ < total_bytes_) {
      data = Error(StatusCode::kDataLoss, "job {}: its result ends at {} of {} bytes", job_,
                   offset_, total_bytes_);
    }
    if (!data) return Finish(ToGrpc(data.error()));
    if (sent_) response_.Clear();
    sent_ = true;
    response_.set_offset(offset_);
    response_.set_checksum(Checksum(*data));
    offset_ += data->size();
    response_.set_data(std::move(*data));
    StartWrite(&response_);
  }

  JobQueue* const queue_;
  Store* const store_;
  const CoordinatorService::Latest* const latest_;  // null: the result alone will do
  Executor* const executor_;
  const uint64_t job_;
  uint64_t offset_;
  std::string made_;  // for this call; empty: the job's result in the store
  uint64_t total_bytes_ = 0;
  bool sent_ = false;
  v1::FetchResultResponse response_;
};

}  // namespace

class CoordinatorService::Service final : public v1::JobService::CallbackService {
 public:
  Service(JobQueue* queue, Store* store, const WorkerSessions* workers, Latest latest,
          const Options& options)
      : queue_(queue),
        store_(store),
        workers_(workers),
        latest_(std::move(latest)),
        idle_(options.idle_upload_s),
        executor_(options.threads) {}

  grpc::ServerReadReactor<v1::SubmitJobRequest>* SubmitJob(
      grpc::CallbackServerContext* context, v1::SubmitJobResponse* response) override {
    return new SubmitReactor(queue_, store_, &executor_, &idle_, context, response);
  }

  grpc::ServerUnaryReactor* GetJob(grpc::CallbackServerContext* context,
                                   const v1::GetJobRequest* request,
                                   v1::GetJobResponse* response) override {
    const Result<JobInfo> job = queue_->Get(request->job());
    if (job) *response->mutable_job() = ToProto(*job, /*whole=*/true);
    return Answer(context, job ? Status() : job.error());
  }

  grpc::ServerUnaryReactor* ListJobs(grpc::CallbackServerContext* context,
                                     const v1::ListJobsRequest* request,
                                     v1::ListJobsResponse* response) override {
    const uint32_t limit =
        request->limit() == 0 ? kDefaultPage : std::min(request->limit(), kMaxPage);
    for (const JobInfo& job : queue_->List(limit, request->before())) {
      *response->add_jobs() = ToProto(job, /*whole=*/false);
    }
    return Answer(context, Status());
  }

  grpc::ServerUnaryReactor* ListWorkers(grpc::CallbackServerContext* context,
                                        const v1::ListWorkersRequest*,
                                        v1::ListWorkersResponse* response) override {
    for (const ConnectedWorker& worker : workers_->Connected()) {
      v1::Worker* message = response->add_workers();
      message->set_session(worker.id);
      message->set_name(worker.name);
      message->set_threads(worker.threads);
    }
    return Answer(context, Status());
  }

  grpc::ServerWriteReactor<v1::WatchJobResponse>* WatchJob(
      grpc::CallbackServerContext*, const v1::WatchJobRequest* request) override {
    return new WatchReactor(queue_, *request);
  }

  grpc::ServerUnaryReactor* CancelJob(grpc::CallbackServerContext* context,
                                      const v1::CancelJobRequest* request,
                                      v1::CancelJobResponse* response) override {
    grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
    executor_.Post([this, reactor, job = request->job(), response] {
      const Result<JobState> state = queue_->Cancel(job);
      if (state) response->set_state(static_cast<v1::JobState>(*state));
      reactor->Finish(ToGrpc(state ? Status() : state.error()));
    });
    return reactor;
  }

  grpc::ServerUnaryReactor* FinishJob(grpc::CallbackServerContext* context,
                                      const v1::FinishJobRequest* request,
                                      v1::FinishJobResponse* response) override {
    grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
    executor_.Post([this, reactor, job = request->job(), response] {
      const Result<JobState> state = queue_->Finish(job);
      if (state) response->set_state(static_cast<v1::JobState>(*state));
      reactor->Finish(ToGrpc(state ? Status() : state.error()));
    });
    return reactor;
  }

  grpc::ServerWriteReactor<v1::FetchResultResponse>* FetchResult(
      grpc::CallbackServerContext*, const v1::FetchResultRequest* request) override {
    return new FetchReactor(queue_, store_, &latest_, &executor_, *request);
  }

 private:
  static grpc::ServerUnaryReactor* Answer(grpc::CallbackServerContext* context,
                                          const Status& status) {
    grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
    reactor->Finish(ToGrpc(status));
    return reactor;
  }

  JobQueue* const queue_;
  Store* const store_;
  const WorkerSessions* const workers_;
  const Latest latest_;
  IdleCalls idle_;
  Executor executor_;
};

CoordinatorService::CoordinatorService(JobQueue* queue, Store* store, const WorkerSessions* workers,
                                       Latest latest, Options options)
    : service_(std::make_unique<Service>(queue, store, workers, std::move(latest), options)) {}

CoordinatorService::~CoordinatorService() = default;

grpc::Service* CoordinatorService::service() { return service_.get(); }

}  // namespace isolux
