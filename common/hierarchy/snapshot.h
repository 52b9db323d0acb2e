// The state of a solution at the end of a round: what every worker holds whole, what refinement of
// the next round judges links by, and what a restarted job replays.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/hierarchy/node_id.h"
#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

struct LeafRecord {
  NodeId id;
  std::array<double, 3> irradiance{};  // H, W/m², area mean
  float spread = 0;   // estimated range of irradiance within the leaf, W/m², summed over channels
  float error = 0;    // estimated absolute error of the irradiance, worst channel, W/m²
  float closure = 1;  // factor d of the row-sum closure
  float inheritance = 1;  // factor of what comes from the nodes above
  float escape = 0;       // share of its light that reaches no participating side
  float doubt = 0;  // what links in doubt bring, times its deviation, W/m², summed over channels

  bool operator==(const LeafRecord&) const = default;
};

// What a leaf radiates beyond E + ρH.
struct PassedLight {
  Rgb radiosity{0.0};  // W/m²
  double spread = 0;   // its range within the leaf, W/m²

  bool operator==(const PassedLight&) const = default;
};

struct Snapshot {
  uint32_t round = 0;              // 0: before the first round
  double epsilon = 0;              // threshold of that round, W
  std::vector<LeafRecord> leaves;  // by NodeId, every surface covered exactly once
  // Of a group of spectral bands: what each leaf gives out of light that groups before it took.
  // Empty: nothing.
  std::vector<PassedLight> handed_on;

  bool operator==(const Snapshot&) const = default;
};

// Little-endian bytes and back; Decode checks lengths, order and ranges.
std::string Encode(const Snapshot& snapshot);
Result<Snapshot> DecodeSnapshot(const std::string& bytes);

// Joins what the workers hand in (each the leaves below its cut nodes, in order) into one.
// Fails where a surface is covered twice or not at all. Leaves what is handed on out.
Result<Snapshot> MergeSnapshots(std::vector<Snapshot> parts, uint32_t surface_count);

}  // namespace isolux
