// What panes of glass take of the light of a scene at most: rays between leaves, of which a coarse
// round has few, may miss a pane that is small; its own light cannot be missed.
#pragma once

#include "common/hierarchy/hierarchy.h"

namespace isolux {

// W over all channels. On each side falls what the lamps bring by closed form, with nothing in
// between, and over the whole hemisphere what else radiates `reflected_w_m2` at most, over the
// channels. Infinite where there are too many panes and lamps to go through.
double MostTakenByPanes(const Hierarchy& hierarchy, double reflected_w_m2);

}  // namespace isolux
