// Coupling factors by other ways than the solver's, in long double, with the C library's functions:
// slow and accurate. None of the solver's code below it.
#pragma once

#include "common/scene/scene.h"

namespace isolux::testing {

// Single contour integral; tanh-sinh quadrature of each side between the points where the integrand
// is not smooth. To about 1e-13 of the product of the polygons' lengths.
long double CouplingByContours(const ConvexPolygon& p, const ConvexPolygon& q);

// Lambert's form of q integrated over p by dividing p until halves change nothing; for polygons
// apart from each other that face each other wholly. To about `tolerance`.
long double CouplingByPoints(const ConvexPolygon& p, const ConvexPolygon& q, long double tolerance);

}  // namespace isolux::testing
