// How much of what the lamps radiate surely lands: what bounds of neglected light are taken of.
#pragma once

#include "common/hierarchy/hierarchy.h"

namespace isolux {

// Power that lands straight from polygons that emit on sides that take part, W over the channels:
// three standard deviations below what a few hundred seeded rays say, less what panes of
// glass take of them and what a medium may absorb. 0 where there are no lamps, or so many polygons
// that looking would take long.
double LandingPower(const Hierarchy& hierarchy);

// What falls on so much area at most, of all that falls anywhere: no more than it would if all
// round were as bright as the brightest lamp may have it, E_max/(1 − α_max) over all channels.
// Infinite where light comes from elsewhere than from even lamps.
double LargestShareOfLight(const Hierarchy& hierarchy, double area_m2);

}  // namespace isolux
