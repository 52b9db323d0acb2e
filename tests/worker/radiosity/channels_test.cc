// Integers and reals side by side are what they are one by one.
#include "worker/radiosity/channels.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

#include "common/util/random.h"

namespace isolux {
namespace {

// Of all sizes and both signs, and where powers of two and halves are near.
std::vector<int64_t> Integers() {
  std::vector<int64_t> integers{0, 1, -1, INT64_MAX, INT64_MIN, INT64_MIN + 1};
  for (int power = 1; power < 63; ++power) {
    for (const int64_t off : {-1, 0, 1}) {
      integers.push_back((int64_t{1} << power) + off);
      integers.push_back(-(int64_t{1} << power) + off);
    }
  }
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const double magnitude = std::ldexp(random.Unit(), static_cast<int>(63 * random.Unit()));
    integers.push_back(static_cast<int64_t>(random.Unit() < 0.5 ? -magnitude : magnitude) ^ i);
  }
  while (integers.size() % 4 != 0) integers.push_back(0);
  return integers;
}

TEST(Channels, IntegersBecomeTheNearestReals) {
  const std::vector<int64_t> integers = Integers();
  for (size_t i = 0; i < integers.size(); i += 4) {
    const IntLanes four{integers[i], integers[i + 1], integers[i + 2], integers[i + 3]};
    const Lanes reals = ToReal(four);
    for (int lane = 0; lane < 4; ++lane) {
      const double expected = static_cast<double>(four[lane]);
      ASSERT_EQ(std::bit_cast<uint64_t>(reals[lane]), std::bit_cast<uint64_t>(expected))
          << four[lane];
      ASSERT_EQ(ToReal(IntSingle{four[lane]})[0], expected);
    }
  }
}

TEST(Channels, TruncatedTakesAwayWhatStandsAfterThePoint) {
  std::vector<double> reals{0.0,    -0.0,   0.5,     -0.5,         1 - 0x1p-53,    0x1p-1074,
                            -0.999, 0x1p51, -0x1p51, 0x1p51 - 0.5, -0x1p51 + 0.25, 0x1p62};
  for (const int64_t n : Integers()) {
    if (std::abs(static_cast<double>(n)) < 0x1p62) reals.push_back(static_cast<double>(n) / 3);
  }
  while (reals.size() % 4 != 0) reals.push_back(0);
  for (size_t i = 0; i < reals.size(); i += 4) {
    const Lanes four{reals[i], reals[i + 1], reals[i + 2], reals[i + 3]};
    const IntLanes whole = Truncated(four);
    for (int lane = 0; lane < 4; ++lane) {
      ASSERT_EQ(whole[lane], static_cast<int64_t>(four[lane])) << four[lane];
      ASSERT_EQ(Truncated(Single{four[lane]})[0], whole[lane]);
    }
  }
}

}  // namespace
}  // namespace isolux
