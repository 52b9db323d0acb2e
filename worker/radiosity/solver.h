// The balance of light, B = E + ρH with H the irradiance that B causes, solved over the leaves by
// one of several methods. Conjugate gradients are what a solve uses; the others are for study.
//
// Channels lie side by side in lanes, each with its own scalars, left alone once it has converged.
// Conjugate gradients, Jacobi and Chebyshev need whole products alone, whose sums are exact: the
// same bits for any number of workers and threads. Gauss–Seidel and Southwell go leaf by leaf
// within a worker and exchange between passes: their bits depend on which leaves share a worker.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "common/scene/solve_options.h"
#include "worker/coupling/lanes.h"
#include "worker/radiosity/exchange.h"
#include "worker/radiosity/transport.h"

namespace isolux {

struct SolverOptions {
  double accuracy = 0.02;  // residual power is brought below accuracy/10 · (1 − λ) · Φ
  uint32_t max_products = 500;
  // For studies: shown the radiosities of own leaves after each iteration; ends the solve by
  // returning true, at all workers alike. May be empty.
  std::function<bool(std::span<const Lanes> radiosity)> watch;
};

struct SolverResult {
  std::vector<Lanes> irradiance;  // H at own leaves, W/m²
  uint32_t iterations = 0;        // sweeps, or passes of as many shots as there are leaves
  uint32_t products = 0;          // a sweep and a pass count as one each
  double residual = 0;            // residual power over emitted power, the largest of the channels
  // λ, by which what is left shrinks: the error in power is about residual/(1 − λ). Conjugate
  // gradients: the largest Ritz value of the reflection operator; Jacobi and Chebyshev: its largest
  // Rayleigh quotient; Gauss–Seidel: the ratio of successive changes; Southwell: the share of shot
  // power that is reflected again.
  double largest_eigenvalue = 0;
  // λ above kLargestEigenvalue: as much light comes back as has left, there is no solution.
  bool indefinite = false;
};

// Beyond, a room counts as one that absorbs nothing.
inline constexpr double kLargestEigenvalue = 1 - 1e-6;

// From the given irradiance of own leaves, until the residual is small enough.
Result<SolverResult> Solve(SolverMethod method, Transport& transport, const LeafSystem& leaves,
                           std::span<const Lanes> start, const SolverOptions& options,
                           Exchange& exchange);

// Direct light alone: one product of what is emitted. What would be reflected of it is the
// residual.
Result<SolverResult> SolveDirect(Transport& transport, const LeafSystem& leaves,
                                 Exchange& exchange);

// Smallest eigenvalue of a symmetric tridiagonal matrix, by bisection on Sturm's sequence.
double SmallestEigenvalue(std::span<const double> diagonal, std::span<const double> off_diagonal);

}  // namespace isolux
