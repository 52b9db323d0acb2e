// What refinement asks of two nodes of which one may be a cluster.
#pragma once

#include "worker/radiosity/refine.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Longest line within a polygon or node, m.
double SizeOf(const ConvexPolygon& polygon);
double SizeOf(const Tree& tree, uint32_t node);

// Upper bound of the coupling of two nodes of which one is a cluster, m²; 0 where they cannot meet.
double ClusterBound(const Tree& tree, uint32_t p, uint32_t q);

// Their coupling, from centre to centre, with the areas that face each other, m²:
// S_p S_q/(π d² + the larger).
double ClusterCoupling(const Tree& tree, uint32_t p, uint32_t q);

// Of two nodes of which one is a cluster.
Meeting MeetingOf(const Tree& tree, uint32_t p, uint32_t q);

// The end to divide where a link stands for a part of its ends only: the larger mixed cluster.
LinkVerdict MixedEnd(const Tree& tree, uint32_t p, uint32_t q);

}  // namespace isolux
