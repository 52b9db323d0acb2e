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

}  // namespace isolux
