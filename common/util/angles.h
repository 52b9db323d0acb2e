// Angles by sums and products alone: the same bits on every machine, which the C library's
// functions do not have.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>

namespace isolux {

// Angle of (x, y) in [−π, π]; 0 where both are 0. Error below 1e-15.
// Rational approximation of atan on [0, 0.66]: Moshier, Cephes 1989.
inline double Angle(double y, double x) {
  const double ax = std::abs(x), ay = std::abs(y);
  const double low = ax < ay ? ax : ay, high = ax < ay ? ay : ax;
  if (high == 0) return 0;
  const bool upper = low > 0.66 * high;  // there atan t = π/4 + atan((t − 1)/(t + 1))
  const double t = upper ? (low - high) / (low + high) : low / high;
  const double z = t * t;
  const double p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
                     7.500855792314704667340e1) *
                        z -
                    1.228866684490136173410e2) *
                       z -
                   6.485021904942025371773e1;
  const double q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                     4.328810604912902668951e2) *
                        z +
                    4.853903996359136964868e2) *
                       z +
                   1.945506571482613964425e2;
  double angle = t + t * z * (p / q);
  if (upper) angle += std::numbers::pi / 4;
  if (ay > ax) angle = std::numbers::pi / 2 - angle;
  if (x < 0) angle = std::numbers::pi - angle;
  return y < 0 ? -angle : angle;
}

// Cosine and sine of an angle in [−π/4, π/4], by Taylor's series. Error below 1e-15.
inline std::pair<double, double> CosineAndSine(double angle) {
  const double z = angle * angle;
  double cosine = 1, sine = 1;
  for (int k = 8; k > 0; --k) {
    cosine = 1 - z * cosine / ((2 * k - 1) * (2 * k));
    sine = 1 - z * sine / ((2 * k) * (2 * k + 1));
  }
  return {cosine, angle * sine};
}

// The point of the unit disk that belongs to a point of the square [−1, 1]²: equal areas to equal
// areas, squares about the centre to circles ([ShirleyChiu97]).
inline std::pair<double, double> SquareToDisk(double a, double b) {
  if (a == 0 && b == 0) return {0, 0};
  if (std::abs(a) > std::abs(b)) {
    const auto [cosine, sine] = CosineAndSine(std::numbers::pi / 4 * (b / a));
    return {a * cosine, a * sine};
  }
  const auto [cosine, sine] = CosineAndSine(std::numbers::pi / 4 * (a / b));
  return {b * sine, b * cosine};
}

}  // namespace isolux
