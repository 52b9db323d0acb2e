// The messages between the coordinator and a worker: their kinds, their contents as plain structs,
// and the way to bytes and back. Knows protobuf (in the .cc alone), not gRPC.
//
//   coordinator                                    worker
//     StartJob                     ──▶
//                                  ◀──  NeedScene            (scene not cached)
//     SceneData                    ──▶
//                                  ◀──  Started
//     Round                        ──▶
//                                  ◀──  Reduce | Subscribe | Values | Sums   ┐ collectives, as
//                                  often
//     …Reply                       ──▶                                       ┘ as the round has
//     them
//                                  ◀──  RoundReport, SnapshotPart            (or Replayed)
//     InstallSnapshot              ──▶
//     CountErrors                  ──▶
//                                  ◀──  LinkErrors
//     Gather                       ──▶                       (of a sample of leaves)
//                                  ◀──  GatherPart
//     Reassign                     ──▶                       (when nodes change home)
//                                  ◀──  Parcels
//     Absorb                       ──▶
//     Gather                       ──▶
//                                  ◀──  GatherPart
//     SolveGroup                   ──▶                       (of bands, one after the other)
//                                  ◀──  collectives, RoundReport, SnapshotPart
//     InstallSnapshot, Gather      ──▶
//                                  ◀──  GatherPart
//     EndJob | CancelJob           ──▶
//
// Any time during a job a worker may say Progress, Drain or Failed, and be told CancelJob or, once
// it has no nodes, Release. StartJob of a newer epoch ends whatever was under way.
//
// Decoders check every length; a malformed message gives kDataLoss or kInvalidArgument.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/collectives.h"
#include "common/hierarchy/node_id.h"
#include "common/hierarchy/shard_data.h"
#include "common/rpc/message_port.h"
#include "common/scene/solve_options.h"
#include "common/util/status.h"

namespace isolux {

enum class MessageKind : uint32_t {
  // Coordinator to worker.
  kStartJob = 1,
  kSceneData = 2,
  kRound = 3,
  kReduceReply = 4,
  kSubscribeReply = 5,
  kValuesReply = 6,
  kSumsReply = 7,
  kInstallSnapshot = 8,
  kReassign = 9,
  kAbsorb = 10,
  kGather = 11,
  kEndJob = 12,
  kCancelJob = 13,
  kRelease = 14,
  kCountErrors = 15,
  kSolveGroup = 16,
  // Worker to coordinator.
  kNeedScene = 32,
  kStarted = 33,
  kReduce = 34,
  kSubscribe = 35,
  kValues = 36,
  kSums = 37,
  kRoundReport = 38,
  kReplayed = 39,
  kSnapshotPart = 40,
  kParcels = 41,
  kGatherPart = 42,
  kDrain = 43,
  kFailed = 44,
  kProgress = 45,
  kLinkErrors = 46,
};
const char* ToText(MessageKind kind);  // "Round"; "unknown message" for other numbers

inline constexpr uint32_t kMaxWorkers = 4096;  // in one job

struct StartJob {
  uint64_t job = 0;
  std::string scene_hash;
  SolveOptions options;
  Assignment assignment;
  uint32_t self = 0;
  std::vector<MeasuredEffect> measured;  // in a first round of the job that is done
};

struct NeedScene {
  std::string scene_hash;
};

struct SceneData {
  std::string scene_hash;
  std::string scene;  // encoded
};

struct Started {
  std::array<double, 3> emitted_w{};
};

struct RoundCommand {
  uint32_t round = 0;
  double epsilon = 0;   // W
  double accuracy = 0;  // sets where the solver stops
  bool replay = false;
};

// Of bands (common/scene/bands.h).
struct SolveGroup {
  uint32_t group = 0;
  double accuracy = 0;  // sets where the solver stops
  std::string start;    // snapshot, encoded
};

struct SubscribeRequest {
  std::vector<std::vector<NodeId>> wanted;  // by home
};

struct SubscribeReply {
  std::vector<NodeId> exported;
};

struct Values {
  std::vector<double> own_cut, exported;
};

struct ValuesReply {
  std::vector<double> other_cut;  // of the cut nodes homed elsewhere, in the order of the cut
  std::vector<double> proxies;
};

struct Sums {
  std::vector<int64_t> crown, proxies;
};

struct SumsReply {
  std::vector<int64_t> crown, exported;
};

struct Replayed {
  uint32_t round = 0;
};

struct SnapshotData {
  std::string snapshot;  // encoded
};

struct Reassign {
  Assignment assignment;
};

struct Parcels {
  std::vector<MigrationParcel> parcels;
};

struct Absorb {
  std::vector<std::string> parcels;
};

struct GatherRequest {
  std::vector<NodeId> elements;
  double accuracy = 0;
  std::vector<uint8_t> corners;  // wanted, by bits, or kCentre, one an element; empty: all
};

struct LinkErrors {
  ErrorHistogram histogram;
  uint64_t memory_bytes = 0;  // of links, nodes and snapshot
};

struct EndJob {
  uint64_t job = 0;
};

struct Failed {
  Status status;
};

struct Progress {
  uint64_t job = 0;
  uint32_t round = 0;
  double cpu_s = 0;  // of the process so far
};

std::string Encode(const StartJob& message);
std::string Encode(const NeedScene& message);
std::string Encode(const SceneData& message);
std::string Encode(const Started& message);
std::string Encode(const RoundCommand& message);
std::string Encode(const SolveGroup& message);
std::string Encode(const Reduction& message);
std::string Encode(const SubscribeRequest& message);
std::string Encode(const SubscribeReply& message);
std::string Encode(const Values& message);
std::string Encode(const ValuesReply& message);
std::string Encode(const Sums& message);
std::string Encode(const SumsReply& message);
std::string Encode(const RoundReport& message);
std::string Encode(const Replayed& message);
std::string Encode(const SnapshotData& message);
std::string Encode(const Reassign& message);
std::string Encode(const Parcels& message);
std::string Encode(const Absorb& message);
std::string Encode(const GatherRequest& message);
std::string Encode(const GatherPart& message);
std::string Encode(const LinkErrors& message);
std::string Encode(const EndJob& message);
std::string Encode(const Failed& message);
std::string Encode(const Progress& message);

// DecodeMessage<T>(payload) for every T above.
template <typename T>
Result<T> DecodeMessage(const std::string& payload);

// The same straight from the arrays, for what is sent thousands of times.
std::string EncodeValues(std::span<const double> own_cut, std::span<const double> exported);
std::string EncodeSums(std::span<const int64_t> crown, std::span<const int64_t> proxies);

// A message of this kind and epoch.
template <typename T>
Message MakeMessage(MessageKind kind, uint32_t epoch, const T& content) {
  return {static_cast<uint32_t>(kind), epoch, Encode(content)};
}

}  // namespace isolux
