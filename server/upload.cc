#include "server/upload.h"

#include <utility>

#include "common/util/digest.h"

namespace isolux {

Upload::~Upload() {
  if (has_slot_) queue_->EndUpload();
}

Status Upload::Begin(JobRequest request) {
  if (begun_) return MakeStatus(StatusCode::kInvalidArgument, "a second header");
  begun_ = true;
  request_ = std::move(request);
  ASSIGN_OR_RETURN(existing_, queue_->BeginUpload(request_));
  if (existing_) return {};
  has_slot_ = true;
  ASSIGN_OR_RETURN(incoming_, store_->BeginScene());
  return {};
}

Status Upload::Add(uint64_t offset, std::string_view data, uint64_t checksum) {
  if (!begun_) return MakeStatus(StatusCode::kInvalidArgument, "a chunk came before the header");
  if (existing_) return {};
  if (data.empty() || data.size() > kMaxChunkBytes) {
    return MakeStatus(StatusCode::kInvalidArgument, "a chunk of {} bytes; 1 to {} are allowed",
                      data.size(), kMaxChunkBytes);
  }
  if (offset != incoming_->size()) {
    return MakeStatus(StatusCode::kInvalidArgument, "a chunk at {} came where {} was due", offset,
                      incoming_->size());
  }
  if (data.size() > request_.total_bytes - incoming_->size()) {
    return MakeStatus(StatusCode::kInvalidArgument, "more came than the {} bytes declared",
                      request_.total_bytes);
  }
  if (Checksum(data) != checksum) {
    return MakeStatus(StatusCode::kDataLoss,
                      "the chunk at {} was damaged on the way: send the scene again", offset);
  }
  return incoming_->Append(data);
}

Result<JobQueue::Submitted> Upload::Finish() {
  if (!begun_) return Error(StatusCode::kInvalidArgument, "there was no header");
  if (existing_) return JobQueue::Submitted{*existing_, true};
  if (incoming_->size() != request_.total_bytes) {
    return Error(StatusCode::kInvalidArgument, "{} bytes were declared, {} came",
                 request_.total_bytes, incoming_->size());
  }
  if (incoming_->digest() != request_.digest) {
    return Error(StatusCode::kDataLoss,
                 "the scene's digest is {}, {} was declared: send the scene again",
                 incoming_->digest(), request_.digest);
  }
  ASSIGN_OR_RETURN(const auto bytes, incoming_->Read());
  ASSIGN_OR_RETURN(const auto scene, Decode(bytes, queue_->limits().scene));
  RETURN_IF_ERROR(Validate(scene, queue_->limits().scene));
  if (scene.polygons.size() != request_.polygons) {
    return Error(StatusCode::kInvalidArgument, "{} polygons were declared, {} came",
                 request_.polygons, scene.polygons.size());
  }
  RETURN_IF_ERROR(incoming_->Keep());
  return queue_->Submit(request_);
}

}  // namespace isolux
