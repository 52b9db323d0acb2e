// Random pairs of polygons by how they lie to each other: for tests and benchmarks of couplings.
#pragma once

#include <array>
#include <span>
#include <string>

#include "common/scene/scene.h"
#include "common/util/random.h"

namespace isolux::testing {

struct PolygonPair {
  ConvexPolygon p, q;
};

// A kind of pair; one of it from each seed.
struct PairFamily {
  const char* name;
  PolygonPair (*make)(Random&);
};
std::span<const PairFamily> PairFamilies();

// A pair of the family that exchanges something.
PolygonPair MakePair(const PairFamily& family, uint64_t seed);

// A random triangle or convex quad with its corners on an ellipse of this radius, `aspect` times as
// long as wide.
ConvexPolygon RandomPolygon(Random& random, const Vec3& centre, const Vec3& normal, double radius,
                            double aspect = 1);

// A rotation about the origin, a translation and a scaling, in this order.
struct Motion {
  std::array<Vec3, 3> rows{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  Vec3 offset{0.0};
  double scale = 1;

  ConvexPolygon operator()(const ConvexPolygon& polygon) const;
};
Motion RandomRotation(Random& random);

// The same polygon seen from behind.
ConvexPolygon Reversed(const ConvexPolygon& polygon);

}  // namespace isolux::testing
