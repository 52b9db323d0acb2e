#include "worker/radiosity/disc_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/util/angles.h"

namespace isolux {
namespace {

// Cells are alike where no channel differs by more than this share.
constexpr double kAlike = 0.05;
// Deviation of the share that a straight border leaves of the disc, times cells a side to the power
// of 3/2 (disc_grid_test).
constexpr double kDeviation = 0.4;

bool Differ(const Rgb& a, const Rgb& b) {
  for (int c = 0; c < 3; ++c) {
    if (std::abs(a[c] - b[c]) > kAlike * std::max(a[c], b[c])) return true;
  }
  return false;
}

// A cell's middle in the disk, as is said of PointOfDisc.
std::array<double, 2> MiddleOf(int cells, size_t cell) {
  const auto side = static_cast<size_t>(cells);
  const double half = 0.5 * cells;
  const auto [x, y] = SquareToDisk((static_cast<double>(cell % side) + 0.5) / half - 1,
                                   (static_cast<double>(cell / side) + 0.5) / half - 1);
  return {x, y};
}

// Of cells, row by row; as if they were sectors of rings.
std::vector<std::array<double, 2>> MakeCentroids(int cells) {
  std::vector<std::array<double, 2>> centroids(static_cast<size_t>(cells) * cells);
  for (size_t i = 0; i < centroids.size(); ++i) {
    const auto [x, y] = MiddleOf(cells, i);
    const double r = std::sqrt(x * x + y * y), r0 = r - 1.0 / cells, r1 = r + 1.0 / cells;
    const double half_angle = std::numbers::pi / (4 * cells * r);
    const double scale = 2 * (r0 * r0 + r0 * r1 + r1 * r1) / (3 * (r0 + r1)) / r *
                         CosineAndSine(half_angle).second / half_angle;
    centroids[i] = {scale * x, scale * y};
  }
  return centroids;
}

const std::vector<std::array<double, 2>>& CentroidsOf(int cells) {
  static_assert(DiscGrid::kFewestCells == 4 && DiscGrid::kMostCells == 32);
  static const std::array<std::vector<std::array<double, 2>>, 4> kCentroids = {
      MakeCentroids(4), MakeCentroids(8), MakeCentroids(16), MakeCentroids(32)};
  return kCentroids[static_cast<size_t>(std::countr_zero(static_cast<unsigned>(cells)) - 2)];
}

}  // namespace

DiscGrid::DiscGrid(int most_cells, Random random)
    : most_cells_(most_cells),
      random_(random),
      turn_(random_.Unit() - 0.5),
      light_(static_cast<size_t>(kFewestCells) * kFewestCells),
      unknown_(light_.size()) {
  std::iota(unknown_.begin(), unknown_.end(), 0U);
}

int DiscGrid::CellsFor(double accuracy) {
  int cells = 2 * kFewestCells;
  while (cells < kMostCells && 3 * kDeviation * std::pow(cells, -1.5) > accuracy) cells *= 2;
  return cells;
}

std::array<double, 2> PointOfDisc(int cells, uint32_t cell, Random& random) {
  const auto side = static_cast<uint32_t>(cells);
  const double width = 2.0 / cells;
  const double a = (cell % side + random.Unit()) * width - 1;
  const auto [x, y] = SquareToDisk(a, (cell / side + random.Unit()) * width - 1);
  return {x, y};
}

std::array<double, 2> DiscGrid::PointIn(uint32_t cell) {
  const int column = static_cast<int>(cell) % cells_, row = static_cast<int>(cell) / cells_;
  const bool on_rim = std::min(column, row) == 0 || std::max(column, row) == cells_ - 1;
  if (cells_ == most_cells_ || !on_rim) return PointOfDisc(cells_, cell, random_);
  // Middles of cells along the rim are evenly spaced.
  const auto [x, y] = MiddleOf(cells_, cell);
  const auto [cosine, sine] = CosineAndSine(turn_ * std::numbers::pi / (2 * (cells_ - 1)));
  const double r = std::sqrt(x * x + y * y);
  return {(cosine * x - sine * y) / r, (sine * x + cosine * y) / r};
}

bool DiscGrid::IsBorder(int x, int y) const {
  const auto at = [&](int column, int row) -> const Rgb& {
    return light_[static_cast<size_t>(row * cells_ + column)];
  };
  for (int row = std::max(0, y - 1); row <= std::min(cells_ - 1, y + 1); ++row) {
    for (int column = std::max(0, x - 1); column <= std::min(cells_ - 1, x + 1); ++column) {
      if (Differ(at(x, y), at(column, row))) return true;
    }
  }
  return false;
}

bool DiscGrid::Divide() {
  if (cells_ == most_cells_) return false;
  std::vector<Rgb> light(4 * light_.size());
  unknown_.clear();
  for (int y = 0; y < cells_; ++y) {
    for (int x = 0; x < cells_; ++x) {
      const bool border = IsBorder(x, y);
      for (int k = 0; k < 4; ++k) {
        const int part = (2 * y + k / 2) * 2 * cells_ + 2 * x + k % 2;
        light[static_cast<size_t>(part)] = light_[static_cast<size_t>(y * cells_ + x)];
        if (border) unknown_.push_back(static_cast<uint32_t>(part));
      }
    }
  }
  if (unknown_.empty()) return false;
  light_ = std::move(light);
  cells_ *= 2;
  return true;
}

Rgb DiscGrid::Mean(const std::array<double, 2>& slope, double sine) const {
  Rgb sum(0.0);
  double weights = 0;
  const std::vector<std::array<double, 2>>& centroids = CentroidsOf(cells_);
  for (size_t i = 0; i < light_.size(); ++i) {
    const auto [x, y] = centroids[i];
    const double weight = std::max(
        0.0, 1 + (slope[0] * x + slope[1] * y) / std::sqrt(1 - sine * sine * (x * x + y * y)));
    sum += weight * light_[i];
    weights += weight;
  }
  return sum / weights;
}

}  // namespace isolux
