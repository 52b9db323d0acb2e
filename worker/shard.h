// One worker's part of a job: the links of the blocks homed here, and a copy of the tree as the
// last snapshot has it. Driven by the coordinator's commands; knows nothing of the network but
// Exchange.
//
// A job at a shard is: Start, then for each round RunRound, TakeSnapshot (its own part),
// InstallSnapshot (the merged whole), perhaps Reassign and Absorb; at the end Gather, once a wave.
// Where light has bands: then for each group of them SolveGroup, TakeSnapshot, InstallSnapshot,
// Gather.
// After a fault: Start, then for each old round ReplayRound and InstallSnapshot.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/shard_data.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/solve_options.h"
#include "common/util/parallel.h"
#include "common/util/status.h"
#include "worker/radiosity/exchange.h"

namespace isolux {

class Shard {
 public:
  // `pool` and `scene` outlive the shard. `self` is this worker's number in the assignment.
  Shard(std::shared_ptr<const Scene> scene, ThreadPool* pool);
  ~Shard();

  // Builds the tree, the ray scene and the first links. Needed once a job and after every fault.
  // `measured`: what a first round has measured; where there is nothing, the first round measures
  // what the plan wants to know.
  Status Start(const SolveOptions& options, const Assignment& assignment, uint32_t self,
               std::span<const MeasuredEffect> measured = {});

  // Refines to epsilon (W), subscribes, solves to residual power <= accuracy/10 (1−λ) Φ.
  Result<RoundReport> RunRound(double epsilon, double accuracy, Exchange& exchange);
  // Refinement alone, for rounds whose snapshots are known.
  Status ReplayRound(double epsilon, Exchange& exchange);

  // Puts a group of the scene's bands in the place of the channels and solves for them over the
  // links as they are. `start`: the last round's snapshot with a guess of their irradiance.
  Result<RoundReport> SolveGroup(uint32_t group, const Snapshot& start, double accuracy,
                                 Exchange& exchange);

  // The leaves below the cut nodes homed here, with the values of the last solve.
  Snapshot TakeSnapshot() const;
  Status InstallSnapshot(const Snapshot& snapshot);

  // Errors of the links homed here by the values of the snapshot: what refinement goes by.
  ErrorHistogram CountErrors() const;

  // Of links, nodes and snapshot.
  uint64_t memory_bytes() const;

  // Takes over a new assignment (right after InstallSnapshot). Returns the links to hand on.
  Result<std::vector<MigrationParcel>> Reassign(const Assignment& next);
  Status Absorb(const std::string& parcel_bytes);

  // Irradiance at the corners of these elements (sorted by NodeId; leaves of the last snapshot or
  // below them) over the links homed here. `corners`: of each those wanted, by bits, or kCentre;
  // empty: all.
  Result<GatherPart> Gather(const std::vector<NodeId>& elements,
                            const std::vector<uint8_t>& corners, double accuracy);

  // Emitted power per channel, W, known after Start.
  Rgb EmittedPower() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isolux
