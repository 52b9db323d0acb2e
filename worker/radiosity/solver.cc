#include "worker/radiosity/solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/radiosity/solver_parts.h"

namespace isolux {
namespace solver {
namespace {

// Residual power over emitted power below which nothing changes any more, however long one goes on;
// far below the accuracy of a double, and far above its smallest numbers.
constexpr double kNothingLeft = 1e-30;

}  // namespace

template <typename V>
Result<std::vector<V>> ReduceSums(Exchange& exchange, const std::vector<ChannelSums<V>>& mine,
                                  V* largest) {
  Reduction reduction;
  const size_t maxima = largest != nullptr ? kChannelsOf<V> : 0;
  for (size_t c = 0; c < maxima; ++c) reduction.maxima.push_back((*largest)[c]);
  for (const ChannelSums<V>& lanes : mine)
    reduction.sums.insert(reduction.sums.end(), lanes.begin(), lanes.end());
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(reduction)));
  if (total.sums.size() != mine.size() * kChannelsOf<V> || total.maxima.size() != maxima) {
    return Error(StatusCode::kInternal, "a reduction came back with another length");
  }
  for (size_t c = 0; c < maxima; ++c) (*largest)[c] = total.maxima[c];
  std::vector<V> result(mine.size(), V{});
  for (size_t i = 0; i < mine.size(); ++i) {
    for (int c = 0; c < kChannelsOf<V>; ++c)
      result[i][c] = total.sums[i * kChannelsOf<V> + c].Value();
  }
  return result;
}

template <typename V>
std::vector<V> RadiosityFrom(const LeafSystemOf<V>& leaves,
                             std::type_identity_t<std::span<const V>> irradiance) {
  std::vector<V> radiosity(leaves.size());
  for (size_t i = 0; i < leaves.size(); ++i)
    radiosity[i] = leaves.exitance[i] + leaves.reflectance[i] * irradiance[i];
  return radiosity;
}

template <typename V>
bool Stopping<V>::Done(const V& left_w, const Scalars<V>& rate, bool settled) {
  bool all = true;
  for (int c = 0; c < kChannelsOf<V>; ++c) {
    // Written so that a lane that is not a number ends.
    if (!(emitted_w_[c] > 0) || !(left_w[c] > kNothingLeft * emitted_w_[c])) done_[c] = true;
    const double relative = left_w[c] / emitted_w_[c], gap = 1 - rate[c];
    // Until λ has had a few steps to settle, only what is small by far is believed.
    if ((settled || relative < 1e-3 * accuracy_ * gap) && relative <= 0.1 * accuracy_ * gap) {
      done_[c] = true;
    }
    all &= done_[c];
  }
  return all;
}

template <typename V>
MaskOf<V> Stopping<V>::Going() const {
  MaskOf<V> mask{};
  for (int c = 0; c < kChannelsOf<V>; ++c) mask[c] = done_[c] ? 0 : -1;
  return mask;
}

template <typename V>
Status Finish(const Problem<V>& problem, std::vector<V> radiosity, SolverResultOf<V>* result) {
  const LeafSystemOf<V>& leaves = problem.leaves;
  for (V& b : radiosity) {
    b = Maximum(b, V{});
    ClearSpare(b);
  }
  V bound = LargestOf<V>(radiosity);
  ASSIGN_OR_RETURN(auto sums, ReduceSums<V>(problem.exchange, {}, &bound));
  result->irradiance.resize(leaves.size());
  RETURN_IF_ERROR(problem.transport.Irradiance(radiosity, bound, result->irradiance));
  ++result->products;
  ChannelSums<V> left;
  for (size_t i = 0; i < leaves.size(); ++i) {
    const V next = leaves.exitance[i] + leaves.reflectance[i] * result->irradiance[i];
    Add(leaves.area_m2[i] * Absolute(next - radiosity[i]), left);
  }
  ASSIGN_OR_RETURN(sums, ReduceSums<V>(problem.exchange, {left}, nullptr));
  SetResidual(problem, sums[0], result);
  return {};
}

template <typename V>
void SetResidual(const Problem<V>& problem, const V& left_w, SolverResultOf<V>* result) {
  const V& emitted_w = problem.emitted_w;
  result->residual = 0;
  for (int c = 0; c < kChannelsOf<V>; ++c) {
    if (emitted_w[c] > 0) result->residual = std::max(result->residual, left_w[c] / emitted_w[c]);
  }
}

template <typename V>
void SetEigenvalue(const Scalars<V>& rate, SolverResultOf<V>* result) {
  for (const double r : rate) result->largest_eigenvalue = std::max(result->largest_eigenvalue, r);
  result->indefinite |= result->largest_eigenvalue > kLargestEigenvalue;
}

