// A polygon as lights see it.
#pragma once

#include "common/scene/scene.h"

namespace isolux {

// Of a polygon, from a point that is not on it.
double SolidAngle(const ConvexPolygon& polygon, const Vec3& from);

// The point of a polygon nearest to a point of its plane.
Vec3 NearestInside(const ConvexPolygon& polygon, const Vec3& normal, const Vec3& point);

}  // namespace isolux
