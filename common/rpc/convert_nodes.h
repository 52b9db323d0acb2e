// Flat arrays, ids of nodes and assignments to their protocol messages and back: what the decoders
// of protocol.h are made of. For the .cc files of common/rpc alone.
#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/node_id.h"
#include "common/util/status.h"
#include "isolux/v1/worker_messages.pb.h"

namespace isolux {

static_assert(std::endian::native == std::endian::little);

template <typename T>
std::string ToBytes(std::span<const T> values) {
  static_assert(std::is_arithmetic_v<T>);
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}
template <typename T>
std::string ToBytes(const std::vector<T>& values) {
  return ToBytes(std::span<const T>(values));
}
template <typename T, size_t N>
std::string ToBytes(const std::array<T, N>& values) {
  return ToBytes(std::span<const T>(values));
}

// `what` names the message in errors.
template <typename T>
Status FromBytes(const std::string& bytes, const char* what, std::vector<T>* values) {
  static_assert(std::is_arithmetic_v<T>);
  if (bytes.size() % sizeof(T) != 0) {
    return MakeStatus(StatusCode::kDataLoss, "{}: {} bytes are no whole number of {}-byte values",
                      what, bytes.size(), sizeof(T));
  }
  values->resize(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(values->data(), bytes.data(), bytes.size());
  return {};
}
template <typename T, size_t N>
Status FromBytes(const std::string& bytes, const char* what, std::array<T, N>* values) {
  if (bytes.size() != sizeof(*values)) {
    return MakeStatus(StatusCode::kDataLoss, "{}: {} bytes instead of {}", what, bytes.size(),
                      sizeof(*values));
  }
  std::memcpy(values->data(), bytes.data(), bytes.size());
  return {};
}

void ToProto(std::span<const NodeId> ids, v1::NodeIds* message);
// Ids in increasing order, each once: every list of the protocol is so.
Status FromProto(const v1::NodeIds& message, const char* what, std::vector<NodeId>* ids);

void ToProto(const Assignment& assignment, v1::Assignment* message);
Status FromProto(const v1::Assignment& message, const char* what, Assignment* assignment);

}  // namespace isolux
