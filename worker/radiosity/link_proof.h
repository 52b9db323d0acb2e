// Proofs that nothing stands between the two ends of a link, or that one thing hides all: the
// shaft of the ends against what may stand in it. A list of candidates is inherited by the links
// that one is divided into, since their shafts lie within its own; so it is made once, where it is
// short, and only gets shorter.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "worker/radiosity/tree.h"
#include "worker/visibility/occluder_rays.h"
#include "worker/visibility/occluder_tree.h"

namespace isolux {

// Numbers of occluders, in order. Null: not known, or too many to be of use.
using CandidateList = std::shared_ptr<const std::vector<uint32_t>>;

enum class Proof : uint8_t { kNone, kVisible, kHidden };

class LinkProver {
 public:
  // Longer lists are not kept.
  static constexpr size_t kLongest = 24;
  // Up to so many candidates cost less than the eight rays of a packet.
  static constexpr size_t kShort = 8;

  explicit LinkProver(const Hierarchy& hierarchy);

  // What can be proved of two elements. `above`: the candidates of a pair that holds this one, or
  // null to look for them. `left`: those that may hide a part, where nothing is proved.
  Proof Settle(const Tree& tree, uint32_t p, uint32_t q, const CandidateList& above,
               CandidateList* left) const;

  // All that may stand between.
  const SceneOccluders& occluders() const { return occluders_; }
  const OccluderTree& tree() const { return tree_; }
  const OccluderRays& rays() const { return rays_; }

 private:
  SceneOccluders occluders_;
  OccluderTree tree_;
  OccluderRays rays_;
};

}  // namespace isolux
