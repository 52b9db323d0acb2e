// What a shard (worker/shard.h) hands to the coordinator: plain data, for the numerics, the
// protocol and the coordinator alike.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace isolux {

// Error of links by power of two: bin b counts links whose error e has floor(log2 e) = b + kLowest,
// clamped to the ends.
struct ErrorHistogram {
  static constexpr int kLowest = -64;
  std::array<uint64_t, 128> count{};
};

// What a worker tells of a round. Collective figures (marked so) are the same at every worker.
struct RoundReport {
  uint32_t round = 0;
  double epsilon = 0;
  // Collective.
  double error_estimate = 0, error_spread = 0, error_visibility = 0, error_coupling = 0,
         error_solver = 0;
  double residual = 0, energy_imbalance = 0;
  uint32_t iterations = 0;
  std::array<double, 3> emitted_w{}, absorbed_w{}, escaped_w{};
  uint64_t crown_hash = 0;  // of the crown's links; must agree
  // This worker's own.
  uint64_t links = 0, leaves = 0, evaluations = 0, rays = 0, memory_bytes = 0;
  double refine_s = 0, exchange_s = 0, solve_s = 0;  // wall
  double cpu_s = 0;
  ErrorHistogram histogram;
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

// Irradiance at the corners of output elements: integer sums in units of 2^-exponent W/m², which
// the coordinator adds up over the workers.
struct GatherPart {
  int exponent = 0;           // the same at every worker
  std::vector<int64_t> sums;  // elements × 4 corners × 3 channels (a triangle's fourth is 0)
  uint64_t rays = 0;
  double cpu_s = 0;
};

}  // namespace isolux
