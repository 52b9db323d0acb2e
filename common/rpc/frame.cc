#include "common/rpc/frame.h"

#include <algorithm>
#include <utility>

namespace isolux {
namespace {

// Taken at once for a message that has only been announced; more grows as the data comes in.
constexpr uint64_t kReserveBytes = 16ULL << 20;

}  // namespace

void FrameCutter::Add(Message message) {
  waiting_bytes_ += message.payload.size();
  messages_.push_back(std::move(message));
}

std::optional<FrameData> FrameCutter::Next() {
  if (messages_.empty()) return std::nullopt;
  Message& message = messages_.front();
  FrameData frame;
  frame.epoch = message.epoch;
  frame.kind = message.kind;
  frame.sequence = ++sequence_;
  if (offset_ == 0) frame.message_bytes = message.payload.size();
  const size_t size = std::min<uint64_t>(kFrameBytes, message.payload.size() - offset_);
  if (size == message.payload.size()) {
    frame.data = std::move(message.payload);
    frame.last = true;
  } else {
    frame.data = message.payload.substr(offset_, size);
    frame.last = offset_ + size == message.payload.size();
  }
  offset_ += size;
  waiting_bytes_ -= size;
  if (frame.last) {
    messages_.pop_front();
    offset_ = 0;
  }
  return frame;
}

Result<std::optional<Message>> FrameJoiner::Add(FrameData frame) {
  if (frame.sequence != sequence_ + 1) {
    return Error(StatusCode::kDataLoss, "frame {} came where {} was due", frame.sequence,
                 sequence_ + 1);
  }
  ++sequence_;
  if (frame.data.size() > kFrameBytes) {
    return Error(StatusCode::kInvalidArgument, "a frame of {} bytes; {} is the limit",
                 frame.data.size(), kFrameBytes);
  }
  if (!begun_) {
    if (frame.message_bytes > max_message_bytes_) {
      return Error(StatusCode::kResourceExhausted, "a message of {} bytes; {} is the limit",
                   frame.message_bytes, max_message_bytes_);
    }
    expected_bytes_ = frame.message_bytes;
    message_ = Message{frame.kind, frame.epoch, {}};
    if (!frame.last) message_.payload.reserve(std::min(expected_bytes_, kReserveBytes));
    begun_ = true;
  } else if (frame.kind != message_.kind || frame.epoch != message_.epoch ||
             frame.message_bytes != 0 || frame.data.empty()) {
    return Error(StatusCode::kDataLoss, "frame {} does not continue its message", frame.sequence);
  }
  const uint64_t size = message_.payload.size() + frame.data.size();
  if (size > expected_bytes_ || frame.last != (size == expected_bytes_)) {
    return Error(StatusCode::kDataLoss, "a message of {} bytes was announced, frame {} ends at {}",
                 expected_bytes_, frame.sequence, size);
  }
  if (frame.last && message_.payload.empty()) {
    message_.payload = std::move(frame.data);
  } else {
    message_.payload += frame.data;
  }
  if (!frame.last) return std::optional<Message>();
  begun_ = false;
  return std::optional<Message>(std::move(message_));
}

}  // namespace isolux
