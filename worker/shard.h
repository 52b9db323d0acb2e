// One worker's part of a job: the links of the blocks homed here, and a copy of the tree as the last
// snapshot has it. Driven by the coordinator's commands; knows nothing of the network but Exchange.
//
// A job at a shard is: Start, then for each round RunRound, TakeSnapshot (its own part),
// InstallSnapshot (the merged whole), perhaps Reassign and Absorb; at the end Gather, once a wave.
// After a fault: Start, then for each old round ReplayRound and InstallSnapshot.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/solve_options.h"
#include "common/util/parallel.h"
#include "common/util/status.h"
#include "worker/radiosity/exchange.h"

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
  double error_estimate = 0, error_spread = 0, error_visibility = 0, error_coupling = 0, error_solver = 0;
  double residual = 0, energy_imbalance = 0;
  uint32_t iterations = 0;
  std::array<double, 3> emitted_w{}, absorbed_w{}, escaped_w{};
  uint64_t crown_hash = 0;  // of the crown's links; must agree
  // This worker's own.
  uint64_t links = 0, leaves = 0, evaluations = 0, rays = 0, memory_bytes = 0;
  double refine_s = 0, exchange_s = 0, solve_s = 0;  // wall
  double cpu_s = 0;
  ErrorHistogram histogram;
  // Cost of the blocks counted for each cut node (index into the assignment's cut), in nanoseconds of
  // CPU, shared out by evaluations and links; only nodes homed here.
  std::vector<double> cut_cost_ns;
  std::vector<uint64_t> cut_links, cut_elements;  // of the same nodes
};

// Links that leave: bytes for one worker, to be absorbed there.
struct MigrationParcel {
  uint32_t to = 0;
  uint64_t links = 0;
  std::string bytes;
};

// Irradiance at the corners of output elements: integer sums in units of 2^-exponent W/m², which the
// coordinator adds up over the workers.
struct GatherPart {
  int exponent = 0;             // the same at every worker
  std::vector<int64_t> sums;    // elements × 4 corners × 3 channels (a triangle's fourth is 0)
  uint64_t rays = 0;
  double cpu_s = 0;
};

class Shard {
 public:
  // `pool` and `scene` outlive the shard. `self` is this worker's number in the assignment.
  Shard(std::shared_ptr<const Scene> scene, ThreadPool* pool);
  ~Shard();

  // Builds the tree, the ray scene and the first links. Needed once a job and after every fault.
  Status Start(const SolveOptions& options, const Assignment& assignment, uint32_t self);

  // Refines to epsilon (W), subscribes, solves to residual power <= accuracy/10 (1−λ) Φ.
  Result<RoundReport> RunRound(double epsilon, double accuracy, Exchange& exchange);
  // Refinement alone, for rounds whose snapshots are known.
  Status ReplayRound(double epsilon, Exchange& exchange);

  // The leaves below the cut nodes homed here, with the values of the last solve.
  Snapshot TakeSnapshot() const;
  Status InstallSnapshot(const Snapshot& snapshot);

  // Takes over a new assignment (right after InstallSnapshot). Returns the links to hand on.
  Result<std::vector<MigrationParcel>> Reassign(const Assignment& next);
  Status Absorb(const std::string& parcel_bytes);

  // Irradiance at the corners of these elements (sorted by NodeId; leaves of the last snapshot or
  // below them) over the links homed here.
  Result<GatherPart> Gather(const std::vector<NodeId>& elements, double accuracy);

  // Emitted power per channel, W, known after Start.
  Rgb EmittedPower() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isolux
