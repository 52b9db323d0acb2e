#include "common/rpc/stream_port.h"

#include <utility>

#include "common/util/check.h"

namespace isolux {

StreamPort::StreamPort(StreamWire* wire, std::string peer, Limits limits)
    : peer_(std::move(peer)), limits_(limits), wire_(wire), joiner_(limits.max_message_bytes) {}

Status StreamPort::Send(Message message) {
  if (message.payload.size() > limits_.max_message_bytes) {
    return MakeStatus(StatusCode::kResourceExhausted,
                      "a message of {} bytes to {}; {} is the limit", message.payload.size(), peer_,
                      limits_.max_message_bytes);
  }
  std::unique_lock lock(mutex_);
  writable_.wait(
      lock, [&] { return gone_ || closing_ || outbox_.waiting_bytes() < limits_.outbox_bytes; });
  if (gone_ || closing_) return reason_;
  bytes_sent_ += message.payload.size();
  outbox_.Add(std::move(message));
  ContinueWriting();
  return {};
}

Result<Message> StreamPort::Receive(double timeout_s) {
  std::unique_lock lock(mutex_);
  const bool some = readable_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                                       [&] { return !inbox_.empty() || gone_ || closing_; });
  if (!inbox_.empty()) {
    Message message = std::move(inbox_.front());
    inbox_.pop_front();
    inbox_bytes_ -= message.payload.size();
    ContinueReading();
    return message;
  }
  if (!some) return Error(StatusCode::kDeadlineExceeded, "nothing from {} in time", peer_);
  return tl::unexpected<Status>(reason_);
}

void StreamPort::Close(const Status& reason) {
  std::unique_lock lock(mutex_);
  if (!closing_ && !gone_) {
    closing_ = true;
    reason_ = MakeStatus(StatusCode::kUnavailable, "the connection to {} is closed{}{}", peer_,
                         reason.ok() ? "" : ": ", reason.message());
  }
  writable_.notify_all();
  readable_.notify_all();
  FinishIfDue(lock);
}

void StreamPort::Abort(const Status& why) {
  std::unique_lock lock(mutex_);
  GiveUp(why);
  FinishIfDue(lock);
}

uint64_t StreamPort::bytes_sent() const {
  std::lock_guard lock(mutex_);
  return bytes_sent_;
}

uint64_t StreamPort::bytes_received() const {
  std::lock_guard lock(mutex_);
  return bytes_received_;
}

void StreamPort::Start() {
  std::lock_guard lock(mutex_);
  ContinueReading();
}

void StreamPort::OnFrame(FrameData frame) {
  std::unique_lock lock(mutex_);
  reading_ = false;
  heard_ = Clock::now();
  bytes_received_ += frame.data.size();
  if (!gone_) {
    Result<std::optional<Message>> message = joiner_.Add(std::move(frame));
    if (!message) {
      GiveUp(message.error().Within("from " + peer_));
    } else if (message->has_value()) {
      inbox_bytes_ += (*message)->payload.size();
      inbox_.push_back(std::move(**message));
      readable_.notify_one();
    }
  }
  ContinueReading();
  FinishIfDue(lock);
}

void StreamPort::OnControl() {
  std::lock_guard lock(mutex_);
  reading_ = false;
  heard_ = Clock::now();
  ContinueReading();
}

void StreamPort::OnReadEnd(const Status& why) {
  std::unique_lock lock(mutex_);
  reading_ = false;
  // The stream ends in order, unless a write is stuck that nobody will read.
  GiveUp(why, /*abort=*/writing_);
  FinishIfDue(lock);
}

void StreamPort::OnWriteDone(bool ok) {
  std::unique_lock lock(mutex_);
  writing_ = false;
  if (!ok) {
    GiveUp(MakeStatus(StatusCode::kUnavailable, "the connection to {} broke", peer_));
  }
  ContinueWriting();
  writable_.notify_all();
  FinishIfDue(lock);
}

void StreamPort::SendControl() {
  std::lock_guard lock(mutex_);
  control_due_ = true;
  ContinueWriting();
}

double StreamPort::SilenceSeconds() const {
  std::lock_guard lock(mutex_);
  if (!reading_) return 0;
  return std::chrono::duration<double>(Clock::now() - heard_).count();
}

bool StreamPort::gone() const {
  std::lock_guard lock(mutex_);
  return gone_ || closing_;
}

void StreamPort::ContinueWriting() {
  if (writing_ || gone_ || finished_) return;
  if (control_due_) {
    control_due_ = false;
    writing_ = true;
    wire_->StartControl();
    return;
  }
  std::optional<FrameData> frame = outbox_.Next();
  if (!frame) return;
  writing_ = true;
  wire_->StartWrite(std::move(*frame));
}

void StreamPort::ContinueReading() {
  if (reading_ || gone_ || finished_ || inbox_bytes_ >= limits_.inbox_bytes) return;
  reading_ = true;
  // Silence is counted from here: while reading waited, nothing could be heard.
  heard_ = Clock::now();
  wire_->StartRead();
}

void StreamPort::GiveUp(const Status& why, bool abort) {
  if (gone_) return;
  gone_ = true;
  if (!closing_) {
    reason_ = Status(StatusCode::kUnavailable, why.ok() ? peer_ + " has left" : why.message());
  }
  if (abort && !finished_) wire_->Abort();
  writable_.notify_all();
  readable_.notify_all();
}

void StreamPort::FinishIfDue(std::unique_lock<std::mutex>& lock) {
  if (finished_ || writing_) return;
  if (!gone_ && !(closing_ && outbox_.empty())) return;
  finished_ = true;
  StreamWire* wire = wire_;
  const Status reason = reason_;
  lock.unlock();
  wire->Finish(reason);
}

}  // namespace isolux
