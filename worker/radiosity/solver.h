// The balance of light, B = E + ρH with H the irradiance that B causes, solved over the leaves.
//
// With y = √(ρA)·H it is symmetric and positive definite for ρ < 1, and never divides by ρ:
//   (I − R K R) y = R K E,   R = diag √(ρ/A),   K: radiosity → power received, through the links
// Channels lie side by side in lanes, each with its own scalars, left alone once it has converged.
#pragma once

#include <span>
#include <vector>

#include "worker/coupling/lanes.h"
#include "worker/radiosity/exchange.h"
#include "worker/radiosity/matvec.h"

namespace isolux {

// The leaves of one worker as the solver sees them, side by side.
struct LeafSystem {
  std::vector<double> area_m2;
  std::vector<Lanes> reflectance;
  std::vector<Lanes> exitance;  // W/m²
  std::vector<double> closure;  // factor d of the symmetric closure D C D

  size_t size() const { return area_m2.size(); }
};

// Irradiance caused by a radiosity, with the closure's factors applied on both sides.
class Transport {
 public:
  Transport(Product& product, const LeafSystem& leaves) : product_(product), leaves_(leaves) {}

  // bound: not less than any |radiosity| anywhere.
  Status Irradiance(std::span<const Lanes> radiosity, double bound, std::span<Lanes> irradiance);

 private:
  Product& product_;
  const LeafSystem& leaves_;
  std::vector<Lanes> scaled_;
};

struct SolverOptions {
  double accuracy = 0.02;  // residual power is brought below accuracy/10 · (1 − λ) · Φ
  uint32_t max_products = 500;
};

struct SolverResult {
  std::vector<Lanes> irradiance;  // H at own leaves, W/m²
  uint32_t products = 0;
  double residual = 0;            // residual power over emitted power, the largest of the channels
  double largest_eigenvalue = 0;  // λ, the largest Ritz value of the reflection operator
  bool indefinite = false;        // λ ≥ 1: more light comes back than left, there is no solution
};

// Conjugate gradients from the given irradiance (Hestenes and Stiefel 1952).
Result<SolverResult> SolveConjugateGradients(Transport& transport, const LeafSystem& leaves,
                                             std::span<const Lanes> start,
                                             const SolverOptions& options, Exchange& exchange);

// Smallest eigenvalue of a symmetric tridiagonal matrix, by bisection on Sturm's sequence.
double SmallestEigenvalue(std::span<const double> diagonal, std::span<const double> off_diagonal);

}  // namespace isolux
