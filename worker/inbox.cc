#include "worker/inbox.h"

#include <chrono>

#include "common/rpc/protocol.h"

namespace isolux {
namespace {

constexpr double kReadSlice_s = 0.5;  // how often the reader looks whether to stop

}  // namespace

Inbox::Inbox(MessagePort& port, std::atomic<uint64_t>& stale)
    : port_(port), stale_(stale), reader_([this] { Read(); }) {}

Inbox::~Inbox() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  port_.Close(Status(StatusCode::kUnavailable, "the worker has left"));
  reader_.join();
}

void Inbox::Read() {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return stop_ || waiting_.size() < kMaxWaiting; });
      if (stop_) return;
    }
    Result<Message> message = port_.Receive(kReadSlice_s);
    std::lock_guard lock(mutex_);
    if (message.has_value()) {
      Take(std::move(*message));
    } else if (message.error().code() != StatusCode::kDeadlineExceeded) {
      failure_ = message.error();
      changed_.notify_all();
      return;
    }
  }
}

void Inbox::Take(Message message) {
  if (message.epoch < newest_epoch_) {
    ++stale_;
    return;
  }
  const bool cancels = message.kind == static_cast<uint32_t>(MessageKind::kCancelJob);
  if (message.epoch > newest_epoch_ || cancels) {
    stale_ += waiting_.size();
    waiting_.clear();
    newest_epoch_ = message.epoch;
  }
  if (cancels) cancelled_epoch_ = message.epoch;
  waiting_.push_back(std::move(message));
  changed_.notify_all();
}

Result<Message> Inbox::Next(double timeout_s) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                    [this] { return !waiting_.empty() || !failure_.ok(); });
  if (!waiting_.empty()) {
    Message message = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    return message;
  }
  if (!failure_.ok()) return tl::unexpected<Status>(failure_);
  return Error(StatusCode::kDeadlineExceeded, "no message within {} s", timeout_s);
}

Result<Message> Inbox::NextOf(uint32_t epoch, double limit_s) {
  std::unique_lock lock(mutex_);
  const auto superseded = [&] {
    return newest_epoch_ > epoch || cancelled_epoch_ == epoch ||
           (!failure_.ok() && waiting_.empty());
  };
  changed_.wait_for(lock, std::chrono::duration<double>(limit_s),
                    [&] { return superseded() || !waiting_.empty(); });
  if (superseded()) return Error(StatusCode::kCancelled, "no longer wanted");
  if (waiting_.empty())
    return Error(StatusCode::kDeadlineExceeded, "no answer within {} s", limit_s);
  Message message = std::move(waiting_.front());
  waiting_.pop_front();
  changed_.notify_all();
  return message;
}

bool Inbox::Superseded(uint32_t epoch) const {
  std::lock_guard lock(mutex_);
  return newest_epoch_ > epoch || cancelled_epoch_ == epoch || !failure_.ok();
}

}  // namespace isolux
