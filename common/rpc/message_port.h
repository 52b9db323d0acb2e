// One end of a two-way channel of whole messages between the coordinator and one worker. The
// session over gRPC is one implementation, a pair of queues in one process another: everything
// above it is the same in both, and is tested without a network.
//
// Send and Close may be called by any thread, Receive by one at a time.
#pragma once

#include <cstdint>
#include <string>

#include "common/util/status.h"

namespace isolux {

struct Message {
  uint32_t kind = 0;    // what it is: see protocol.h
  uint32_t epoch = 0;   // membership it belongs to; receivers drop what is older
  std::string payload;  // an encoded protocol message
};

class MessagePort {
 public:
  virtual ~MessagePort() = default;

  // Queues the message; blocks while the bounded outbox is full. kUnavailable once the peer is
  // gone.
  virtual Status Send(Message message) = 0;

  // The next message in order. kDeadlineExceeded after `timeout_s`, kUnavailable once the peer is
  // gone and everything it sent has been handed out.
  virtual Result<Message> Receive(double timeout_s) = 0;

  // Ends the channel from this side; the peer's Receive fails after what was sent before.
  virtual void Close(const Status& reason) = 0;

  // Bytes of payload sent and received so far.
  virtual uint64_t bytes_sent() const = 0;
  virtual uint64_t bytes_received() const = 0;
};

}  // namespace isolux
