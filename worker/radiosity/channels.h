// One colour channel in a double, or three side by side in Lanes: what products and solvers are
// written over, so that a scene of one colour pays for one.
//
// Single is a vector of one double: it takes the same operators and [] as Lanes.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "worker/coupling/lanes.h"

namespace isolux {

using Single = double __attribute__((vector_size(8)));
using IntSingle = int64_t __attribute__((vector_size(8)));
using IntLanes = LaneMask;

template <typename V>
inline constexpr int kChannelsOf = std::is_same_v<V, Single> ? 1 : 3;
// Of V or of the integers beside it.
template <typename V>
inline constexpr int kLanesOf = sizeof(V) / sizeof(double);

template <typename V>
using MaskOf = std::conditional_t<std::is_same_v<V, Single>, IntSingle, IntLanes>;
template <typename Int>
using RealOf = std::conditional_t<std::is_same_v<Int, IntSingle>, Single, Lanes>;

inline Single Select(IntSingle mask, Single yes, Single no) { return mask[0] != 0 ? yes : no; }
// As Lanes have it: b where either is not a number.
inline Single Maximum(Single a, Single b) { return a[0] > b[0] ? a : b; }
inline Single SquareRoot(Single a) { return Single{std::sqrt(a[0])}; }
inline Single Absolute(Single a) { return Single{std::abs(a[0])}; }

// v rounded to integers, for |v| < 2^51.
template <typename V>
MaskOf<V> ToInteger(const V& v) {
  constexpr double kMagic = 0x1.8p52;
  const V magic = V{} + kMagic;
  return reinterpret_cast<MaskOf<V>>(v + kMagic) - reinterpret_cast<MaskOf<V>>(magic);
}

// Each the nearest double.
inline Single ToReal(IntSingle n) { return Single{static_cast<double>(n[0])}; }
inline Lanes ToReal(const IntLanes& n) {
  // By bits: 2^84 + 2^63 + the upper half, with its sign turned over; 2^52 + the lower half.
  const auto bits = reinterpret_cast<__m256i>(n);
  const auto upper =
      _mm256_xor_si256(_mm256_srli_epi64(bits, 32), _mm256_set1_epi64x(0x4530000080000000));
  const auto lower = _mm256_blend_epi32(bits, _mm256_set1_epi64x(0x4330000000000000), 0xaa);
  return (reinterpret_cast<Lanes>(upper) - (0x1p84 + 0x1p63 + 0x1p52)) +
         reinterpret_cast<Lanes>(lower);
}

// Without what stands after the point, for |v| < 2^63.
inline IntSingle Truncated(Single v) { return IntSingle{static_cast<int64_t>(v[0])}; }
inline IntLanes Truncated(const Lanes& v) {
  const LaneMask small = Absolute(v) < 0x1p51;
  if (Bits(small) == 15) {
    return ToInteger(reinterpret_cast<Lanes>(
        _mm256_round_pd(reinterpret_cast<__m256d>(v), _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC)));
  }
  IntLanes whole;
  for (int lane = 0; lane < 4; ++lane) whole[lane] = static_cast<int64_t>(v[lane]);
  return whole;
}

}  // namespace isolux
