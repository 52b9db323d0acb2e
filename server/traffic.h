// Bytes of payload between the coordinator and its workers, per worker and phase.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "common/rpc/protocol.h"

namespace isolux {

enum class Phase {
  kStart,
  kScene,
  kReduce,
  kSubscribe,
  kValues,
  kSums,
  kReport,
  kSnapshot,
  kMigrate,
  kGather
};
inline constexpr int kPhaseCount = 10;
const char* ToText(Phase phase);
Phase PhaseOf(MessageKind kind);

struct PhaseBytes {
  uint64_t in = 0, out = 0;  // as the coordinator sees it
  uint64_t messages_in = 0, messages_out = 0;
};

struct Traffic {
  // By the worker's connection (WorkerSlot::id).
  std::map<uint64_t, std::array<PhaseBytes, kPhaseCount>> by_worker;
  uint64_t stale_messages = 0;  // of an old epoch, dropped

  PhaseBytes Total(Phase phase) const;
  PhaseBytes Total() const;
};

}  // namespace isolux
