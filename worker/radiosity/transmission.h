// What a medium leaves of the light between two nodes: the mean of exp(−κ r) over all rays from the
// one to the other, weighted by what they carry. Couplings are kept as without a medium, so that
// their rows add up to what they must; this is what products are multiplied by beside them.
//
// Pure functions of the two ends, the same on every machine.
#pragma once

#include "common/scene/medium.h"
#include "worker/radiosity/link.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Of two polygons as if nothing stood between, by channel, about within 1e-3 of what the medium
// takes. 1 where they do not see each other.
Rgb MeanTransmission(const Medium& medium, const ConvexPolygon& p, const ConvexPolygon& q);

// Of a link: of elements as above, of clusters from centre to centre.
Rgb TransmissionOf(const Medium& medium, const Tree& tree, const Link& link);

// Makes variation_p and variation_q of a new link of two elements those of the form factors times
// what the medium leaves, which varies too. `other`: the polygon at q, or the image of it that p
// sees. No less than the truth, in the most transparent channel and the densest.
void VaryByMedium(const Medium& medium, const ConvexPolygon& p, const ConvexPolygon& other,
                  Link* link);

}  // namespace isolux
