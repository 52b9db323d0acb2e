// A MessagePort over one stream: what the coordinator's and the worker's sessions have in common.
// Knows no gRPC; the stream itself is a StreamWire, one for the server's side, one for the
// client's.
//
// Threads: Send and Receive are called by those who own the port, the On… functions by the wire's
// reactions, one at a time for reads and one at a time for writes. Nothing here blocks but Send
// (outbox full) and Receive.
//
// The outbox is bounded: Send waits. The inbox is bounded: the next read starts only when there is
// room, so that a fast peer is slowed down by the stream's flow control.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>

#include "common/rpc/frame.h"
#include "common/rpc/message_port.h"
#include "common/util/status.h"

namespace isolux {

// The stream. All calls return at once; none is made after Finish.
class StreamWire {
 public:
  virtual ~StreamWire() = default;
  // One write and one read at a time; answered by OnWriteDone, OnFrame/OnControl/OnReadEnd.
  virtual void StartWrite(FrameData frame) = 0;
  virtual void
  StartControl() = 0;  // a greeting or heartbeat, as the wire sees fit; counts as a write
  virtual void StartRead() = 0;
  // Makes reads and writes under way fail soon.
  virtual void Abort() = 0;
  // Ends this side in order. No write is under way. The wire may go away any time after it.
  virtual void Finish(const Status& status) = 0;
};

class StreamPort final : public MessagePort {
 public:
  struct Limits {
    uint64_t outbox_bytes = 32ULL << 20;  // beyond which Send waits
    uint64_t inbox_bytes = 64ULL << 20;   // beyond which reading waits
    uint64_t max_message_bytes = kMaxMessageBytes;
  };

  // `peer` stands in messages: "worker 'a' (3)". The wire stays until its Finish.
  StreamPort(StreamWire* wire, std::string peer, Limits limits);

  Status Send(Message message) override;
  Result<Message> Receive(double timeout_s) override;
  void Close(const Status& reason) override;
  uint64_t bytes_sent() const override;
  uint64_t bytes_received() const override;

  // Gives the peer up: what waits is dropped. For a peer that is silent, or for a quick end.
  void Abort(const Status& why);

  // Starts the first read.
  void Start();
  void OnFrame(FrameData frame);
  void OnControl();
  // The peer sends no more; `why` for messages.
  void OnReadEnd(const Status& why);
  void OnWriteDone(bool ok);

  // Has the wire send a greeting or heartbeat, ahead of the frames that wait.
  void SendControl();
  // Since something was heard of the peer; 0 while reading waits for room.
  double SilenceSeconds() const;
  bool gone() const;  // nothing more can be sent

 private:
  using Clock = std::chrono::steady_clock;

  // These three need mutex_.
  void ContinueWriting();
  void ContinueReading();
  void GiveUp(const Status& why, bool abort = true);
  // Finishes the wire if it is time to. Takes the lock and lets it go for the call.
  void FinishIfDue(std::unique_lock<std::mutex>& lock);

  const std::string peer_;
  const Limits limits_;

  mutable std::mutex mutex_;
  std::condition_variable writable_, readable_;
  // Guarded by mutex_.
  StreamWire* wire_;
  FrameCutter outbox_;
  FrameJoiner joiner_;
  std::deque<Message> inbox_;
  uint64_t inbox_bytes_ = 0;
  uint64_t bytes_sent_ = 0, bytes_received_ = 0;
  Clock::time_point heard_ = Clock::now();
  bool writing_ = false, reading_ = false, control_due_ = false;
  bool closing_ = false;   // by Close: the outbox is still emptied
  bool gone_ = false;      // peer ended, stream broken or given up: nothing more is sent or read
  bool finished_ = false;  // the wire has been told; it may no longer exist
  Status reason_;          // why closing_ or gone_
};

}  // namespace isolux
