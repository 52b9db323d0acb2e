// What panes of glass take of the light of a scene at most: rays between leaves, of which a coarse
// round has few, may miss a pane that is small; its own light cannot be missed.
#pragma once

#include <span>

#include "common/hierarchy/hierarchy.h"

namespace isolux {

// W over all channels. On each side falls by closed form, with nothing in between, what the lamps
// bring, and what else surfaces radiate, `reflected_w_m2` over the channels at most: either of each
// surface, of which as many as there is time for are looked at, the brightest; or one number, of
// all. What is not looked at counts as if all round were as bright as it may be. Infinite where
// there are too many panes and lamps to go through.
double MostTakenByPanes(const Hierarchy& hierarchy, std::span<const double> reflected_w_m2);

}  // namespace isolux
