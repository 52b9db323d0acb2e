// A sum of doubles that does not depend on the order of its terms: a fixed-point number wide enough
// for every finite double, kept as signed 64-bit limbs of 32 bits each (Kulisch's long
// accumulator). Adding, and adding two sums, is integer addition, hence associative; only Value()
// rounds, once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isolux {

class ExactSum {
 public:
  // Adds one finite double. Not thread-safe; keep one a thread and Add them up.
  void Add(double value);
  void Add(const ExactSum& other);

  // The exact sum, rounded to nearest.
  double Value() const;

  // Wire form: index of the first limb that is not zero, then the limbs up to the last, normalised
  // so that equal sums have equal words whatever the order of their terms.
  std::vector<int64_t> ToWords() const;
  // False when the words cannot be a sum (wrong length or range).
  [[nodiscard]] static bool FromWords(std::span<const int64_t> words, ExactSum* sum);

 private:
  // Exponents -1074 .. 1023 plus 64 bits for carries, 32 bits a limb.
  static constexpr int kLimbs = 68;
  static constexpr int kLowestExponent = -1088;  // weight of limb 0 is 2^kLowestExponent
  void Normalise();

  std::array<int64_t, kLimbs> limbs_{};
  uint32_t pending_ = 0;  // additions since the last carry propagation
};

}  // namespace isolux
