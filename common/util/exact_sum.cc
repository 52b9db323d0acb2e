#include "common/util/exact_sum.h"

#include <bit>
#include <cmath>

#include "common/util/check.h"

namespace isolux {

void ExactSum::Add(double value) {
  if (value == 0.0) return;
  const uint64_t bits = std::bit_cast<uint64_t>(value);
  const int biased = static_cast<int>((bits >> 52) & 0x7ff);
  CHECK_LT(biased, 0x7ff);
  uint64_t mantissa = bits & ((1ULL << 52) - 1);
  if (biased != 0) mantissa |= 1ULL << 52;
  // value = mantissa * 2^(exponent); split over three limbs.
  const int exponent = (biased == 0 ? 1 : biased) - 1075;
  const int position = exponent - kLowestExponent;
  const int limb = position >> 5;
  const int shift = position & 31;
  const unsigned __int128 wide = static_cast<unsigned __int128>(mantissa) << shift;
  const int64_t sign = (bits >> 63) != 0 ? -1 : 1;
  limbs_[limb] += sign * static_cast<int64_t>(static_cast<uint32_t>(wide));
  limbs_[limb + 1] += sign * static_cast<int64_t>(static_cast<uint32_t>(wide >> 32));
  limbs_[limb + 2] += sign * static_cast<int64_t>(static_cast<uint32_t>(wide >> 64));
  if (++pending_ >= (1U << 30)) Normalise();
}

void ExactSum::Add(const ExactSum& other) {
  ExactSum addend = other;
  addend.Normalise();
  Normalise();
  for (int i = 0; i < kLimbs; ++i) limbs_[i] += addend.limbs_[i];
  pending_ = 1;
}

// Brings every limb but the last into [0, 2^32); the last carries the sign.
void ExactSum::Normalise() {
  int64_t carry = 0;
  for (int i = 0; i + 1 < kLimbs; ++i) {
    const int64_t value = limbs_[i] + carry;
    carry = value >> 32;
    limbs_[i] = value & 0xffffffffLL;
  }
  limbs_[kLimbs - 1] += carry;
  pending_ = 0;
}

double ExactSum::Value() const {
  ExactSum sum = *this;
  sum.Normalise();
  const bool negative = sum.limbs_[kLimbs - 1] < 0;
  if (negative) {
    for (auto& limb : sum.limbs_) limb = -limb;
    sum.Normalise();
  }
  int top = kLimbs - 1;
  while (top >= 0 && sum.limbs_[top] == 0) --top;
  if (top < 0) return 0.0;
  // The highest 64 bits, with everything below folded into a sticky last bit, round correctly once.
  unsigned __int128 head = 0;
  for (int i = 0; i < 4; ++i) {
    head = (head << 32) | static_cast<uint64_t>(top - i >= 0 ? sum.limbs_[top - i] : 0);
  }
  const auto leading =
      static_cast<int>((head >> 64) != 0 ? std::countl_zero(static_cast<uint64_t>(head >> 64))
                                         : 64 + std::countl_zero(static_cast<uint64_t>(head)));
  // The top limb is not zero, so at least 97 bits stand in head: 55 are kept, the last one sticky.
  const int drop = 128 - leading - 55;
  auto mantissa = static_cast<uint64_t>(head >> drop);
  bool sticky = (head & ((static_cast<unsigned __int128>(1) << drop) - 1)) != 0;
  for (int i = top - 4; i >= 0 && !sticky; --i) sticky = sum.limbs_[i] != 0;
  if (sticky) mantissa |= 1;
  // 55 bits to 53 by hand, half to even, so that the conversion below is exact.
  const uint64_t tail = mantissa & 3;
  mantissa >>= 2;
  if (tail > 2 || (tail == 2 && (mantissa & 1) != 0)) ++mantissa;
  const int exponent = kLowestExponent + 32 * (top - 3) + drop + 2;
  const double value = std::ldexp(static_cast<double>(mantissa), exponent);
  return negative ? -value : value;
}

std::vector<int64_t> ExactSum::ToWords() const {
  ExactSum sum = *this;
  sum.Normalise();
  int first = 0;
  int last = kLimbs - 1;
  while (first < kLimbs && sum.limbs_[first] == 0) ++first;
  if (first == kLimbs) return {};
  while (sum.limbs_[last] == 0) --last;
  std::vector<int64_t> words{first};
  words.insert(words.end(), sum.limbs_.begin() + first, sum.limbs_.begin() + last + 1);
  return words;
}

bool ExactSum::FromWords(std::span<const int64_t> words, ExactSum* sum) {
  *sum = ExactSum();
  if (words.empty()) return true;
  const int64_t first = words[0];
  if (first < 0 || first + static_cast<int64_t>(words.size()) - 1 > kLimbs) return false;
  for (size_t i = 1; i < words.size(); ++i) {
    const int64_t limb = words[i];
    const bool top = first + static_cast<int64_t>(i) == kLimbs;
    if (!top && (limb < 0 || limb > 0xffffffffLL)) return false;
    sum->limbs_[first + i - 1] = limb;
  }
  return true;
}

}  // namespace isolux
