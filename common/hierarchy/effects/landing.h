// How much of what the lamps radiate surely lands: what bounds of neglected light are taken of.
#pragma once

#include "common/hierarchy/hierarchy.h"

namespace isolux {

// Power that lands straight from polygons that emit on sides that take part, W over the channels:
// three standard deviations below what a few hundred seeded rays say, less what panes of
// glass take of them and what a medium may absorb. 0 where there are no lamps, or so many polygons
// that looking would take long.
double LandingPower(const Hierarchy& hierarchy);

}  // namespace isolux
