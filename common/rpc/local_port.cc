#include "common/rpc/local_port.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>

namespace isolux {
namespace {

// One direction.
struct Queue {
  std::deque<Message> messages;
  uint64_t bytes = 0;        // waiting
  uint64_t total_bytes = 0;  // ever
};

struct Pair {
  explicit Pair(const LocalPortLimits& l) : limits(l) {}

  const LocalPortLimits limits;
  std::mutex mutex;
  std::condition_variable changed;
  // Guarded by mutex.
  std::array<Queue, 2> to;  // to[i]: what port i receives
  bool closed = false;
  Status reason;
};

class LocalPort final : public MessagePort {
 public:
  LocalPort(std::shared_ptr<Pair> pair, int self) : pair_(std::move(pair)), self_(self) {}
  ~LocalPort() override { Close(Status(StatusCode::kUnavailable, "the peer has left")); }

  Status Send(Message message) override {
    std::unique_lock lock(pair_->mutex);
    Queue& queue = pair_->to[1 - self_];
    pair_->changed.wait(lock, [&] {
      return pair_->closed || queue.messages.empty() ||
             (queue.messages.size() < pair_->limits.messages && queue.bytes < pair_->limits.bytes);
    });
    if (pair_->closed) return pair_->reason;
    queue.bytes += message.payload.size();
    queue.total_bytes += message.payload.size();
    queue.messages.push_back(std::move(message));
    pair_->changed.notify_all();
    return {};
  }

  Result<Message> Receive(double timeout_s) override {
    std::unique_lock lock(pair_->mutex);
    Queue& queue = pair_->to[self_];
    const bool ready = pair_->changed.wait_for(lock, std::chrono::duration<double>(timeout_s), [&] {
      return pair_->closed || !queue.messages.empty();
    });
    if (!queue.messages.empty()) {
      Message message = std::move(queue.messages.front());
      queue.messages.pop_front();
      queue.bytes -= message.payload.size();
      pair_->changed.notify_all();
      return message;
    }
    if (ready) return tl::unexpected<Status>(pair_->reason);
    return Error(StatusCode::kDeadlineExceeded, "no message within {} s", timeout_s);
  }

  void Close(const Status& reason) override {
    std::lock_guard lock(pair_->mutex);
    if (pair_->closed) return;
    pair_->closed = true;
    pair_->reason = Status(StatusCode::kUnavailable, reason.ok() ? "closed" : reason.message());
    pair_->changed.notify_all();
  }

  uint64_t bytes_sent() const override {
    std::lock_guard lock(pair_->mutex);
    return pair_->to[1 - self_].total_bytes;
  }
  uint64_t bytes_received() const override {
    std::lock_guard lock(pair_->mutex);
    return pair_->to[self_].total_bytes - pair_->to[self_].bytes;
  }

 private:
  const std::shared_ptr<Pair> pair_;
  const int self_;
};

}  // namespace

std::pair<std::unique_ptr<MessagePort>, std::unique_ptr<MessagePort>> MakeLocalPorts(
    const LocalPortLimits& limits) {
  const auto pair = std::make_shared<Pair>(limits);
  return {std::make_unique<LocalPort>(pair, 0), std::make_unique<LocalPort>(pair, 1)};
}

}  // namespace isolux
