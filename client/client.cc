#include "client/client.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <random>
#include <thread>

#include "common/rpc/channel.h"
#include "common/rpc/convert.h"
#include "common/rpc/convert_options.h"
#include "common/util/digest.h"
#include "common/util/file.h"
#include "isolux/v1/job_service.grpc.pb.h"

namespace isolux {
namespace {

constexpr double kPatienceS = 30;  // for a server that went away in the midst of a call
constexpr double kSlowestBytesPerSecond = 1e6;
constexpr size_t kMaxNameBytes = 128;

Status Interrupted() { return MakeStatus(StatusCode::kCancelled, "interrupted"); }

// The file that a result is written to; removed unless it is kept.
class PartFile {
 public:
  explicit PartFile(const std::string& path) : path_(path), part_(path + ".part") {
    file_ = std::fopen(part_.c_str(), "wb");
  }
  ~PartFile() {
    if (file_ == nullptr) return;
    std::fclose(file_);
    std::remove(part_.c_str());
  }
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  bool ok() const { return file_ != nullptr; }
  uint64_t size() const { return size_; }
  std::string digest() const { return digest_.Finish(); }

  Status Append(const std::string& bytes) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) return WriteFailed();
    digest_.Add(bytes);
    size_ += bytes.size();
    return {};
  }
  Status Keep() {
    const bool flushed = std::fflush(file_) == 0 && ::fsync(::fileno(file_)) == 0;
    if (!flushed || std::rename(part_.c_str(), path_.c_str()) != 0) return WriteFailed();
    std::fclose(file_);
    file_ = nullptr;
    return {};
  }

 private:
  Status WriteFailed() const {
    return MakeStatus(StatusCode::kUnavailable, "{}: cannot be written: {}", path_,
                      std::strerror(errno));
  }

  const std::string path_, part_;
  std::FILE* file_;
  uint64_t size_ = 0;
  Digest digest_;
};

}  // namespace

class Client::Impl {
 public:
  explicit Impl(const ChannelOptions& options)
      : options_(options), stub_(v1::JobService::NewStub(MakeChannel(options))) {}

  // A call's context, which Interrupt cancels.
  class Call {
   public:
    Call(Impl* impl, double deadline_s) : impl_(impl) {
      if (deadline_s > 0) SetDeadline(context, deadline_s);
      std::lock_guard lock(impl_->mutex_);
      impl_->call_ = &context;
      if (impl_->interrupted_) context.TryCancel();
    }
    ~Call() {
      std::lock_guard lock(impl_->mutex_);
      impl_->call_ = nullptr;
    }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    grpc::ClientContext context;

   private:
    Impl* const impl_;
  };

  Status ToStatus(const grpc::Status& status) {
    {
      std::lock_guard lock(mutex_);
      if (interrupted_ && !status.ok()) return Interrupted();
    }
    return FromGrpc(status, options_.server);
  }

  void SetInterrupted(bool interrupted) {
    std::lock_guard lock(mutex_);
    interrupted_ = interrupted;
    if (interrupted && call_ != nullptr) call_->TryCancel();
    changed_.notify_all();
  }

  // Whether to try again: the server was there, and may be again.
  class Patience {
    using Clock = std::chrono::steady_clock;

   public:
    explicit Patience(Impl* impl) : impl_(impl) {}
    void Renew() { since_ = {}; }
    bool Wait(const Status& status) {
      if (status.code() != StatusCode::kUnavailable || !impl_->connected_) return false;
      const auto now = Clock::now();
      if (since_ == Clock::time_point()) since_ = now;
      if (now - since_ > std::chrono::duration<double>(kPatienceS)) return false;
      std::unique_lock lock(impl_->mutex_);
      impl_->changed_.wait_for(lock, std::chrono::milliseconds(300),
                               [&] { return impl_->interrupted_; });
      return !impl_->interrupted_;
    }

   private:
    Impl* const impl_;
    Clock::time_point since_{};  // of the first failure in a row
  };

