// The worker's end of the stream to the coordinator: a MessagePort that is connected, says hello,
// and lets something be heard regularly, whatever the worker is busy with.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/rpc/channel.h"
#include "common/rpc/message_port.h"
#include "common/rpc/stream_port.h"
#include "common/util/status.h"

namespace isolux {

struct WorkerIdentity {
  std::string name;  // for people; empty: the coordinator gives one
  uint32_t threads = 1;
};

class WorkerSession {
 public:
  // Connects and waits for the coordinator's welcome, at most `timeout_s`. kUnavailable when nobody
  // answers at the address; kFailedPrecondition when the coordinator refuses this build.
  static Result<std::unique_ptr<WorkerSession>> Connect(const ChannelOptions& options,
                                                        const WorkerIdentity& identity,
                                                        double timeout_s,
                                                        StreamPort::Limits limits = {});
  ~WorkerSession();  // ends the stream; what was sent before Close still goes out
  WorkerSession(const WorkerSession&) = delete;
  WorkerSession& operator=(const WorkerSession&) = delete;

  MessagePort& port();
  uint64_t id() const;  // as the coordinator counts connections

 private:
  class Reactor;
  WorkerSession();

  std::unique_ptr<Reactor> reactor_;
};

}  // namespace isolux
