// The coupling factor of one pair of polygons past obstacles, to a tolerance: for `isolux factors`.
//
//   C_pq = ∫∫ V(x, y) cosθ_p cosθ_q / (π d²) dA_q dA_p  =  A_p F_pq  =  A_q F_qp
//
// Proofs first (Shaft); what they leave open is integrated with exact clipping at points of one
// end, halved where the error is largest; behind very many occluders segments are sampled.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/coupling/coupling.h"
#include "worker/factors/partial_pair.h"
#include "worker/visibility/occluder_tree.h"

namespace isolux {

// How a pair was settled.
enum class Way : uint8_t {
  kFacingAway,  // 0: one is behind the other's plane
  kVisible,     // proved: nothing between them
  kHidden,   // proved: one occluder crosses every segment, or 0 within a hundredth of the tolerance
  kClipped,  // exact clipping at a few points
  kDivided,  // the same on parts, each with its own proofs
  kSampled,  // segments
};
inline constexpr int kWayCount = 6;
const char* ToText(Way way);

struct PairFactor {
  double coupling_m2 = 0;
  double error_m2 = 0;  // stated: what the error is expected to stay below
  Way way = Way::kFacingAway;
};

struct PairEnd {
  CouplingEnd polygon;
  uint32_t region = kNoRegion;  // SceneOccluders; ends of one region do not see each other
};

// Keeps its memory between pairs: one for each thread. Results depend on the pair alone.
class PairSolver {
 public:
  // Keeps a pointer to the tree.
  explicit PairSolver(const OccluderTree& tree) : tree_(&tree), partial_(tree) {}

  // `candidates`: all that may block anything between the two. `seed` tells the pair from others.
  PairFactor Solve(const PairEnd& p, const PairEnd& q, std::span<const uint32_t> candidates,
                   double tolerance_m2, uint64_t seed);

 private:
  PairFactor SolvePartial(const ShaftEnd& p, const ShaftEnd& q, const PairCoupling& whole,
                          double tolerance_m2, uint64_t seed);

  const OccluderTree* tree_;
  PartialPair partial_;
  std::vector<uint32_t> own_;
};

}  // namespace isolux
