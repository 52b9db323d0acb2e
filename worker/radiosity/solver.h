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
#include "worker/radiosity/channels.h"
#include "worker/radiosity/exchange.h"
#include "worker/radiosity/transport.h"

namespace isolux {

template <typename V>
struct SolverOptionsOf {
  double accuracy = 0.02;  // residual power is brought below accuracy/10 · (1 − λ) · Φ
  uint32_t max_products = 500;
  // For studies: shown the radiosities of own leaves after each iteration; ends the solve by
  // returning true, at all workers alike. May be empty.
  std::function<bool(std::span<const V> radiosity)> watch = {};
};
using SolverOptions = SolverOptionsOf<Lanes>;

template <typename V>
struct SolverResultOf {
  std::vector<V> irradiance;  // H at own leaves, W/m²
  uint32_t iterations = 0;    // sweeps, or passes of as many shots as there are leaves
  uint32_t products = 0;      // a sweep and a pass count as one each
  uint32_t again = 0;   // of them, for what sheets pass on and is reradiated: after the first pass
  double residual = 0;  // residual power over emitted power, the largest of the channels
  // λ, by which what is left shrinks: the error in power is about residual/(1 − λ). Conjugate
  // gradients: the largest Ritz value of the reflection operator; Jacobi and Chebyshev: its largest
  // Rayleigh quotient; Gauss–Seidel: the ratio of successive changes; Southwell: the share of shot
  // power that is reflected again.
  double largest_eigenvalue = 0;
  // Of the mean irradiance: what the equations that were solved leave out, at most.
  double neglected = 0;
  // λ above kLargestEigenvalue: as much light comes back as has left, there is no solution.
  bool indefinite = false;
};
using SolverResult = SolverResultOf<Lanes>;

// Beyond, a room counts as one that absorbs nothing.
inline constexpr double kLargestEigenvalue = 1 - 1e-6;

// Solves B = E + ρH of these leaves, from this irradiance, to this accuracy, some way.
template <typename V>
using SolveFunction = std::function<Result<SolverResultOf<V>>(
    const LeafSystemOf<V>& leaves, std::span<const V> start, double accuracy)>;

// From the given irradiance of own leaves, until the residual is small enough.
template <typename V>
Result<SolverResultOf<V>> Solve(SolverMethod method, TransportOf<V>& transport,
                                const LeafSystemOf<V>& leaves,
                                std::type_identity_t<std::span<const V>> start,
                                const SolverOptionsOf<V>& options, Exchange& exchange);

// Direct light alone: one product of what is emitted. What would be reflected of it is the
// residual.
template <typename V>
Result<SolverResultOf<V>> SolveDirect(TransportOf<V>& transport, const LeafSystemOf<V>& leaves,
                                      Exchange& exchange);

// Smallest eigenvalue of a symmetric tridiagonal matrix, by bisection on Sturm's sequence.
double SmallestEigenvalue(std::span<const double> diagonal, std::span<const double> off_diagonal);

}  // namespace isolux
