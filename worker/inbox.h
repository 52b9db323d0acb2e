// What has arrived at a worker and waits for its main thread. A reader thread takes messages from
// the port at once, so that the sender never waits for a computation, and a computation can be told
// that it is no longer wanted.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>

#include "common/rpc/message_port.h"
#include "common/util/status.h"

namespace isolux {

class Inbox {
 public:
  // Starts the reader. `stale` counts messages of an old epoch, which are dropped.
  Inbox(MessagePort& port, std::atomic<uint64_t>& stale);
  // Closes the port and ends the reader.
  ~Inbox();
  Inbox(const Inbox&) = delete;
  Inbox& operator=(const Inbox&) = delete;

  // The next message of the newest epoch. kDeadlineExceeded after `timeout_s`; the port's error
  // once it has failed and nothing waits any more.
  Result<Message> Next(double timeout_s);

  // The next message of this epoch, for work in progress: kCancelled as soon as the work is
  // superseded, kDeadlineExceeded after `limit_s`.
  Result<Message> NextOf(uint32_t epoch, double limit_s);

  // Whether work of this epoch is no longer wanted: cancelled, a newer epoch, or nobody left to
  // report to. Any thread.
  bool Superseded(uint32_t epoch) const;

 private:
  // More waiting messages than any exchange has; reading pauses there.
  static constexpr size_t kMaxWaiting = 1024;

  void Read();
  void Take(Message message);  // with mutex_ held

  MessagePort& port_;
  std::atomic<uint64_t>& stale_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by mutex_.
  std::deque<Message> waiting_;
  uint32_t newest_epoch_ = 0;
  uint32_t cancelled_epoch_ = 0;
  Status failure_;  // of the port
  bool stop_ = false;

  std::thread reader_;  // last: started when all else is there
};

}  // namespace isolux
