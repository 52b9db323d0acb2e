// The unit cube of reflectance 0.5 whose floor emits 1: its irradiance everywhere, and how far a
// solve of so many links is from it. For a test and a benchmark of convergence.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "common/util/parallel.h"
#include "common/vec.h"
#include "worker/coupling/lanes.h"

namespace isolux::testing {

// Irradiance by a dense solution with exact couplings over an even grid, gathered over a finer one
// that narrows towards the edges, again and again: every step takes three quarters of what is off.
class CubeReference {
 public:
  // Cells along an edge: of the solution, of what is gathered; how often it is.
  struct Grid {
    int coarse = 16, fine = 32, steps = 2;
    bool narrowing = false;
  };
  CubeReference(const Grid& grid, ThreadPool& pool);

  // At four points of one face: x low, x high, y low, y high, the floor, the ceiling.
  Lanes IrradianceAt(const std::array<Vec3, 4>& points, int face) const;
  // Largest relative error of the faces' means, which are known to eight digits.
  double ErrorOfMeans() const;

 private:
  struct Cell {
    std::array<Vec3, 4> corners;
    int face = 0;
    double area = 0, radiosity = 0;
  };
  static std::vector<Cell> MakeCells(int n, bool narrowing);
  static Lanes IrradianceFrom(const std::vector<Cell>& cells, const std::array<Vec3, 4>& points,
                              int face);

  std::vector<Cell> cells_;
};

struct CubeRound {
  double links = 0, error = 0, estimate = 0;
};

// Refines round by round, the threshold halved each time, until there are so many links; errors are
// L1 of gathered irradiance over its mean at 600 points.
void SolveCube(const CubeReference& reference, double most_links,
               const std::function<void(const CubeRound&)>& after_round);

// What is asked of the error at so many links: the straight line, on logarithmic axes, through
// 2.5 % at 100 and halving with every factor of ten.
double AllowedInCube(double links);

}  // namespace isolux::testing
