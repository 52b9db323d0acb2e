#include "tests/worker/coupling/random_pairs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include "tests/support/polygons.h"
#include "worker/coupling/coupling.h"

namespace isolux::testing {
namespace {

constexpr double kPi = std::numbers::pi;

double Between(Random& random, double low, double high) {
  return low + (high - low) * random.Unit();
}
double LogBetween(Random& random, double low, double high) {
  return low * std::pow(high / low, random.Unit());
}

// Two unit vectors that make a right-handed frame with n.
std::pair<Vec3, Vec3> Frame(Random& random, const Vec3& n) {
  const Vec3 s = glm::normalize(glm::cross(n, RandomDirection(random)));
  return {s, glm::cross(n, s)};
}

// Polygons of size one (radius) at a distance between their surfaces, roughly.
PolygonPair Apart(Random& random, double low, double high) {
  PolygonPair pair;
  pair.p = RandomPolygon(random, Vec3(0.0), RandomDirection(random), 1);
  const double radius = LogBetween(random, 0.3, 3);
  const double distance = 2 * LogBetween(random, low, high) * std::max(1.0, radius);
  const double gap = random.Unit() < 0.5 ? 0 : 0.5 * (1 + radius);
  pair.q = RandomPolygon(random, (distance + gap) * RandomDirection(random),
                         RandomDirection(random), radius);
  return pair;
}

PolygonPair SharedEdge(Random& random) {
  PolygonPair pair;
  pair.p = RandomPolygon(random, Vec3(0.0), Vec3(0, 0, 1), 1);
  // Another polygon in the same plane, moved so that a side lies on a side of p, then turned
  // about it.
  const ConvexPolygon other =
      RandomPolygon(random, Vec3(0.0), Vec3(0, 0, 1), LogBetween(random, 0.5, 2));
  const double angle = LogBetween(random, 0.05, kPi - 0.05);
  const Vec3 a = pair.p.v[0], u = glm::normalize(pair.p.v[1] - a);
  const Vec3 inward = glm::cross(Vec3(0, 0, 1), u);
  const Vec3 b = other.v[0], w = glm::normalize(other.v[1] - b);
  const Vec3 inside = glm::cross(Vec3(0, 0, 1), w);
  const Vec3 up = std::cos(angle) * inward + std::sin(angle) * Vec3(0, 0, 1);
  pair.q.count = other.count;
  for (int i = 0; i < other.count; ++i) {
    const Vec3 d = other.v[i] - b;
    pair.q.v[i] = a + glm::dot(d, w) * u + glm::dot(d, inside) * up;
  }
  // The end of the shared side exactly: the ends of equal sides coincide.
  if (random.Unit() < 0.5) {
    const double stretch = glm::length(pair.p.v[1] - a) / glm::length(other.v[1] - b);
    for (int i = 0; i < other.count; ++i) pair.q.v[i] = a + stretch * (pair.q.v[i] - a);
    pair.q.v[1] = pair.p.v[1];
  }
  pair.q = Reversed(pair.q);
  return pair;
}

PolygonPair SharedVertex(Random& random) {
  PolygonPair pair = Apart(random, 0.5, 1);
  const Vec3 move = pair.p.v[0] - pair.q.v[0];
  for (Vec3& v : pair.q.v) v += move;
  pair.q.v[0] = pair.p.v[0];
  return pair;
}

PolygonPair SizeRatio(Random& random) {
  PolygonPair pair;
  pair.p = RandomPolygon(random, Vec3(0.0), RandomDirection(random), 1);
  const double ratio = LogBetween(random, 1e-6, 1e-3);
  // Above a point of p or just outside of it, at a height between its own size and that of p.
  const Vec3 n = pair.p.Normal();
  const Vec3 at = Between(random, 0.0, 1.2) * pair.p.v[random.Bits() % pair.p.count] +
                  LogBetween(random, 2 * ratio, 1) * n;
  pair.q = RandomPolygon(random, at, RandomDirection(random), ratio);
  return pair;
}

PolygonPair Slivers(Random& random) {
  PolygonPair pair;
  pair.p = RandomPolygon(random, Vec3(0.0), RandomDirection(random), 1, 1000);
  const double aspect = random.Unit() < 0.5 ? 1000 : 1;
  pair.q = RandomPolygon(random, LogBetween(random, 1e-2, 2) * RandomDirection(random),
                         RandomDirection(random), 1, aspect);
  return pair;
}

PolygonPair Crossing(Random& random) {
  PolygonPair pair;
  pair.p = RandomPolygon(random, Vec3(0.0), RandomDirection(random), 1);
  pair.q = RandomPolygon(random, 0.7 * random.Unit() * RandomDirection(random),
                         RandomDirection(random), LogBetween(random, 0.3, 3));
  return pair;
}

PolygonPair NearlyCoplanar(Random& random) {
  PolygonPair pair;
  pair.p = RandomPolygon(random, Vec3(0.0), Vec3(0, 0, 1), 1);
  const double angle = LogBetween(random, 1e-9, 1e-1);
  const Vec3 n = glm::normalize(Vec3(0, 0, 1) + angle * RandomDirection(random));
  const double along = 2 * kPi * random.Unit();
  const Vec3 at = Between(random, 0.5, 3) * Vec3(std::cos(along), std::sin(along), 0) +
                  LogBetween(random, 1e-9, 1e-1) * Vec3(0, 0, 1);
  pair.q = RandomPolygon(random, at, n, 1);
  return pair;
}

// Moves a corner of a triangle's side out to where it turns by a hundredth of a degree.
ConvexPolygon WithStraightCorner(const ConvexPolygon& triangle, double share) {
  constexpr double kTurn = 0.01 * kPi / 180;
  const Vec3 side = triangle.v[2] - triangle.v[1];
  const Vec3 out = glm::normalize(glm::cross(side, triangle.Normal()));
  const double rise = kTurn * share * (1 - share) * glm::length(side);
  return {4,
          {triangle.v[0], triangle.v[1], triangle.v[1] + share * side + rise * out, triangle.v[2]}};
}

PolygonPair StraightCorners(Random& random) {
  PolygonPair pair = Apart(random, 0.02, 2);
  for (ConvexPolygon* polygon : {&pair.p, &pair.q}) {
    polygon->count = 3;
    *polygon = WithStraightCorner(*polygon, Between(random, 0.1, 0.9));
  }
  if (random.Unit() < 0.5) {  // sharing the straight corner
    const Vec3 move = pair.p.v[2] - pair.q.v[2];
    for (Vec3& v : pair.q.v) v += move;
    pair.q.v[2] = pair.p.v[2];
  }
  return pair;
}

constexpr PairFamily kFamilies[] = {
    {"5-50 sizes apart", [](Random& random) { return Apart(random, 5, 50); }},
    {"1-5 sizes apart", [](Random& random) { return Apart(random, 1, 5); }},
    {"0.05-1 sizes apart", [](Random& random) { return Apart(random, 0.05, 1); }},
    {"shared side", SharedEdge},
    {"shared corner", SharedVertex},
    {"size ratio 1e3-1e6", SizeRatio},
    {"slivers 1:1000", Slivers},
    {"crossing planes", Crossing},
    {"nearly coplanar", NearlyCoplanar},
    {"straight corners", StraightCorners},
};

}  // namespace

std::span<const PairFamily> PairFamilies() { return kFamilies; }

PolygonPair MakePair(const PairFamily& family, uint64_t seed) {
  Random random(seed);
  for (;;) {
    PolygonPair pair = family.make(random);
    for (int way = 0; way < 4; ++way) {
      const CouplingEnd p = MakeCouplingEnd(pair.p), q = MakeCouplingEnd(pair.q);
      if (Couple(p, q, 1e-3 * std::min(p.area_m2, q.area_m2)).regime != Regime::kZero) return pair;
      ConvexPolygon& turned = way % 2 == 0 ? pair.p : pair.q;
      turned = Reversed(turned);
    }
  }
}

ConvexPolygon RandomPolygon(Random& random, const Vec3& centre, const Vec3& normal, double radius,
                            double aspect) {
  const auto [s, t] = Frame(random, normal);
  for (;;) {
    ConvexPolygon polygon;
    polygon.count = random.Unit() < 0.3 ? 3 : 4;
    std::vector<double> angle(polygon.count);
    for (double& a : angle) a = 2 * kPi * random.Unit();
    std::sort(angle.begin(), angle.end());
    for (int i = 0; i < polygon.count; ++i) {
      polygon.v[i] = centre + radius * (std::cos(angle[i]) * s + std::sin(angle[i]) / aspect * t);
    }
    if (polygon.Area() > 0.3 * radius * radius / aspect) return polygon;
  }
}

ConvexPolygon Motion::operator()(const ConvexPolygon& polygon) const {
  ConvexPolygon moved = polygon;
  for (Vec3& v : moved.v) {
    v = scale * (Vec3(glm::dot(rows[0], v), glm::dot(rows[1], v), glm::dot(rows[2], v)) + offset);
  }
  return moved;
}

Motion RandomRotation(Random& random) {
  Motion motion;
  motion.rows[2] = RandomDirection(random);
  std::tie(motion.rows[0], motion.rows[1]) = Frame(random, motion.rows[2]);
  return motion;
}

ConvexPolygon Reversed(const ConvexPolygon& polygon) {
  ConvexPolygon reversed = polygon;
  std::reverse(reversed.v.begin(), reversed.v.begin() + polygon.count);
  return reversed;
}

}  // namespace isolux::testing
