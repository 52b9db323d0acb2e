// What panes of glass take of the light of a scene at most: rays between leaves, of which a coarse
// round has few, may miss a pane that is small; its own light cannot be missed.
#pragma once

#include <cstdint>
#include <span>

#include "common/hierarchy/hierarchy.h"

namespace isolux {

// Of panes and surfaces that are looked at, unless told otherwise: some seconds.
inline constexpr uint64_t kMostPanePairs = 1 << 22;

// W over all channels. On each side falls by closed form, with nothing in between, what the lamps
// bring, and what else surfaces radiate, `reflected_w_m2` over the channels at most: either of each
// surface, of which as many as `most_pairs` leaves beside the lamps are looked at, the brightest;
// or one number, of all. What is not looked at counts as if all round were as bright as it may be.
// Infinite where panes and lamps alone are more pairs.
double MostTakenByPanes(const Hierarchy& hierarchy, std::span<const double> reflected_w_m2,
                        uint64_t most_pairs = kMostPanePairs);

}  // namespace isolux
