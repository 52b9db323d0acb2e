// Form factors in closed form, by the numbers of the catalogue that has them [Howell10]: what exact
// cases are made of.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace isolux::testing {

// Coupling of opposed rectangles a × b at distance c, m²: C-11.
inline double OpposedRectangles(double a, double b, double c) {
  const double x = a / c, y = b / c;
  const double x1 = std::sqrt(1 + x * x), y1 = std::sqrt(1 + y * y);
  return 2 * a * b / (std::numbers::pi * x * y) *
         (std::log(x1 * y1 / std::sqrt(1 + x * x + y * y)) + x * y1 * std::atan(x / y1) +
          y * x1 * std::atan(y / x1) - x * std::atan(x) - y * std::atan(y));
}

// Coupling of rectangles at a right angle with a common side of this length, m²: C-14.
inline double RightAngle(double length, double height, double width) {
  const double h = height / length, w = width / length;
  const double h2 = h * h, w2 = w * w, s = 1 + h2 + w2;
  const double factor =
      (w * std::atan(1 / w) + h * std::atan(1 / h) -
       std::sqrt(h2 + w2) * std::atan(1 / std::sqrt(h2 + w2)) +
       0.25 * (std::log((1 + w2) * (1 + h2) / s) + w2 * std::log(w2 * s / ((1 + w2) * (w2 + h2))) +
               h2 * std::log(h2 * s / ((1 + h2) * (h2 + w2))))) /
      (std::numbers::pi * w);
  return factor * length * width;
}

using Interval = std::array<double, 2>;

// Σ ± g(a_i, b_j, c_k − d_l), the sign that of i + j + k + l.
template <typename Function>
double CornerSum(const Interval& a, const Interval& b, const Interval& c, const Interval& d,
                 const Function& g) {
  double sum = 0;
  for (int bits = 0; bits < 16; ++bits) {
    const int i = bits & 1, j = bits >> 1 & 1, k = bits >> 2 & 1, l = bits >> 3;
    sum += ((i + j + k + l) % 2 == 0 ? 1 : -1) * g(a[i], b[j], c[k] - d[l]);
  }
  return std::abs(sum) / (2 * std::numbers::pi);
}

// Coupling of parallel rectangles x × y and u × v at distance z, sides along the same axes, m²:
// C-13.
inline double ParallelRectangles(const Interval& x, const Interval& y, const Interval& u,
                                 const Interval& v, double z) {
  return CornerSum(x, u, y, v, [z](double at_x, double at_u, double dy) {
    const double dx = at_x - at_u;
    const double a = std::hypot(dx, z), b = std::hypot(dy, z);
    return dy * a * std::atan(dy / a) + dx * b * std::atan(dx / b) -
           0.5 * z * z * std::log(dx * dx + dy * dy + z * z);
  });
}

// Coupling of rectangles at a right angle, `x` and `z` away from the line that their planes share,
// `y` and `v` along it, m²: C-15.
inline double PerpendicularRectangles(const Interval& x, const Interval& z, const Interval& y,
                                      const Interval& v) {
  return CornerSum(x, z, y, v, [](double at_x, double at_z, double dy) {
    const double d = std::hypot(at_x, at_z), r2 = d * d + dy * dy;
    return r2 > 0 ? dy * d * std::atan2(dy, d) - 0.25 * (d * d - dy * dy) * std::log(r2) : 0.0;
  });
}

// Of a point under a corner of a parallel rectangle a × b at distance c: B-4.
inline double PointUnderCorner(double a, double b, double c) {
  const double x = a / c, y = b / c, x1 = std::sqrt(1 + x * x), y1 = std::sqrt(1 + y * y);
  return (x / x1 * std::atan(y / x1) + y / y1 * std::atan(x / y1)) / (2 * std::numbers::pi);
}

// Of a point at distance c from the foot of an upright rectangle, at its corner: `width` along the
// foot, `height` above it: B-5.
inline double PointBeforeUpright(double height, double width, double c) {
  const double r = std::hypot(height, c);
  return (std::atan(width / c) - c / r * std::atan(width / r)) / (2 * std::numbers::pi);
}

// From a disc of radius r1 to a coaxial one of radius r2 at distance h: C-41.
inline double CoaxialDiscs(double r1, double r2, double h) {
  const double a = r1 / h, b = r2 / h, x = 1 + (1 + b * b) / (a * a);
  return 0.5 * (x - std::sqrt(x * x - 4 * (b / a) * (b / a)));
}

// Between strips without end, by the lengths of strings round them [Hottel54]: opposed ones of this
// width, and the equal sides of a groove.
inline double OpposedStrips(double width, double distance) {
  const double h = distance / width;
  return std::sqrt(1 + h * h) - h;
}
inline double Groove(double angle) { return 1 - std::sin(angle / 2); }

}  // namespace isolux::testing
