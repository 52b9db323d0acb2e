// Four doubles side by side, and the few functions on them that the kernels need. Our own arc
// tangent, since that of the C library differs between machines.
#pragma once

#include <immintrin.h>

#include <array>

#include "common/vec.h"

namespace isolux {

using Lanes = double __attribute__((vector_size(32)));
using LaneMask = int64_t __attribute__((vector_size(32)));

inline Lanes Splat(double value) { return Lanes{value, value, value, value}; }
inline Lanes Select(LaneMask mask, Lanes yes, Lanes no) {
  return reinterpret_cast<Lanes>((mask & reinterpret_cast<LaneMask>(yes)) |
                                 (~mask & reinterpret_cast<LaneMask>(no)));
}
inline Lanes Minimum(Lanes a, Lanes b) { return reinterpret_cast<Lanes>(_mm256_min_pd(a, b)); }
inline Lanes Maximum(Lanes a, Lanes b) { return reinterpret_cast<Lanes>(_mm256_max_pd(a, b)); }
inline Lanes SquareRoot(Lanes a) { return reinterpret_cast<Lanes>(_mm256_sqrt_pd(a)); }
inline Lanes Absolute(Lanes a) {
  return reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(a) &
                                 LaneMask{INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX});
}

// Four points or vectors.
struct Vec3x4 {
  Lanes x, y, z;

  Vec3x4() = default;
  Vec3x4(Lanes px, Lanes py, Lanes pz) : x(px), y(py), z(pz) {}
  explicit Vec3x4(const std::array<Vec3, 4>& p)
      : x{p[0].x, p[1].x, p[2].x, p[3].x},
        y{p[0].y, p[1].y, p[2].y, p[3].y},
        z{p[0].z, p[1].z, p[2].z, p[3].z} {}
};

inline Vec3x4 operator-(const Vec3& a, const Vec3x4& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3x4 operator-(const Vec3x4& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3x4 Cross(const Vec3x4& a, const Vec3x4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Lanes Dot(const Vec3x4& a, const Vec3x4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lanes Dot(const Vec3& a, const Vec3x4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Angle of (x, y) for y ≥ 0, in [0, π]; 0 where both are 0. Relative error below 1e-15.
// Rational approximation of atan on [0, 0.66]: Moshier, Cephes 1989.
inline Lanes Atan2Upper(Lanes y, Lanes x) {
  const Lanes ax = Absolute(x);
  const Lanes low = Minimum(y, ax);
  const Lanes high = Maximum(y, ax);
  const LaneMask upper = low > 0.66 * high;  // there atan t = π/4 + atan((t − 1)/(t + 1))
  const Lanes numerator = Select(upper, low - high, low);
  Lanes denominator = Select(upper, low + high, high);
  denominator = Select(denominator == 0.0, Splat(1.0), denominator);
  const Lanes t = numerator / denominator;
  const Lanes z = t * t;
  const Lanes p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
                    7.500855792314704667340e1) *
                       z -
                   1.228866684490136173410e2) *
                      z -
                  6.485021904942025371773e1;
  const Lanes q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                    4.328810604912902668951e2) *
                       z +
                   4.853903996359136964868e2) *
                      z +
                  1.945506571482613964425e2;
  Lanes angle = t + t * z * (p / q);
  angle = Select(upper, angle + 0.78539816339744830962, angle);
  angle = Select(y > ax, 1.57079632679489661923 - angle, angle);
  return Select(x < 0.0, 3.14159265358979323846 - angle, angle);
}

}  // namespace isolux
