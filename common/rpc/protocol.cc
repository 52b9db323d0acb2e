// The messages about jobs, rounds, snapshots and migration; those of the collectives, and the bulk
// of the gather, are in protocol_bulk.cc.
#include "common/rpc/protocol.h"

#include <cmath>
#include <utility>

#include "common/rpc/convert_nodes.h"
#include "common/rpc/convert_options.h"
#include "common/scene/bands.h"
#include "isolux/v1/worker_messages.pb.h"

namespace isolux {
namespace {

constexpr size_t kHashDigits = 32;

template <typename Proto>
Status Parse(const std::string& payload, const char* what, Proto* message) {
  if (message->ParseFromString(payload)) return {};
  return MakeStatus(StatusCode::kDataLoss, "{}: {} bytes that are no such message", what,
                    payload.size());
}

Status CheckHash(const std::string& hash, const char* what) {
  if (hash.size() == kHashDigits) return {};
  return MakeStatus(StatusCode::kDataLoss, "{}: a scene hash has {} digits, not {}", what,
                    kHashDigits, hash.size());
}

struct KindName {
  MessageKind kind;
  const char* name;
};
constexpr KindName kNames[] = {
    {MessageKind::kStartJob, "StartJob"},
    {MessageKind::kSceneData, "SceneData"},
    {MessageKind::kRound, "Round"},
    {MessageKind::kReduceReply, "ReduceReply"},
    {MessageKind::kSubscribeReply, "SubscribeReply"},
    {MessageKind::kValuesReply, "ValuesReply"},
    {MessageKind::kSumsReply, "SumsReply"},
    {MessageKind::kInstallSnapshot, "InstallSnapshot"},
    {MessageKind::kReassign, "Reassign"},
    {MessageKind::kAbsorb, "Absorb"},
    {MessageKind::kGather, "Gather"},
    {MessageKind::kEndJob, "EndJob"},
    {MessageKind::kCancelJob, "CancelJob"},
    {MessageKind::kRelease, "Release"},
    {MessageKind::kCountErrors, "CountErrors"},
    {MessageKind::kSolveGroup, "SolveGroup"},
    {MessageKind::kNeedScene, "NeedScene"},
    {MessageKind::kStarted, "Started"},
    {MessageKind::kReduce, "Reduce"},
    {MessageKind::kSubscribe, "Subscribe"},
    {MessageKind::kValues, "Values"},
    {MessageKind::kSums, "Sums"},
    {MessageKind::kRoundReport, "RoundReport"},
    {MessageKind::kReplayed, "Replayed"},
    {MessageKind::kSnapshotPart, "SnapshotPart"},
    {MessageKind::kParcels, "Parcels"},
    {MessageKind::kGatherPart, "GatherPart"},
    {MessageKind::kDrain, "Drain"},
    {MessageKind::kFailed, "Failed"},
    {MessageKind::kProgress, "Progress"},
    {MessageKind::kLinkErrors, "LinkErrors"},
};

}  // namespace

const char* ToText(MessageKind kind) {
  for (const KindName& entry : kNames) {
    if (entry.kind == kind) return entry.name;
  }
  return "unknown message";
}

std::string Encode(const StartJob& message) {
  v1::StartJob proto;
  proto.set_job(message.job);
  proto.set_scene_hash(message.scene_hash);
  *proto.mutable_options() = ToProto(message.options);
  ToProto(message.assignment, proto.mutable_assignment());
  proto.set_self(message.self);
  PutMeasured(message.measured, proto.mutable_measured());
  return proto.SerializeAsString();
}

template <>
Result<StartJob> DecodeMessage(const std::string& payload) {
  v1::StartJob proto;
  RETURN_IF_ERROR(Parse(payload, "StartJob", &proto));
  RETURN_IF_ERROR(CheckHash(proto.scene_hash(), "StartJob"));
  StartJob message{proto.job(), proto.scene_hash(), {}, {}, proto.self(), {}};
  ASSIGN_OR_RETURN(message.measured, TakeMeasured(proto.measured()));
  ASSIGN_OR_RETURN(message.options, FromProto(proto.options()));
  RETURN_IF_ERROR(FromProto(proto.assignment(), "StartJob", &message.assignment));
  if (message.self >= message.assignment.worker_count) {
    return Error(StatusCode::kDataLoss, "StartJob: worker {} of {}", message.self,
                 message.assignment.worker_count);
  }
  return message;
}

std::string Encode(const NeedScene& message) {
  v1::NeedScene proto;
  proto.set_scene_hash(message.scene_hash);
  return proto.SerializeAsString();
}

template <>
Result<NeedScene> DecodeMessage(const std::string& payload) {
  v1::NeedScene proto;
  RETURN_IF_ERROR(Parse(payload, "NeedScene", &proto));
  RETURN_IF_ERROR(CheckHash(proto.scene_hash(), "NeedScene"));
  return NeedScene{proto.scene_hash()};
}

std::string Encode(const SceneData& message) {
  v1::SceneData proto;
  proto.set_scene_hash(message.scene_hash);
  proto.set_scene(message.scene);
  return proto.SerializeAsString();
}

template <>
Result<SceneData> DecodeMessage(const std::string& payload) {
  v1::SceneData proto;
  RETURN_IF_ERROR(Parse(payload, "SceneData", &proto));
  RETURN_IF_ERROR(CheckHash(proto.scene_hash(), "SceneData"));
  return SceneData{proto.scene_hash(), std::move(*proto.mutable_scene())};
}

std::string Encode(const Started& message) {
  v1::Started proto;
  proto.set_emitted_w(ToBytes(message.emitted_w));
  return proto.SerializeAsString();
}

template <>
Result<Started> DecodeMessage(const std::string& payload) {
  v1::Started proto;
  RETURN_IF_ERROR(Parse(payload, "Started", &proto));
  Started message;
  RETURN_IF_ERROR(FromBytes(proto.emitted_w(), "Started", &message.emitted_w));
  return message;
}

std::string Encode(const RoundCommand& message) {
  v1::RoundCommand proto;
  proto.set_round(message.round);
  proto.set_epsilon(message.epsilon);
  proto.set_accuracy(message.accuracy);
  proto.set_replay(message.replay);
  return proto.SerializeAsString();
}

template <>
Result<RoundCommand> DecodeMessage(const std::string& payload) {
  v1::RoundCommand proto;
  RETURN_IF_ERROR(Parse(payload, "Round", &proto));
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (proto.round() == 0 || !positive(proto.epsilon()) || !positive(proto.accuracy())) {
    return Error(StatusCode::kDataLoss, "Round: round {}, threshold {} W, accuracy {}",
                 proto.round(), proto.epsilon(), proto.accuracy());
  }
  return RoundCommand{proto.round(), proto.epsilon(), proto.accuracy(), proto.replay()};
}

std::string Encode(const SolveGroup& message) {
  v1::SolveGroup proto;
  proto.set_group(message.group);
  proto.set_accuracy(message.accuracy);
  proto.set_start(message.start);
  return proto.SerializeAsString();
}

template <>
Result<SolveGroup> DecodeMessage(const std::string& payload) {
  v1::SolveGroup proto;
  RETURN_IF_ERROR(Parse(payload, "SolveGroup", &proto));
  if (proto.group() >= kMostBands || !(proto.accuracy() > 0 && proto.accuracy() <= 1)) {
    return Error(StatusCode::kDataLoss, "SolveGroup: group {}, accuracy {}", proto.group(),
                 proto.accuracy());
  }
  return SolveGroup{proto.group(), proto.accuracy(), std::move(*proto.mutable_start())};
}

std::string Encode(const RoundReport& message) {
  v1::RoundReport proto;
  proto.set_round(message.round);
  proto.set_epsilon(message.epsilon);
  proto.set_error_estimate(message.error_estimate);
  proto.set_error_spread(message.error_spread);
  proto.set_error_visibility(message.error_visibility);
  proto.set_error_coupling(message.error_coupling);
  proto.set_error_solver(message.error_solver);
  proto.set_residual(message.residual);
  proto.set_energy_imbalance(message.energy_imbalance);
  proto.set_iterations(message.iterations);
  proto.set_emitted_w(ToBytes(message.emitted_w));
  proto.set_absorbed_w(ToBytes(message.absorbed_w));
  proto.set_escaped_w(ToBytes(message.escaped_w));
  if (message.medium_w != decltype(message.medium_w){}) {
    proto.set_medium_w(ToBytes(message.medium_w));
  }
  if (message.glass_w != decltype(message.glass_w){}) {
    proto.set_glass_w(ToBytes(message.glass_w));
  }
  proto.set_crown_hash(message.crown_hash);
  proto.set_links(message.links);
  proto.set_leaves(message.leaves);
  proto.set_evaluations(message.evaluations);
  proto.set_proved_visible(message.proved_visible);
  proto.set_proved_hidden(message.proved_hidden);
  proto.set_rays(message.rays);
  proto.set_memory_bytes(message.memory_bytes);
  proto.set_refine_s(message.refine_s);
  proto.set_exchange_s(message.exchange_s);
  proto.set_solve_s(message.solve_s);
  proto.set_cpu_s(message.cpu_s);
  proto.set_leaks(message.leaks.leaves);
  proto.set_leak_area(message.leaks.area_share);
  proto.set_error_closure(message.error_closure);
  proto.set_error_rms(message.error_rms);
  v1::LocalErrors* local = proto.mutable_local_errors();
  local->set_area(ToBytes(message.local_errors.area));
  local->set_worst(message.local_errors.worst);
  local->set_worst_surface(message.local_errors.worst_leaf.surface);
  local->set_worst_path(message.local_errors.worst_leaf.path);
  PutMeasured(message.measured, proto.mutable_measured());
  PutCosts(message.costs, proto.mutable_costs());
  proto.set_cut_cost_ns(ToBytes(message.cut_cost_ns));
  proto.set_cut_links(ToBytes(message.cut_links));
  proto.set_cut_elements(ToBytes(message.cut_elements));
  return proto.SerializeAsString();
}

template <>
Result<RoundReport> DecodeMessage(const std::string& payload) {
  constexpr const char* kWhat = "RoundReport";
  v1::RoundReport proto;
  RETURN_IF_ERROR(Parse(payload, kWhat, &proto));
  RoundReport message;
  message.round = proto.round();
  message.epsilon = proto.epsilon();
  message.error_estimate = proto.error_estimate();
  message.error_spread = proto.error_spread();
  message.error_visibility = proto.error_visibility();
  message.error_coupling = proto.error_coupling();
  message.error_solver = proto.error_solver();
  message.residual = proto.residual();
  message.energy_imbalance = proto.energy_imbalance();
  message.iterations = proto.iterations();
  RETURN_IF_ERROR(FromBytes(proto.emitted_w(), kWhat, &message.emitted_w));
  RETURN_IF_ERROR(FromBytes(proto.absorbed_w(), kWhat, &message.absorbed_w));
  RETURN_IF_ERROR(FromBytes(proto.escaped_w(), kWhat, &message.escaped_w));
  if (!proto.medium_w().empty()) {
    RETURN_IF_ERROR(FromBytes(proto.medium_w(), kWhat, &message.medium_w));
  }
  if (!proto.glass_w().empty()) {
    RETURN_IF_ERROR(FromBytes(proto.glass_w(), kWhat, &message.glass_w));
  }
  message.crown_hash = proto.crown_hash();
  message.links = proto.links();
  message.leaves = proto.leaves();
  message.evaluations = proto.evaluations();
  message.proved_visible = proto.proved_visible();
  message.proved_hidden = proto.proved_hidden();
  message.rays = proto.rays();
  message.memory_bytes = proto.memory_bytes();
  message.refine_s = proto.refine_s();
  message.exchange_s = proto.exchange_s();
  message.solve_s = proto.solve_s();
  message.cpu_s = proto.cpu_s();
  message.leaks = {proto.leaks(), proto.leak_area()};
  message.error_closure = proto.error_closure();
  message.error_rms = proto.error_rms();
  const v1::LocalErrors& local = proto.local_errors();
  RETURN_IF_ERROR(FromBytes(local.area(), kWhat, &message.local_errors.area));
  message.local_errors.worst = local.worst();
  message.local_errors.worst_leaf = {local.worst_surface(), local.worst_path()};
  ASSIGN_OR_RETURN(message.measured, TakeMeasured(proto.measured()));
  ASSIGN_OR_RETURN(message.costs, TakeCosts(proto.costs()));
  RETURN_IF_ERROR(FromBytes(proto.cut_cost_ns(), kWhat, &message.cut_cost_ns));
  RETURN_IF_ERROR(FromBytes(proto.cut_links(), kWhat, &message.cut_links));
  RETURN_IF_ERROR(FromBytes(proto.cut_elements(), kWhat, &message.cut_elements));
  return message;
}

std::string Encode(const LinkErrors& message) {
  v1::LinkErrors proto;
  proto.set_count(ToBytes(message.histogram.count));
  proto.set_memory_bytes(message.memory_bytes);
  return proto.SerializeAsString();
}

template <>
Result<LinkErrors> DecodeMessage(const std::string& payload) {
  v1::LinkErrors proto;
  RETURN_IF_ERROR(Parse(payload, "LinkErrors", &proto));
  LinkErrors message;
  RETURN_IF_ERROR(FromBytes(proto.count(), "LinkErrors", &message.histogram.count));
  message.memory_bytes = proto.memory_bytes();
  return message;
}

std::string Encode(const Replayed& message) {
  v1::Replayed proto;
  proto.set_round(message.round);
  return proto.SerializeAsString();
}

template <>
Result<Replayed> DecodeMessage(const std::string& payload) {
  v1::Replayed proto;
  RETURN_IF_ERROR(Parse(payload, "Replayed", &proto));
  return Replayed{proto.round()};
}

std::string Encode(const SnapshotData& message) {
  v1::SnapshotData proto;
  proto.set_snapshot(message.snapshot);
  return proto.SerializeAsString();
}

template <>
Result<SnapshotData> DecodeMessage(const std::string& payload) {
  v1::SnapshotData proto;
  RETURN_IF_ERROR(Parse(payload, "Snapshot", &proto));
  return SnapshotData{std::move(*proto.mutable_snapshot())};
}

std::string Encode(const Reassign& message) {
  v1::Reassign proto;
  ToProto(message.assignment, proto.mutable_assignment());
  return proto.SerializeAsString();
}

template <>
Result<Reassign> DecodeMessage(const std::string& payload) {
  v1::Reassign proto;
  RETURN_IF_ERROR(Parse(payload, "Reassign", &proto));
  Reassign message;
  RETURN_IF_ERROR(FromProto(proto.assignment(), "Reassign", &message.assignment));
  return message;
}

std::string Encode(const Parcels& message) {
  v1::Parcels proto;
  for (const MigrationParcel& parcel : message.parcels) {
    v1::Parcel* out = proto.add_parcels();
    out->set_to(parcel.to);
    out->set_links(parcel.links);
    out->set_data(parcel.bytes);
  }
  return proto.SerializeAsString();
}

template <>
Result<Parcels> DecodeMessage(const std::string& payload) {
  v1::Parcels proto;
  RETURN_IF_ERROR(Parse(payload, "Parcels", &proto));
  Parcels message;
  for (v1::Parcel& parcel : *proto.mutable_parcels()) {
    if (parcel.to() >= kMaxWorkers) {
      return Error(StatusCode::kDataLoss, "Parcels: for worker {}", parcel.to());
    }
    message.parcels.push_back({parcel.to(), parcel.links(), std::move(*parcel.mutable_data())});
  }
  return message;
}

std::string Encode(const Absorb& message) {
  v1::Absorb proto;
  for (const std::string& parcel : message.parcels) proto.add_parcels(parcel);
  return proto.SerializeAsString();
}

template <>
Result<Absorb> DecodeMessage(const std::string& payload) {
  v1::Absorb proto;
  RETURN_IF_ERROR(Parse(payload, "Absorb", &proto));
  Absorb message;
  for (std::string& parcel : *proto.mutable_parcels()) message.parcels.push_back(std::move(parcel));
  return message;
}

std::string Encode(const EndJob& message) {
  v1::EndJob proto;
  proto.set_job(message.job);
  return proto.SerializeAsString();
}

template <>
Result<EndJob> DecodeMessage(const std::string& payload) {
  v1::EndJob proto;
  RETURN_IF_ERROR(Parse(payload, "EndJob", &proto));
  return EndJob{proto.job()};
}

std::string Encode(const Failed& message) {
  v1::Failed proto;
  proto.set_code(static_cast<uint32_t>(message.status.code()));
  proto.set_message(message.status.message());
  return proto.SerializeAsString();
}

template <>
Result<Failed> DecodeMessage(const std::string& payload) {
  v1::Failed proto;
  RETURN_IF_ERROR(Parse(payload, "Failed", &proto));
  const bool known = proto.code() >= static_cast<uint32_t>(StatusCode::kCancelled) &&
                     proto.code() <= static_cast<uint32_t>(StatusCode::kDataLoss);
  const StatusCode code = known ? static_cast<StatusCode>(proto.code()) : StatusCode::kUnknown;
  return Failed{Status(code, proto.message())};
}

std::string Encode(const Progress& message) {
  v1::Progress proto;
  proto.set_job(message.job);
  proto.set_round(message.round);
  proto.set_cpu_s(message.cpu_s);
  return proto.SerializeAsString();
}

template <>
Result<Progress> DecodeMessage(const std::string& payload) {
  v1::Progress proto;
  RETURN_IF_ERROR(Parse(payload, "Progress", &proto));
  return Progress{proto.job(), proto.round(), proto.cpu_s()};
}

}  // namespace isolux
