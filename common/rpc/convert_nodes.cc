#include "common/rpc/convert_nodes.h"

#include "common/rpc/protocol.h"

namespace isolux {
namespace {

Status Malformed(const char* what, const char* why) {
  return MakeStatus(StatusCode::kDataLoss, "{}: {}", what, why);
}

}  // namespace

void ToProto(std::span<const NodeId> ids, v1::NodeIds* message) {
  std::vector<uint32_t> surfaces(ids.size());
  std::vector<uint64_t> paths(ids.size());
  for (size_t i = 0; i < ids.size(); ++i) {
    surfaces[i] = ids[i].surface;
    paths[i] = ids[i].path;
  }
  message->set_surfaces(ToBytes(surfaces));
  message->set_paths(ToBytes(paths));
}

Status FromProto(const v1::NodeIds& message, const char* what, std::vector<NodeId>* ids) {
  std::vector<uint32_t> surfaces;
  std::vector<uint64_t> paths;
  RETURN_IF_ERROR(FromBytes(message.surfaces(), what, &surfaces));
  RETURN_IF_ERROR(FromBytes(message.paths(), what, &paths));
  if (surfaces.size() != paths.size()) return Malformed(what, "not as many surfaces as paths");
  ids->resize(surfaces.size());
  for (size_t i = 0; i < ids->size(); ++i) {
    const NodeId id{surfaces[i], paths[i]};
    const bool exists =
        id.is_cluster() ? (id.path >> 32) < kDirections : id.path != 0 && id.level() <= kMaxLevel;
    if (!exists) return Malformed(what, "an id that no node has");
    if (i > 0 && !((*ids)[i - 1] < id)) return Malformed(what, "ids out of order");
    (*ids)[i] = id;
  }
  return {};
}

void ToProto(const Assignment& assignment, v1::Assignment* message) {
  ToProto(assignment.cut, message->mutable_cut());
  message->set_homes(ToBytes(assignment.home));
  message->set_worker_count(assignment.worker_count);
}

Status FromProto(const v1::Assignment& message, const char* what, Assignment* assignment) {
  RETURN_IF_ERROR(FromProto(message.cut(), what, &assignment->cut));
  RETURN_IF_ERROR(FromBytes(message.homes(), what, &assignment->home));
  assignment->worker_count = message.worker_count();
  if (assignment->worker_count == 0 || assignment->worker_count > kMaxWorkers) {
    return Malformed(what, "number of workers out of range");
  }
  if (assignment->cut.empty()) return Malformed(what, "the cut is empty");
  if (assignment->home.size() != assignment->cut.size()) {
    return Malformed(what, "not one home a node of the cut");
  }
  for (const uint32_t home : assignment->home) {
    if (home >= assignment->worker_count) return Malformed(what, "home out of range");
  }
  return {};
}

}  // namespace isolux
