#include "server/traffic.h"

namespace isolux {

const char* ToText(Phase phase) {
  switch (phase) {
    case Phase::kStart:
      return "start";
    case Phase::kScene:
      return "scene";
    case Phase::kReduce:
      return "reduce";
    case Phase::kSubscribe:
      return "subscribe";
    case Phase::kValues:
      return "values";
    case Phase::kSums:
      return "sums";
    case Phase::kReport:
      return "report";
    case Phase::kSnapshot:
      return "snapshot";
    case Phase::kMigrate:
      return "migrate";
    case Phase::kGather:
      return "gather";
  }
  return "unknown";
}

Phase PhaseOf(MessageKind kind) {
  switch (kind) {
    case MessageKind::kNeedScene:
    case MessageKind::kSceneData:
      return Phase::kScene;
    case MessageKind::kReduce:
    case MessageKind::kReduceReply:
      return Phase::kReduce;
    case MessageKind::kSubscribe:
    case MessageKind::kSubscribeReply:
      return Phase::kSubscribe;
    case MessageKind::kValues:
    case MessageKind::kValuesReply:
      return Phase::kValues;
    case MessageKind::kSums:
    case MessageKind::kSumsReply:
      return Phase::kSums;
    case MessageKind::kRoundReport:
    case MessageKind::kReplayed:
    case MessageKind::kCountErrors:
    case MessageKind::kLinkErrors:
    case MessageKind::kProgress:
    case MessageKind::kFailed:
      return Phase::kReport;
    case MessageKind::kSnapshotPart:
    case MessageKind::kInstallSnapshot:
    case MessageKind::kSolveGroup:
      return Phase::kSnapshot;
    case MessageKind::kReassign:
    case MessageKind::kParcels:
    case MessageKind::kAbsorb:
      return Phase::kMigrate;
    case MessageKind::kGather:
    case MessageKind::kGatherPart:
      return Phase::kGather;
    default:
      return Phase::kStart;
  }
}

PhaseBytes Traffic::Total(Phase phase) const {
  PhaseBytes total;
  for (const auto& [worker, phases] : by_worker) {
    const PhaseBytes& bytes = phases[static_cast<size_t>(phase)];
    total.in += bytes.in;
    total.out += bytes.out;
    total.messages_in += bytes.messages_in;
    total.messages_out += bytes.messages_out;
  }
  return total;
}

PhaseBytes Traffic::Total() const {
  PhaseBytes total;
  for (int i = 0; i < kPhaseCount; ++i) {
    const PhaseBytes bytes = Total(static_cast<Phase>(i));
    total.in += bytes.in;
    total.out += bytes.out;
    total.messages_in += bytes.messages_in;
    total.messages_out += bytes.messages_out;
  }
  return total;
}

}  // namespace isolux
