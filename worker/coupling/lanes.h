// Four doubles side by side, and the few functions on them that the kernels need. Our own logarithm
// and arc tangent, since those of the C library differ between machines.
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
// Bit i says whether lane i is set.
inline int Bits(LaneMask mask) { return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask)); }
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

inline Vec3x4 Select(LaneMask mask, const Vec3x4& yes, const Vec3x4& no) {
  return {Select(mask, yes.x, no.x), Select(mask, yes.y, no.y), Select(mask, yes.z, no.z)};
}
inline Vec3x4 operator-(const Vec3& a, const Vec3x4& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3x4 operator-(const Vec3x4& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3x4 operator-(const Vec3x4& a, const Vec3x4& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3x4 operator+(const Vec3x4& a, const Vec3x4& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3x4 Cross(const Vec3& a, const Vec3x4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3x4 Cross(const Vec3x4& a, const Vec3x4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Lanes Dot(const Vec3x4& a, const Vec3x4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lanes Dot(const Vec3& a, const Vec3x4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Natural logarithm of normal positive numbers, within one unit in the last place; anything else
// gives nonsense, never a trap. Reduction to [√½, √2) and polynomial: [Ng93].
inline Lanes Log(Lanes x) {
  constexpr int64_t kRootHalf = 0x3fe6a09e667f3bcd;  // the bits of √½
  constexpr int64_t kBias = 1023;
  const LaneMask bits = reinterpret_cast<LaneMask>(x);
  // Exponent of the nearest power of two, plus the bias; a logical shift serves since it is >= 0.
  const LaneMask biased = reinterpret_cast<LaneMask>(
      _mm256_srli_epi64(reinterpret_cast<__m256i>(bits - kRootHalf + (kBias << 52)), 52));
  // As a double, by the bits of 2^52 + biased.
  const Lanes k = reinterpret_cast<Lanes>(biased | 0x4330000000000000) - (0x1p52 + kBias);
  const Lanes f = reinterpret_cast<Lanes>(bits - ((biased - kBias) << 52)) - 1.0;
  const Lanes s = f / (2.0 + f);
  const Lanes z = s * s;
  const Lanes w = z * z;
  const Lanes even = w * (3.999999999940941908e-01 +
                          w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  const Lanes odd = z * (6.666666666666735130e-01 +
                         w * (2.857142874366239149e-01 +
                              w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
  const Lanes half = 0.5 * f * f;
  return k * 6.93147180369123816490e-01 -
         ((half - (s * (half + even + odd) + k * 1.90821492927058770002e-10)) - f);
}

inline double Total(Lanes a) { return (a[0] + a[1]) + (a[2] + a[3]); }

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
