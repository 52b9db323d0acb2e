#include "server/snapshot_parts.h"

#include <utility>
#include <vector>

namespace isolux {

Result<Snapshot> CollectSnapshot(Crew& crew, uint32_t surfaces, uint32_t round, double epsilon) {
  ASSIGN_OR_RETURN(const auto messages, crew.CollectAll(MessageKind::kSnapshotPart));
  std::vector<Snapshot> parts;
  for (const auto& message : messages) {
    if (!message) continue;
    ASSIGN_OR_RETURN(const SnapshotData data, DecodeMessage<SnapshotData>(message->payload));
    ASSIGN_OR_RETURN(Snapshot part, DecodeSnapshot(data.snapshot));
    parts.push_back(std::move(part));
  }
  ASSIGN_OR_RETURN(Snapshot merged, MergeSnapshots(std::move(parts), surfaces));
  if (merged.round == round && merged.epsilon == epsilon) return merged;
  return Error(StatusCode::kInternal, "a snapshot of round {} after round {}", merged.round, round);
}

}  // namespace isolux
