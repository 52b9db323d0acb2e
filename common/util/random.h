// Counter-based random numbers: a sample is a function of what it is for (node ids, index), never
// of the thread or worker that draws it or of how many were drawn before.
#pragma once

#include <cstdint>

namespace isolux {

// Bijective 64-bit mixer (splitmix64's finaliser, Steele et al. 2014).
constexpr uint64_t Mix(uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

constexpr uint64_t Hash(uint64_t a, uint64_t b) { return Mix(a ^ Mix(b)); }
constexpr uint64_t Hash(uint64_t a, uint64_t b, uint64_t c) { return Hash(Hash(a, b), c); }

// Uniform in [0, 1), 53 bits.
constexpr double ToUnit(uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

// A stream of numbers that starts from a seed; two streams with different seeds are unrelated.
class Random {
 public:
  explicit constexpr Random(uint64_t seed) : state_(seed) {}
  constexpr uint64_t Bits() { return Mix(state_++ * 0xd1342543de82ef95ULL); }
  constexpr double Unit() { return ToUnit(Bits()); }

 private:
  uint64_t state_;
};

}  // namespace isolux
