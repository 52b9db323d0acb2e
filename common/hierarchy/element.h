// The geometry of an element is a pure function of its id: any process builds any element from the
// scene. Subdivision is binary, across the longest side, so that shapes get rounder.
#pragma once

#include <array>

#include "common/hierarchy/node_id.h"
#include "common/scene/scene.h"

namespace isolux {

// The longest side, from corner i to the next; of equal ones the first.
int LongestSide(const ConvexPolygon& polygon);

// Cuts from the midpoint of the longest side to the midpoint of the opposite side (quad) or to the
// opposite corner (triangle). Both parts keep the orientation. The back of a translucent sheet is
// cut where its front is, and its parts have the numbers that they have there.
std::array<ConvexPolygon, 2> Subdivide(const ConvexPolygon& polygon);

// The same polygon seen from behind, counter-clockwise there; twice, it is itself to the bit.
ConvexPolygon FromBehind(const ConvexPolygon& polygon);

// The element with this path on a surface whose whole is `surface`.
ConvexPolygon ElementGeometry(const ConvexPolygon& surface, uint64_t path);

}  // namespace isolux