  Result<JobInfo> Watch(uint64_t job, const Watcher& watcher);
  Status FetchInto(uint64_t job, bool latest, PartFile& file, std::string* digest, uint64_t* total);

  const ChannelOptions options_;
  const std::unique_ptr<v1::JobService::Stub> stub_;
  bool connected_ = false;  // something has been heard of the server

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  grpc::ClientContext* call_ = nullptr;  // guarded by mutex_
  bool interrupted_ = false;             // guarded by mutex_
};

Result<std::unique_ptr<Client>> Client::Make(const std::string& server) {
  ChannelOptions options;
  options.server = server;
  RETURN_IF_ERROR(options.Validate());
  return std::unique_ptr<Client>(new Client(std::make_unique<Impl>(options)));
}

Client::Client(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Client::~Client() = default;

Result<Client::Submitted> Client::Submit(const Submission& submission) {
  const std::string& scene = submission.encoded_scene;
  Impl::Call call(impl_.get(), 60 + static_cast<double>(scene.size()) / kSlowestBytesPerSecond);
  v1::SubmitJobResponse response;
  auto stream = impl_->stub_->SubmitJob(&call.context, &response);
  v1::SubmitJobRequest request;
  v1::SubmitJobHeader* header = request.mutable_header();
  header->set_request_id(submission.request_id);
  header->set_name(Utf8(submission.name.substr(0, kMaxNameBytes)));
  *header->mutable_options() = ToProto(submission.options);
  header->set_total_bytes(scene.size());
  header->set_digest(HashOf(scene));
  header->set_polygons(submission.polygons);
  PutRepairs(submission.repairs, header->mutable_repairs());
  // A write fails when the server has ended the call: its status says why.
  bool open = stream->Write(request);
  for (size_t offset = 0; open && offset < scene.size(); offset += kFrameBytes) {
    v1::SubmitJobChunk* chunk = request.mutable_chunk();
    chunk->set_offset(offset);
    chunk->set_data(scene.substr(offset, kFrameBytes));
    chunk->set_checksum(Checksum(chunk->data()));
    open = stream->Write(request);
  }
  if (open) stream->WritesDone();
  RETURN_IF_ERROR(impl_->ToStatus(stream->Finish()));
  impl_->connected_ = true;
  return Submitted{response.job(), response.existing()};
}

Result<JobInfo> Client::Get(uint64_t job) {
  Impl::Call call(impl_.get(), impl_->options_.call_deadline_s);
  v1::GetJobRequest request;
  request.set_job(job);
  v1::GetJobResponse response;
  RETURN_IF_ERROR(impl_->ToStatus(impl_->stub_->GetJob(&call.context, request, &response)));
  return FromProto(response.job());
}

Result<std::vector<JobInfo>> Client::List(uint32_t limit) {
  Impl::Call call(impl_.get(), impl_->options_.call_deadline_s);
  v1::ListJobsRequest request;
  request.set_limit(limit);
  v1::ListJobsResponse response;
  RETURN_IF_ERROR(impl_->ToStatus(impl_->stub_->ListJobs(&call.context, request, &response)));
  std::vector<JobInfo> jobs;
  for (const v1::Job& message : response.jobs()) {
    ASSIGN_OR_RETURN(auto job, FromProto(message));
    jobs.push_back(std::move(job));
  }
  return jobs;
}

Result<JobState> Client::Cancel(uint64_t job) {
  Impl::Call call(impl_.get(), impl_->options_.call_deadline_s);
  v1::CancelJobRequest request;
  request.set_job(job);
  v1::CancelJobResponse response;
  RETURN_IF_ERROR(impl_->ToStatus(impl_->stub_->CancelJob(&call.context, request, &response)));
  return static_cast<JobState>(response.state());
}

Result<JobState> Client::Finish(uint64_t job) {
  Impl::Call call(impl_.get(), impl_->options_.call_deadline_s);
  v1::FinishJobRequest request;
  request.set_job(job);
  v1::FinishJobResponse response;
  RETURN_IF_ERROR(impl_->ToStatus(impl_->stub_->FinishJob(&call.context, request, &response)));
  return static_cast<JobState>(response.state());
}

Result<uint32_t> Client::CountWorkers() {
  Impl::Call call(impl_.get(), impl_->options_.call_deadline_s);
  v1::ListWorkersResponse response;
  RETURN_IF_ERROR(impl_->ToStatus(impl_->stub_->ListWorkers(&call.context, {}, &response)));
  impl_->connected_ = true;
  return static_cast<uint32_t>(response.workers_size());
}

Result<JobInfo> Client::Watch(uint64_t job, const Watcher& watcher) {
  return impl_->Watch(job, watcher);
}

Result<JobInfo> Client::Impl::Watch(uint64_t job, const Watcher& watcher) {
  v1::WatchJobRequest request;
  request.set_job(job);
  Patience patience(this);
  Status status;
  do {
    if (!status.ok() && watcher.on_trouble) watcher.on_trouble(status.message());
    Call call(this, /*deadline_s=*/0);
    auto stream = stub_->WatchJob(&call.context, request);
    v1::WatchJobResponse event;
    while (stream->Read(&event)) {
      connected_ = true;
      patience.Renew();
      request.set_after_sequence(event.sequence());
      if (event.has_ended()) return FromProto(event.ended());
      if (event.has_progress() && watcher.on_activity) {
        watcher.on_activity(FromProto(event.progress()));
      }
      if (!event.has_round() || !watcher.on_round) continue;
      ASSIGN_OR_RETURN(const auto round, FromProto(event.round()));
      watcher.on_round(round);
    }
    status = ToStatus(stream->Finish());
    if (status.ok()) {
      status =
          MakeStatus(StatusCode::kUnavailable, "job {}: its events ended without its end", job);
    }
  } while (patience.Wait(status));
  return tl::unexpected<Status>(status);
}

Status Client::Impl::FetchInto(uint64_t job, bool latest, PartFile& file, std::string* digest,
                               uint64_t* total) {
  Call call(this, /*deadline_s=*/0);
  v1::FetchResultRequest request;
  request.set_job(job);
  request.set_offset(file.size());
  request.set_latest(latest);
  auto stream = stub_->FetchResult(&call.context, request);
  v1::FetchResultResponse part;
  while (stream->Read(&part)) {
    connected_ = true;
    if (!part.digest().empty()) {
      *digest = part.digest();
      *total = part.total_bytes();
    }
    if (part.offset() != file.size() || part.checksum() != Checksum(part.data())) {
      return MakeStatus(StatusCode::kDataLoss, "job {}: its result was damaged on the way", job);
    }
    RETURN_IF_ERROR(file.Append(part.data()));
  }
  return ToStatus(stream->Finish());
}

Status Client::Fetch(uint64_t job, const std::string& path, bool latest) {
  PartFile file(path);
  if (!file.ok()) {
    return MakeStatus(StatusCode::kInvalidArgument, "{}: cannot be written: {}", path,
                      std::strerror(errno));
  }
  std::string digest;
  uint64_t total = 0;
  Impl::Patience patience(impl_.get());
  Status status;
  do {
    const uint64_t before = file.size();
    status = impl_->FetchInto(job, latest, file, &digest, &total);
    if (file.size() > before) patience.Renew();
    // What is newest may be another by then: it cannot be taken up in its middle.
    if (latest && file.size() > 0) break;
  } while (!status.ok() && patience.Wait(status));
  RETURN_IF_ERROR(status);
  if (file.size() != total || file.digest() != digest) {
    return MakeStatus(StatusCode::kDataLoss,
                      "job {}: {} of {} bytes came, or others than were sent: fetch it again", job,
                      file.size(), total);
  }
  return file.Keep();
}

void Client::Interrupt() { impl_->SetInterrupted(true); }
void Client::Resume() { impl_->SetInterrupted(false); }

std::string MakeRequestId() {
  std::random_device random;
  const auto word = [&] { return static_cast<uint64_t>(random()) << 32 | random(); };
  return fmt::format("{:016x}{:016x}", word(), word());
}

}  // namespace isolux
