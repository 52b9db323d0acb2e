// Mean of the light that comes from a disc, past what hides parts of it: cells of equal areas, a
// look into each, and more looks along the borders between what arrives and what does not. A border
// runs through a number of cells that grows as cells a side do, each with an error of its area: all
// together the error falls as the number a side to the power of 3/2, and rays grow as the number.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/util/random.h"
#include "common/vec.h"

namespace isolux {

// A point of the unit disk, by chance in one of `cells` times `cells` parts of equal areas.
std::array<double, 2> PointOfDisc(int cells, uint32_t cell, Random& random);

class DiscGrid {
 public:
  // A side, from the start; and at most.
  static constexpr int kFewestCells = 4, kMostCells = 32;

  // most_cells: a power of two between those.
  DiscGrid(int most_cells, Random random);

  // Cells a side at most that an accuracy asks for, 8 to 32: three deviations of the share that a
  // straight border leaves of the disc are below it.
  static int CellsFor(double accuracy);

  int cells() const { return cells_; }  // a side
  // Cells that are yet to be looked into, by number.
  std::span<const uint32_t> unknown() const { return unknown_; }
  // A point of the unit disk, by chance in that cell. While cells may still be divided, those along
  // the rim are looked at on the rim, which whatever reaches into the disc from outside crosses.
  std::array<double, 2> PointIn(uint32_t cell);
  void Set(uint32_t cell, const Rgb& light) { light_[cell] = light; }

  // Divides all cells into four. Those beside others where the light differs are unknown then, the
  // rest are as they were. False, and nothing done, where there is no border, or enough cells.
  bool Divide();

  // Of the light, where a point p of the unit disk counts 1 + slope · p / √(1 − sine² p²), or
  // nothing where that is negative: as the cosines of a disc's points go, `sine` that of its
  // radius.
  Rgb Mean(const std::array<double, 2>& slope, double sine) const;

 private:
  bool IsBorder(int x, int y) const;

  int cells_ = kFewestCells, most_cells_;
  Random random_;
  double turn_;             // of points on the rim, in cells
  std::vector<Rgb> light_;  // row by row
  std::vector<uint32_t> unknown_;
};

}  // namespace isolux
