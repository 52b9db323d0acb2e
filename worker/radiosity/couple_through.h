// Couplings of nodes and images of nodes: what of their exchange goes by way of mirrors. All in
// m², with the share that the mirrors leave, as if nothing stood between and the mirrors had no
// edges. A node and an image of its own: half of it (Link::SetThroughMirrors).
#pragma once

#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Of two nodes of which one is a cluster: an upper bound, 0 where they cannot meet; and what they
// exchange as they face each other.
double BoundThrough(const Tree& tree, uint32_t image, uint32_t p, uint32_t q);
double ClusterCouplingThrough(const Tree& tree, uint32_t image, uint32_t p, uint32_t q);

// Of two elements.
struct ThroughMirrors {
  Passage passage = Passage::kNone;
  double coupling_m2 = 0;                   // 0 where none passes
  double variation_p = 0, variation_q = 0;  // as of a link
};
ThroughMirrors CoupleThrough(const Tree& tree, uint32_t image, uint32_t p, uint32_t q,
                             double wanted_m2);

}  // namespace isolux
