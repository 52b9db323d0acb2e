// What the solvers of solver.h share. Not for others.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/radiosity/solver.h"

namespace isolux::solver {

// One method, for one run. Scalars come from collective sums: all workers take the same way.
template <typename V>
struct Problem {
  TransportOf<V>& transport;
  const LeafSystemOf<V>& leaves;
  std::span<const V> start;  // irradiance; 0 in channels in which nothing emits
  V emitted_w;               // Σ A E over all leaves of all workers
  const SolverOptionsOf<V>& options;
  Exchange& exchange;
};

template <typename V>
Result<SolverResultOf<V>> ConjugateGradients(const Problem<V>& problem);
template <typename V>
Result<SolverResultOf<V>> Jacobi(const Problem<V>& problem);
template <typename V>
Result<SolverResultOf<V>> GaussSeidel(const Problem<V>& problem);
template <typename V>
Result<SolverResultOf<V>> Chebyshev(const Problem<V>& problem);
template <typename V>
Result<SolverResultOf<V>> Southwell(const Problem<V>& problem);

template <typename V>
using ChannelSums = std::array<ExactSum, kChannelsOf<V>>;
// One number a channel.
template <typename V>
using Scalars = std::array<double, kChannelsOf<V>>;

template <typename V>
void Add(const V& v, std::array<ExactSum, kChannelsOf<V>>& sums) {
  for (int c = 0; c < kChannelsOf<V>; ++c) sums[c].Add(v[c]);
}

// The fourth of Lanes, which nothing is exchanged of.
inline void ClearSpare(Lanes& v) { v[3] = 0; }
inline void ClearSpare(Single&) {}

// Sums over all workers, channel by channel, exact and in no particular order; and, where
// `largest` (may be null) is given, the largest of all workers' numbers in each channel in its
// place.
template <typename V>
Result<std::vector<V>> ReduceSums(Exchange& exchange, const std::vector<ChannelSums<V>>& mine,
                                  V* largest);

// The largest size of the values in each channel, here; 0 in the spare one.
template <typename V>
V LargestOf(std::span<const V> values) {
  V largest{};
  for (const V& v : values) largest = Maximum(Absolute(v), largest);
  ClearSpare(largest);
  return largest;
}

// E + ρH.
template <typename V>
std::vector<V> RadiosityFrom(const LeafSystemOf<V>& leaves,
                             std::type_identity_t<std::span<const V>> irradiance);

// Decides channel by channel when an iteration may stop.
template <typename V>
class Stopping {
 public:
  explicit Stopping(const Problem<V>& problem)
      : accuracy_(problem.options.accuracy), emitted_w_(problem.emitted_w) {}

  // left_w: residual power; rate: λ as known so far, trusted once `settled`. True when every
  // channel is done.
  bool Done(const V& left_w, const Scalars<V>& rate, bool settled);
  bool done(int c) const { return done_[c]; }
  void End(int c) { done_[c] = true; }
  // −1 (all bits) in lanes that go on.
  MaskOf<V> Going() const;

 private:
  double accuracy_;
  V emitted_w_;
  std::array<bool, kChannelsOf<V>> done_{};
};

// One product from these radiosities gives the irradiance everywhere, also where nothing is
// reflected, and the true residual. Completes the result but for λ.
template <typename V>
Status Finish(const Problem<V>& problem, std::vector<V> radiosity, SolverResultOf<V>* result);
// The largest of the channels, and what follows from it.
template <typename V>
void SetResidual(const Problem<V>& problem, const V& left_w, SolverResultOf<V>* result);
template <typename V>
void SetEigenvalue(const Scalars<V>& rate, SolverResultOf<V>* result);

}  // namespace isolux::solver
