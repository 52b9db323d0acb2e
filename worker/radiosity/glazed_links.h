// What panes of glass leave of the light between two nodes: the mean over rays that pass, weighted
// by what they carry. As with a medium, couplings are kept as without panes, so that their rows add
// up to what they must; this is what products are multiplied by beside them. A link between whose
// ends no pane may stand, which its corners tell, casts no ray for it.
#pragma once

#include <span>

#include "common/hierarchy/panes.h"
#include "worker/radiosity/link.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Whether panes may stand between the ends of a link: of elements by their corners, of clusters by
// those of their boxes; kSome by way of mirrors.
Crossing PanesBetween(const Panes& panes, const Tree& tree, const Link& link);

// Of the light of a link, by channel; scene.panes is not null. The same bits wherever it is made.
Rgb LeftByPanes(const RefineScene& scene, const Tree& tree, const Link& link);

// Makes variation_p and variation_q of a new link of two elements those of the form factors times
// what panes leave, which varies too, most where their edges cross. `other`: the polygon at q, or
// the image of it that p sees.
void VaryByPanes(const Panes& panes, const ConvexPolygon& p, const ConvexPolygon& other,
                 const MirrorImage* image, Link* link);

}  // namespace isolux
