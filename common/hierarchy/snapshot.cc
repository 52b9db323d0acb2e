#include "common/hierarchy/snapshot.h"

#include <algorithm>
#include <cstring>

namespace isolux {
namespace {

constexpr uint32_t kMagic = 0x53584c49;  // "ILXS"
constexpr size_t kHeaderBytes = 4 + 4 + 8 + 8;
constexpr size_t kLeafBytes = 4 + 8 + 3 * 8 + 6 * 4;
constexpr size_t kHandedOnBytes = 4 * 8;  // of a leaf, behind all leaves

template <typename T>
void Put(char*& out, const T& value) {
  std::memcpy(out, &value, sizeof value);
  out += sizeof value;
}

template <typename T>
T Take(const char*& in) {
  T value;
  std::memcpy(&value, in, sizeof value);
  in += sizeof value;
  return value;
}

// Whether the leaves, in order, cover surfaces 0 .. count-1 once each. Leaves of a surface follow
// each other; the next one starts where the last one ended, counting paths as binary fractions.
Status CheckCover(const std::vector<LeafRecord>& leaves, uint32_t surface_count) {
  uint32_t surface = 0;
  uint64_t covered = 0;  // in units of 2^-kMaxLevel of the surface
  constexpr uint64_t kWhole = 1ULL << kMaxLevel;
  for (const LeafRecord& leaf : leaves) {
    const int level = leaf.id.level();
    const uint64_t start = (leaf.id.path << (kMaxLevel - level)) - kWhole;
    if (leaf.id.surface != surface || start != covered) {
      return MakeStatus(StatusCode::kDataLoss, "snapshot: leaf {}:{} does not follow on surface {}",
                        leaf.id.surface, leaf.id.path, surface);
    }
    covered += 1ULL << (kMaxLevel - level);
    if (covered == kWhole) {
      ++surface;
      covered = 0;
    }
  }
  if (surface != surface_count || covered != 0) {
    return MakeStatus(StatusCode::kDataLoss, "snapshot: covers {} of {} surfaces", surface,
                      surface_count);
  }
  return {};
}

}  // namespace

std::string Encode(const Snapshot& snapshot) {
  std::string bytes(kHeaderBytes + kLeafBytes * snapshot.leaves.size() +
                        kHandedOnBytes * snapshot.handed_on.size(),
                    '\0');
  char* out = bytes.data();
  Put(out, kMagic);
  Put(out, snapshot.round);
  Put(out, snapshot.epsilon);
  Put(out, static_cast<uint64_t>(snapshot.leaves.size()));
  for (const LeafRecord& leaf : snapshot.leaves) {
    Put(out, leaf.id.surface);
    Put(out, leaf.id.path);
    for (const double h : leaf.irradiance) Put(out, h);
    Put(out, leaf.spread);
    Put(out, leaf.error);
    Put(out, leaf.closure);
    Put(out, leaf.inheritance);
    Put(out, leaf.escape);
    Put(out, leaf.doubt);
  }
  for (const PassedLight& light : snapshot.handed_on) {
    for (int c = 0; c < 3; ++c) Put(out, light.radiosity[c]);
    Put(out, light.spread);
  }
  return bytes;
}

Result<Snapshot> DecodeSnapshot(const std::string& bytes) {
  if (bytes.size() < kHeaderBytes) return Error(StatusCode::kDataLoss, "snapshot: too short");
  const char* in = bytes.data();
  if (Take<uint32_t>(in) != kMagic) return Error(StatusCode::kDataLoss, "snapshot: not a snapshot");
  Snapshot snapshot;
  snapshot.round = Take<uint32_t>(in);
  snapshot.epsilon = Take<double>(in);
  const auto count = Take<uint64_t>(in);
  const auto size_is = [&](size_t leaf_bytes) {
    return count <= bytes.size() && bytes.size() == kHeaderBytes + leaf_bytes * count;
  };
  const bool handed_on = count > 0 && size_is(kLeafBytes + kHandedOnBytes);
  if (!handed_on && !size_is(kLeafBytes)) {
    return Error(StatusCode::kDataLoss, "snapshot: {} bytes do not hold {} leaves", bytes.size(),
                 count);
  }
  snapshot.leaves.resize(count);
  for (LeafRecord& leaf : snapshot.leaves) {
    leaf.id.surface = Take<uint32_t>(in);
    leaf.id.path = Take<uint64_t>(in);
    for (double& h : leaf.irradiance) h = Take<double>(in);
    leaf.spread = Take<float>(in);
    leaf.error = Take<float>(in);
    leaf.closure = Take<float>(in);
    leaf.inheritance = Take<float>(in);
    leaf.escape = Take<float>(in);
    leaf.doubt = Take<float>(in);
    if (leaf.id.is_cluster() || leaf.id.path == 0 || leaf.id.level() > kMaxLevel) {
      return Error(StatusCode::kDataLoss, "snapshot: no element has the id {}:{}", leaf.id.surface,
                   leaf.id.path);
    }
  }
  if (handed_on) snapshot.handed_on.resize(count);
  for (PassedLight& light : snapshot.handed_on) {
    for (int c = 0; c < 3; ++c) light.radiosity[c] = Take<double>(in);
    light.spread = Take<double>(in);
  }
  const auto out_of_order = [](const LeafRecord& a, const LeafRecord& b) { return !(a.id < b.id); };
  if (std::adjacent_find(snapshot.leaves.begin(), snapshot.leaves.end(), out_of_order) !=
      snapshot.leaves.end()) {
    return Error(StatusCode::kDataLoss, "snapshot: leaves are out of order");
  }
  return snapshot;
}

Result<Snapshot> MergeSnapshots(std::vector<Snapshot> parts, uint32_t surface_count) {
  if (parts.empty()) return Error(StatusCode::kInvalidArgument, "snapshot: nothing to merge");
  Snapshot merged;
  merged.round = parts[0].round;
  merged.epsilon = parts[0].epsilon;
  size_t total = 0;
  for (const Snapshot& part : parts) {
    if (part.round != merged.round || part.epsilon != merged.epsilon) {
      return Error(StatusCode::kDataLoss, "snapshot: parts of rounds {} and {}", merged.round,
                   part.round);
    }
    total += part.leaves.size();
  }
  merged.leaves.reserve(total);
  for (Snapshot& part : parts) {
    merged.leaves.insert(merged.leaves.end(), part.leaves.begin(), part.leaves.end());
  }
  std::sort(merged.leaves.begin(), merged.leaves.end(),
            [](const LeafRecord& a, const LeafRecord& b) { return a.id < b.id; });
  RETURN_IF_ERROR(CheckCover(merged.leaves, surface_count));
  return merged;
}

}  // namespace isolux
