// The potential of a straight edge, and what bounds the error of integrating it along another: the
// parts of the contour integral. For contour.cc.
//
//   G_f(x) = ∫_f ln|x − y| dy + L_f
//          = b/2 ln(b² + g²) − a/2 ln(a² + g²) + g atan2(g L_f, g² + a b)
//
// with f from a to b = a + L_f along its line, seen from the foot of x, and g the distance of x
// from the line. G is bounded and continuous everywhere.
#pragma once

#include <array>
#include <span>

#include "worker/coupling/lanes.h"

namespace isolux {

struct Edge {
  Vec3 start{0.0};
  Vec3 along{0.0};  // unit
  double length = 0;
};

// The edges of a polygon of three to five corners, but for those without length.
struct Edges {
  int count = 0;
  std::array<Edge, 5> edge;
  double perimeter = 0;

  explicit Edges(std::span<const Vec3> corners);
};

// G − turn·g. With turn = π it is what is left where x is beside f: what G has in common with the
// potential of the whole line of f, which is π g and varies fast near it, is taken off.
inline Lanes Potential(Lanes a, Lanes length, Lanes distance2, Lanes turn) {
  const Lanes b = a + length;
  const Lanes tiny = Splat(1e-300);  // times a vanishing factor
  const Lanes log_a = Log(Maximum(a * a + distance2, tiny));
  const Lanes log_b = Log(Maximum(b * b + distance2, tiny));
  const Lanes distance = SquareRoot(distance2);
  const Lanes angle = Atan2Upper(distance * length, distance2 + a * b);
  return 0.5 * (b * log_b - a * log_a) + distance * (angle - turn);
}

// Gauss's rules of two to four points on [0, 1].
struct GaussRule {
  std::array<double, 4> point, weight;
};
inline constexpr std::array<GaussRule, 3> kGauss{{
    {{0.21132486540518712, 0.78867513459481288, 0, 0}, {0.5, 0.5, 0, 0}},
    {{0.1127016653792583, 0.5, 0.8872983346207417, 0}, {5.0 / 18, 8.0 / 18, 5.0 / 18, 0}},
    {{0.069431844202973712, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629},
     {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693}},
}};

// Upper bounds of the errors of those rules on a piece of half length h, of ln|x − y| integrated
// over y on a line that is nowhere nearer than R to the piece's centre, by expansion about the
// centre: constant · (h/R)^2n /(1 − (h/R)²)² · h · size, size being the length of the line, or 1.6
// R if that is less; the same holds of the distance from a line, over π, where R is its distance
// over the sine between them, and size is 1.6 times that distance.
inline constexpr std::array<double, 3> kExpansion{0.045, 0.0078, 0.0015};
inline constexpr double kLineShare = 1.6;
inline Lanes ExpansionBound(int points, Lanes half, Lanes ratio2, Lanes size) {
  const Lanes rest = 1.0 - ratio2;
  const Lanes ratio4 = ratio2 * ratio2;
  const Lanes power = points == 2 ? ratio4 : points == 3 ? ratio4 * ratio2 : ratio4 * ratio4;
  const Lanes bound = kExpansion[points - 2] * half * size * power / (rest * rest);
  return Select(ratio2 < 0.64, bound, Splat(1e300));
}

// Upper bound of the error of four points for the distance from a line: times the sine between the
// line and the piece, and h².
inline constexpr double kKink = 0.3;

// ∫ g ds along a piece, g² = alpha + u² being the squared distance from a line: u runs along the
// piece from the point nearest to the line, times the sine between the two. `from` and `to` are in
// u.
Lanes LineDistance(Lanes from, Lanes to, Lanes alpha, Lanes sine);

// ∫_e G_f for parallel edges: e and f have this distance, f starts at `a` seen from the start of e,
// and `direction` (1 or −1) says whether both run the same way.
double ParallelEdges(double a, double distance, double length_e, double length_f, double direction);

}  // namespace isolux
