// Eight floats side by side, for sums of many small terms: the form factors of the gather. Our own
// arc tangent, as in lanes.h.
#pragma once

#include <immintrin.h>

#include <cstdint>

namespace isolux {

using FloatLanes = float __attribute__((vector_size(32)));
using Int32Lanes = int32_t __attribute__((vector_size(32)));
using UInt32Lanes = uint32_t __attribute__((vector_size(32)));

inline FloatLanes SplatFloat(float v) { return FloatLanes{v, v, v, v, v, v, v, v}; }
inline FloatLanes Select(Int32Lanes mask, FloatLanes yes, FloatLanes no) {
  return reinterpret_cast<FloatLanes>(_mm256_blendv_ps(
      reinterpret_cast<__m256>(no), reinterpret_cast<__m256>(yes), reinterpret_cast<__m256>(mask)));
}
inline FloatLanes Minimum(FloatLanes a, FloatLanes b) {
  return reinterpret_cast<FloatLanes>(_mm256_min_ps(a, b));
}
inline FloatLanes Maximum(FloatLanes a, FloatLanes b) {
  return reinterpret_cast<FloatLanes>(_mm256_max_ps(a, b));
}
inline FloatLanes SquareRoot(FloatLanes a) {
  return reinterpret_cast<FloatLanes>(_mm256_sqrt_ps(a));
}
inline FloatLanes Absolute(FloatLanes a) {
  return reinterpret_cast<FloatLanes>(reinterpret_cast<Int32Lanes>(a) & INT32_MAX);
}
// Bit i says whether lane i is set.
inline int Bits(Int32Lanes mask) { return _mm256_movemask_ps(reinterpret_cast<__m256>(mask)); }

// Angle of (x, y) for y ≥ 0, in [0, π]; 0 where both are 0. Relative error below 3e-7.
// Polynomial of atan on [−0.42, 0.42]: [Moshier89].
inline FloatLanes Atan2Upper(FloatLanes y, FloatLanes x) {
  const FloatLanes ax = Absolute(x);
  const FloatLanes low = Minimum(y, ax);
  const FloatLanes high = Maximum(y, ax);
  const Int32Lanes upper = low > 0.41421356F * high;  // atan t = π/4 + atan((t − 1)/(t + 1))
  const FloatLanes numerator = Select(upper, low - high, low);
  FloatLanes denominator = Select(upper, low + high, high);
  denominator = Select(denominator == 0.0F, SplatFloat(1), denominator);
  const FloatLanes t = numerator / denominator;
  const FloatLanes z = t * t;
  FloatLanes angle =
      t + t * z *
              (((8.05374449538e-2F * z - 1.38776856032e-1F) * z + 1.99777106478e-1F) * z -
               3.33329491539e-1F);
  angle = Select(upper, angle + 0.785398163397F, angle);
  angle = Select(y > ax, 1.570796326795F - angle, angle);
  return Select(x < 0.0F, 3.141592653590F - angle, angle);
}

// Uniform in [0, 1), 24 bits, from 32 hashed bits each ([Appleby11]).
inline FloatLanes UnitFromHash(UInt32Lanes x) {
  x ^= x >> 16;
  x *= 0x85ebca6bU;
  x ^= x >> 13;
  x *= 0xc2b2ae35U;
  x ^= x >> 16;
  return __builtin_convertvector(reinterpret_cast<Int32Lanes>(x >> 8), FloatLanes) * 0x1p-24F;
}

}  // namespace isolux
