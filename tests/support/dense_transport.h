// Boxes of even grids with exact couplings, and a transport over a full matrix: systems whose every
// number is known, for the solvers alone (no tree, no links).
#pragma once

#include <cstdint>
#include <vector>

#include "worker/radiosity/transport.h"

namespace isolux::testing {

// Applies a full matrix of couplings, counts what it costs, knows of one worker only.
class DenseTransport final : public Transport {
 public:
  // coupling_m2: n×n, symmetric, C_ij = A_i F_ij; `leaves.closure` is applied on both sides.
  DenseTransport(std::vector<double> coupling_m2, const LeafSystem& leaves);

  Status Irradiance(std::span<const Lanes> radiosity, const Lanes& bound,
                    std::span<Lanes> irradiance) override;
  Status IrradianceFromOthers(std::span<const Lanes> radiosity, const Lanes& bound,
                              std::span<Lanes> irradiance) override;
  void Sweep(std::span<Lanes> radiosity, std::span<const Lanes> from_others,
             const Update& update) override;
  void Shoot(size_t leaf, const Lanes& radiosity, std::span<Lanes> irradiance) override;

  uint64_t multiply_adds() const { return multiply_adds_; }  // of couplings, a channel

 private:
  Lanes Row(size_t leaf, std::span<const Lanes> radiosity);

  std::vector<double> coupling_m2_;
  const LeafSystem& leaves_;
  uint64_t multiply_adds_ = 0;
};

// A box of even grids seen from inside.
struct GridBox {
  LeafSystem leaves;                // areas; closure 1; reflectance and exitance 0
  std::vector<uint8_t> face;        // x low, x high, y low, y high, z low, z high
  std::vector<double> coupling_m2;  // n×n, exact but for rounding: rows add up to the areas
};

// cells[axis]: cells along each edge in that direction. Coupling factors of parallel and
// perpendicular rectangles by their closed forms [Howell10].
GridBox MakeGridBox(const std::array<double, 3>& size_m, const std::array<int, 3>& cells);

// Symmetric closure of a full matrix: leaves.closure until every row is within `tolerance` of its
// area [KnightRuiz13]. Gives the worst row left, relative.
double CloseDense(const std::vector<double>& coupling_m2, double tolerance, LeafSystem* leaves);

}  // namespace isolux::testing
