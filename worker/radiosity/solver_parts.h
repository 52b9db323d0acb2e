// What the solvers of solver.h share. Not for others.
#pragma once

#include <array>

#include "worker/radiosity/solver.h"

namespace isolux::solver {

inline constexpr int kChannels = 3;

// One method, for one run. Scalars come from collective sums: all workers take the same way.
struct Problem {
  Transport& transport;
  const LeafSystem& leaves;
  std::span<const Lanes> start;  // irradiance; 0 in channels in which nothing emits
  Lanes emitted_w;               // Σ A E over all leaves of all workers
  const SolverOptions& options;
  Exchange& exchange;
};

Result<SolverResult> ConjugateGradients(const Problem& problem);
Result<SolverResult> Jacobi(const Problem& problem);
Result<SolverResult> GaussSeidel(const Problem& problem);
Result<SolverResult> Chebyshev(const Problem& problem);
Result<SolverResult> Southwell(const Problem& problem);

using ChannelSums = std::array<ExactSum, kChannels>;

inline double LargestOf(const Lanes& v) {
  return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
}
inline void Add(const Lanes& v, ChannelSums& sums) {
  for (int c = 0; c < kChannels; ++c) sums[c].Add(v[c]);
}

// Sums over all workers, channel by channel, exact and in no particular order; and the largest of
// all workers' numbers.
Result<std::vector<Lanes>> ReduceSums(Exchange& exchange, const std::vector<ChannelSums>& mine,
                                      double largest, double* largest_of_all);

// E + ρH.
std::vector<Lanes> RadiosityFrom(const LeafSystem& leaves, std::span<const Lanes> irradiance);

// Decides channel by channel when an iteration may stop.
class Stopping {
 public:
  explicit Stopping(const Problem& problem)
      : accuracy_(problem.options.accuracy), emitted_w_(problem.emitted_w) {}

  // left_w: residual power; rate: λ as known so far, trusted once `settled`. True when every
  // channel is done.
  bool Done(const Lanes& left_w, const std::array<double, kChannels>& rate, bool settled);
  bool done(int c) const { return done_[c]; }
  void End(int c) { done_[c] = true; }
  // −1 (all bits) in lanes that go on.
  LaneMask Going() const;

 private:
  double accuracy_;
  Lanes emitted_w_;
  std::array<bool, kChannels> done_{};
};

// One product from these radiosities gives the irradiance everywhere, also where nothing is
// reflected, and the true residual. Completes the result but for λ.
Status Finish(const Problem& problem, std::vector<Lanes> radiosity, SolverResult* result);
// The largest of the channels, and what follows from it.
void SetResidual(const Problem& problem, const Lanes& left_w, SolverResult* result);
void SetEigenvalue(const std::array<double, kChannels>& rate, SolverResult* result);

}  // namespace isolux::solver
