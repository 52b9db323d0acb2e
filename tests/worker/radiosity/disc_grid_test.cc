// Shares of a disc past a straight border, against their closed form: how the error falls, and how
// many looks it takes.
#include "worker/radiosity/disc_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace isolux::testing {
namespace {

constexpr int kBorders = 4000;

struct Errors {
  double deviation = 0, mean = 0, looks = 0;
};

// Over borders at all places and in all directions.
Errors OfCells(int cells) {
  Errors errors;
  Random random(3);
  for (int n = 0; n < kBorders; ++n) {
    const double at = 2 * random.Unit() - 1, turn = 2 * std::numbers::pi * random.Unit();
    const double share = 0.5 - (std::asin(at) + at * std::sqrt(1 - at * at)) / std::numbers::pi;
    DiscGrid grid(cells, Random(random.Bits()));
    do {
      for (const uint32_t cell : grid.unknown()) {
        const auto [x, y] = grid.PointIn(cell);
        const bool lit = x * std::cos(turn) + y * std::sin(turn) > at;
        grid.Set(cell, Rgb(lit ? 2.0 : 0.0));
      }
      errors.looks += static_cast<double>(grid.unknown().size()) / kBorders;
    } while (grid.Divide());
    const double off = grid.Mean({0, 0}, 0.1).x / 2 - share;
    errors.deviation += off * off / kBorders;
    errors.mean += off / kBorders;
  }
  errors.deviation = std::sqrt(errors.deviation);
  return errors;
}

TEST(DiscGrid, ErrorsFallAsThePowerOfThreeHalves) {
  for (const int cells : {8, 16, 32}) {
    const Errors errors = OfCells(cells);
    std::printf("%d %g %g %g\n", cells, errors.deviation * std::pow(cells, 1.5), errors.mean,
                errors.looks);
    EXPECT_LT(errors.deviation, 0.4 * std::pow(cells, -1.5));
    EXPECT_LT(std::abs(errors.mean), 4 * errors.deviation / std::sqrt(kBorders));
    EXPECT_LT(errors.looks, 12 * cells);
  }
}

TEST(DiscGrid, AsksForCellsByAccuracy) {
  EXPECT_EQ(DiscGrid::CellsFor(0.2), 8);
  EXPECT_EQ(DiscGrid::CellsFor(0.02), 16);
  EXPECT_EQ(DiscGrid::CellsFor(0.01), 32);
  EXPECT_EQ(DiscGrid::CellsFor(1e-6), 32);
}

TEST(DiscGrid, LooksNoFurtherWithoutBorders) {
  DiscGrid grid(32, Random(1));
  ASSERT_EQ(grid.unknown().size(), 16U);
  for (uint32_t cell = 0; cell < 16; ++cell) grid.Set(cell, Rgb(3, 2, 1));
  EXPECT_FALSE(grid.Divide());
  EXPECT_EQ(grid.cells(), 4);
  for (int c = 0; c < 3; ++c) EXPECT_DOUBLE_EQ(grid.Mean({0.3, -0.4}, 0.1)[c], 3 - c);
}

// A pane that takes a third of one channel from one of the cells makes a border as well.
TEST(DiscGrid, DividesWhereAChannelDiffers) {
  DiscGrid grid(32, Random(1));
  for (uint32_t cell = 0; cell < 16; ++cell) grid.Set(cell, Rgb(1.0));
  grid.Set(0, Rgb(1, 1, 0.67));
  ASSERT_TRUE(grid.Divide());
  EXPECT_EQ(grid.unknown().size(), 16U);  // the parts of the corner and its three neighbours
  EXPECT_NEAR(grid.Mean({0, 0}, 0.1).z, (15 + 0.67) / 16, 1e-12);
}

}  // namespace
}  // namespace isolux::testing
