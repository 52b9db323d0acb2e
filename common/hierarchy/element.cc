#include "common/hierarchy/element.h"

namespace isolux {

int LongestSide(const ConvexPolygon& polygon) {
  int longest = 0;
  double best = -1;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 side = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    const double length2 = glm::dot(side, side);
    if (length2 > best) {
      best = length2;
      longest = i;
    }
  }
  return longest;
}

// The cut of a first part lies between its second and third corner, seen from either side.
ConvexPolygon FromBehind(const ConvexPolygon& polygon) {
  ConvexPolygon result = polygon;
  if (polygon.count == 4) {
    result.v = {polygon.v[3], polygon.v[2], polygon.v[1], polygon.v[0]};
  } else {
    result.v = {polygon.v[0], polygon.v[2], polygon.v[1]};
  }
  result.divided_from_behind = !polygon.divided_from_behind;
  return result;
}

std::array<ConvexPolygon, 2> Subdivide(const ConvexPolygon& polygon) {
  if (polygon.divided_from_behind) {
    const auto parts = Subdivide(FromBehind(polygon));
    return {FromBehind(parts[0]), FromBehind(parts[1])};
  }
  const int n = polygon.count;
  const int i = LongestSide(polygon);
  const auto corner = [&](int k) -> const Vec3& { return polygon.v[(i + k) % n]; };
  const Vec3 cut = 0.5 * (corner(0) + corner(1));
  if (n == 3) {
    return {ConvexPolygon{3, {corner(0), cut, corner(2)}},
            ConvexPolygon{3, {cut, corner(1), corner(2)}}};
  }
  const Vec3 opposite = 0.5 * (corner(2) + corner(3));
  return {ConvexPolygon{4, {corner(0), cut, opposite, corner(3)}},
          ConvexPolygon{4, {cut, corner(1), corner(2), opposite}}};
}

ConvexPolygon ElementGeometry(const ConvexPolygon& surface, uint64_t path) {
  ConvexPolygon polygon = surface;
  for (int level = NodeId{0, path}.level() - 1; level >= 0; --level) {
    polygon = Subdivide(polygon)[(path >> level) & 1];
  }
  return polygon;
}

}  // namespace isolux
