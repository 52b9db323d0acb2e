// A pair of message ports in one process, over bounded queues: for tests, and for solving without a
// network. Sending blocks while the peer's queue is full.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "common/rpc/message_port.h"

namespace isolux {

struct LocalPortLimits {
  size_t messages = 64;
  uint64_t bytes = 32ULL << 20;  // of payload; one message is taken whatever its size
};

std::pair<std::unique_ptr<MessagePort>, std::unique_ptr<MessagePort>> MakeLocalPorts(
    const LocalPortLimits& limits = {});

}  // namespace isolux
