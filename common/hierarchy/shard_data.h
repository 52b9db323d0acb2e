// What a shard (worker/shard.h) hands to the coordinator: plain data, for the numerics, the
// protocol and the coordinator alike.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/hierarchy/node_id.h"
#include "common/scene/effect_costs.h"
#include "common/scene/measured_effect.h"

namespace isolux {

// floor(8 log2 x) for x > 0, by comparisons: the same on every processor.
int EighthOctave(double x);

// How many links have which error, by eighths of octaves: bin b counts errors from
// 2^(kLowest + b/8) W up to the next bin's, the ends all beyond them.
struct ErrorHistogram {
  static constexpr int kLowest = -64, kPerOctave = 8;
  std::array<uint64_t, size_t{128} * kPerOctave> count{};

  void Add(double error_w);
  void Add(const ErrorHistogram& other);
};

// How local errors |ΔH| / max(H, 5 % of the mean) are spread over the area, as expected means of
// each leaf: by eighths of octaves from 2^kLowest on, in units of kWholeArea⁻¹ of the scene's area.
// Integers, so that sums do not depend on who adds them up.
struct LocalErrors {
  static constexpr int kLowest = -20, kPerOctave = 8;
  static constexpr double kWholeArea = 0x1p40;
  std::array<uint64_t, size_t{32} * kPerOctave> area{};
  double worst = 0;  // the largest of all leaves (the lowest id among equals)
  NodeId worst_leaf;

  void Add(const NodeId& leaf, double error, double area_share);
  void Add(const LocalErrors& other);
  // What the error is below on this share of the area, where it is normal on every leaf.
  double Quantile(double share) const;
};

// Leaves whose rows closure had to bend far (worker/radiosity/leaks.h), and their share of the area
// of all sides that take part.
struct Leaks {
  uint64_t leaves = 0;
  double area_share = 0;
};

// What a worker tells of a round. Collective figures (marked so) are the same at every worker.
struct RoundReport {
  uint32_t round = 0;
  double epsilon = 0;
  // Collective.
  double error_estimate = 0, error_spread = 0, error_visibility = 0, error_coupling = 0,
         error_solver = 0, error_closure = 0, error_rms = 0;
  double residual = 0, energy_imbalance = 0;
  uint32_t iterations = 0;
  std::array<double, 3> emitted_w{}, absorbed_w{}, escaped_w{};
  std::array<double, 3> medium_w{};
  std::array<double, 3> glass_w{};  // that the medium absorbs
  Leaks leaks;
  std::vector<MeasuredEffect> measured;  // where this round was to measure some
  uint64_t crown_hash = 0;               // of the crown's links; must agree
  // This worker's own.
  uint64_t links = 0, leaves = 0, evaluations = 0, rays = 0;
  uint64_t proved_visible = 0, proved_hidden = 0;  // of the evaluations, without a ray
  uint64_t memory_bytes = 0;  // of the solver; LinkErrors has that of links and nodes
  double refine_s = 0, exchange_s = 0, solve_s = 0;  // wall
  double cpu_s = 0;
  EffectCosts costs;  // parts of the rays and of cpu_s
  LocalErrors local_errors;
  // Cost of the blocks counted for each cut node (index into the assignment's cut), in nanoseconds
  // of CPU, shared out by evaluations and links; only nodes homed here.
  std::vector<double> cut_cost_ns;
  std::vector<uint64_t> cut_links, cut_elements;  // of the same nodes
};

// Links that leave: bytes for one worker, to be absorbed there.
struct MigrationParcel {
  uint32_t to = 0;
  uint64_t links = 0;
  std::string bytes;
};

// Bit of the corners wanted of an element that asks for its middle instead, in the place of the
// first corner.
inline constexpr uint8_t kCentre = 16;

// Irradiance at the corners of output elements: integer sums in units of 2^-exponent W/m², which
// the coordinator adds up over the workers.
struct GatherPart {
  int exponent = 0;           // the same at every worker
  std::vector<int64_t> sums;  // elements × 4 corners × 3 channels (a triangle's fourth is 0)
  uint64_t rays = 0;
  double cpu_s = 0, wall_s = 0;
  EffectCosts costs;  // parts of the rays and of cpu_s
};

}  // namespace isolux