// What the methods' files ask for, and the two kinds of channels.
#define ISOLUX_FOR(V)                                                                          \
  template Result<std::vector<V>> ReduceSums<V>(Exchange&, const std::vector<ChannelSums<V>>&, \
                                                V*);                                           \
  template std::vector<V> RadiosityFrom<V>(const LeafSystemOf<V>&, std::span<const V>);        \
  template class Stopping<V>;                                                                  \
  template Status Finish<V>(const Problem<V>&, std::vector<V>, SolverResultOf<V>*);            \
  template void SetResidual<V>(const Problem<V>&, const V&, SolverResultOf<V>*);               \
  template void SetEigenvalue<V>(const Scalars<V>&, SolverResultOf<V>*);
ISOLUX_FOR(Single)
ISOLUX_FOR(Lanes)
#undef ISOLUX_FOR

}  // namespace solver

double SmallestEigenvalue(std::span<const double> diagonal, std::span<const double> off_diagonal) {
  const size_t n = diagonal.size();
  if (n == 0) return 0;
  // Gershgorin's interval.
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (size_t i = 0; i < n; ++i) {
    const double reach = (i > 0 ? std::abs(off_diagonal[i - 1]) : 0.0) +
                         (i + 1 < n ? std::abs(off_diagonal[i]) : 0.0);
    low = std::min(low, diagonal[i] - reach);
    high = std::max(high, diagonal[i] + reach);
  }
  const auto any_below = [&](double x) {
    double d = diagonal[0] - x;
    for (size_t i = 1;; ++i) {
      if (d < 0) return true;
      if (i >= n) return false;
      if (d == 0) d = 1e-300;
      d = diagonal[i] - x - off_diagonal[i - 1] * off_diagonal[i - 1] / d;
    }
  };
  for (int step = 0; step < 100 && high - low > 1e-12 * (std::abs(low) + std::abs(high)); ++step) {
    const double middle = 0.5 * (low + high);
    (any_below(middle) ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

template <typename V>
Result<SolverResultOf<V>> Solve(SolverMethod method, TransportOf<V>& transport,
                                const LeafSystemOf<V>& leaves,
                                std::type_identity_t<std::span<const V>> start,
                                const SolverOptionsOf<V>& options, Exchange& exchange) {
  solver::ChannelSums<V> emitted;
  for (size_t i = 0; i < leaves.size(); ++i)
    solver::Add(leaves.exitance[i] * leaves.area_m2[i], emitted);
  ASSIGN_OR_RETURN(const auto sums, solver::ReduceSums<V>(exchange, {emitted}, nullptr));
  // Where nothing emits all is dark, whatever the start.
  std::vector<V> lit_start(start.begin(), start.end());
  for (V& h : lit_start) h = Select(sums[0] > 0.0, h, V{});
  const solver::Problem<V> problem{transport, leaves, lit_start, sums[0], options, exchange};
  switch (method) {
    case SolverMethod::kConjugateGradients:
      return solver::ConjugateGradients(problem);
    case SolverMethod::kJacobi:
      return solver::Jacobi(problem);
    case SolverMethod::kGaussSeidel:
      return solver::GaussSeidel(problem);
    case SolverMethod::kChebyshev:
      return solver::Chebyshev(problem);
    case SolverMethod::kSouthwell:
      return solver::Southwell(problem);
  }
  return Error(StatusCode::kInternal, "no such solver: {}", static_cast<int>(method));
}

template <typename V>
Result<SolverResultOf<V>> SolveDirect(TransportOf<V>& transport, const LeafSystemOf<V>& leaves,
                                      Exchange& exchange) {
  solver::ChannelSums<V> emitted;
  for (size_t i = 0; i < leaves.size(); ++i)
    solver::Add(leaves.exitance[i] * leaves.area_m2[i], emitted);
  V reflectance = solver::LargestOf<V>(leaves.reflectance);
  ASSIGN_OR_RETURN(const auto sums, solver::ReduceSums<V>(exchange, {emitted}, &reflectance));
  SolverResultOf<V> result;
  for (int c = 0; c < kChannelsOf<V>; ++c)
    result.largest_eigenvalue = std::max(result.largest_eigenvalue, double{reflectance[c]});
  const SolverOptionsOf<V> options;
  const solver::Problem<V> problem{transport, leaves, {}, sums[0], options, exchange};
  RETURN_IF_ERROR(solver::Finish(problem, leaves.exitance, &result));
  return result;
}

#define ISOLUX_FOR(V)                                                                             \
  template Result<SolverResultOf<V>> Solve(SolverMethod, TransportOf<V>&, const LeafSystemOf<V>&, \
                                           std::span<const V>, const SolverOptionsOf<V>&,         \
                                           Exchange&);                                            \
  template Result<SolverResultOf<V>> SolveDirect(TransportOf<V>&, const LeafSystemOf<V>&,         \
                                                 Exchange&);
ISOLUX_FOR(Single)
ISOLUX_FOR(Lanes)
#undef ISOLUX_FOR

}  // namespace isolux
