// Whole messages cut into frames for a stream, and joined again at its other end. Both ends belong
// to one direction of one connection and are used by one thread at a time.
//
//   message of 600 KiB  ─▶  [n: 256 KiB] [n+1: 256 KiB] [n+2: 88 KiB, last]
//
// The joiner trusts nothing: numbers must follow on each other, a message's frames must agree, and
// its size is declared in the first frame, checked against the limit and kept to.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "common/rpc/message_port.h"
#include "common/util/status.h"

namespace isolux {

inline constexpr size_t kFrameBytes = size_t{256} << 10;
// Of one message; the largest are scenes and snapshots. Below the 2 GiB of a protobuf message.
inline constexpr uint64_t kMaxMessageBytes = (1ULL << 31) - (1ULL << 20);

struct FrameData {
  uint32_t epoch = 0;
  uint64_t sequence = 0;  // from 1, without gaps
  uint32_t kind = 0;
  bool last = false;
  std::string data;
  uint64_t message_bytes = 0;  // in the first frame of a message; 0 in the others
};

// Holds the messages that wait, and gives them out frame by frame.
class FrameCutter {
 public:
  void Add(Message message);
  // The next frame; none when nothing waits.
  std::optional<FrameData> Next();

  uint64_t waiting_bytes() const { return waiting_bytes_; }  // of payload not given out yet
  bool empty() const { return messages_.empty(); }

 private:
  std::deque<Message> messages_;
  uint64_t offset_ = 0;  // in the first of them
  uint64_t sequence_ = 0;
  uint64_t waiting_bytes_ = 0;
};

class FrameJoiner {
 public:
  explicit FrameJoiner(uint64_t max_message_bytes = kMaxMessageBytes)
      : max_message_bytes_(max_message_bytes) {}

  // Takes the next frame; gives the message that it completes, if it completes one. After an error
  // the connection is of no more use.
  Result<std::optional<Message>> Add(FrameData frame);

 private:
  uint64_t max_message_bytes_;
  uint64_t sequence_ = 0;
  bool begun_ = false;
  uint64_t expected_bytes_ = 0;
  Message message_;
};

}  // namespace isolux
