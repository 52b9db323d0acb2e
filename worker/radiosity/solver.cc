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

Result<std::vector<Lanes>> ReduceSums(Exchange& exchange, const std::vector<ChannelSums>& mine,
                                      double largest, double* largest_of_all) {
  Reduction reduction;
  reduction.maxima = {largest};
  for (const ChannelSums& lanes : mine)
    reduction.sums.insert(reduction.sums.end(), lanes.begin(), lanes.end());
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(reduction)));
  if (total.sums.size() != mine.size() * kChannels || total.maxima.size() != 1) {
    return Error(StatusCode::kInternal, "a reduction came back with another length");
  }
  *largest_of_all = total.maxima[0];
  std::vector<Lanes> result(mine.size(), Lanes{});
  for (size_t i = 0; i < mine.size(); ++i) {
    for (int c = 0; c < kChannels; ++c) result[i][c] = total.sums[i * kChannels + c].Value();
  }
  return result;
}

std::vector<Lanes> RadiosityFrom(const LeafSystem& leaves, std::span<const Lanes> irradiance) {
  std::vector<Lanes> radiosity(leaves.size());
  for (size_t i = 0; i < leaves.size(); ++i)
    radiosity[i] = leaves.exitance[i] + leaves.reflectance[i] * irradiance[i];
  return radiosity;
}

bool Stopping::Done(const Lanes& left_w, const std::array<double, kChannels>& rate, bool settled) {
  bool all = true;
  for (int c = 0; c < kChannels; ++c) {
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

LaneMask Stopping::Going() const {
  LaneMask mask{};
  for (int c = 0; c < kChannels; ++c) mask[c] = done_[c] ? 0 : -1;
  return mask;
}

Status Finish(const Problem& problem, std::vector<Lanes> radiosity, SolverResult* result) {
  const LeafSystem& leaves = problem.leaves;
  double bound = 0;
  for (Lanes& b : radiosity) {
    b = Maximum(b, Splat(0.0));
    b[3] = 0;
    bound = std::max(bound, LargestOf(b));
  }
  ASSIGN_OR_RETURN(auto sums, ReduceSums(problem.exchange, {}, bound, &bound));
  result->irradiance.resize(leaves.size());
  RETURN_IF_ERROR(problem.transport.Irradiance(radiosity, bound, result->irradiance));
  ++result->products;
  ChannelSums left;
  for (size_t i = 0; i < leaves.size(); ++i) {
    const Lanes next = leaves.exitance[i] + leaves.reflectance[i] * result->irradiance[i];
    Add(leaves.area_m2[i] * Absolute(next - radiosity[i]), left);
  }
  ASSIGN_OR_RETURN(sums, ReduceSums(problem.exchange, {left}, 0, &bound));
  SetResidual(problem, sums[0], result);
  return {};
}

void SetResidual(const Problem& problem, const Lanes& left_w, SolverResult* result) {
  const Lanes& emitted_w = problem.emitted_w;
  result->residual = 0;
  for (int c = 0; c < kChannels; ++c) {
    if (emitted_w[c] > 0) result->residual = std::max(result->residual, left_w[c] / emitted_w[c]);
  }
}

void SetEigenvalue(const std::array<double, kChannels>& rate, SolverResult* result) {
  for (const double r : rate) result->largest_eigenvalue = std::max(result->largest_eigenvalue, r);
  result->indefinite |= result->largest_eigenvalue > kLargestEigenvalue;
}

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

Result<SolverResult> Solve(SolverMethod method, Transport& transport, const LeafSystem& leaves,
                           std::span<const Lanes> start, const SolverOptions& options,
                           Exchange& exchange) {
  solver::ChannelSums emitted;
  for (size_t i = 0; i < leaves.size(); ++i)
    solver::Add(leaves.exitance[i] * leaves.area_m2[i], emitted);
  double unused = 0;
  ASSIGN_OR_RETURN(const auto sums, solver::ReduceSums(exchange, {emitted}, 0, &unused));
  // Where nothing emits all is dark, whatever the start.
  std::vector<Lanes> lit_start(start.begin(), start.end());
  for (Lanes& h : lit_start) h = Select(sums[0] > 0.0, h, Lanes{});
  const solver::Problem problem{transport, leaves, lit_start, sums[0], options, exchange};
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

Result<SolverResult> SolveDirect(Transport& transport, const LeafSystem& leaves,
                                 Exchange& exchange) {
  solver::ChannelSums emitted;
  double largest = 0;
  for (size_t i = 0; i < leaves.size(); ++i) {
    solver::Add(leaves.exitance[i] * leaves.area_m2[i], emitted);
    largest = std::max(largest, solver::LargestOf(leaves.reflectance[i]));
  }
  SolverResult result;
  ASSIGN_OR_RETURN(const auto sums,
                   solver::ReduceSums(exchange, {emitted}, largest, &result.largest_eigenvalue));
  const SolverOptions options;
  const solver::Problem problem{transport, leaves, {}, sums[0], options, exchange};
  RETURN_IF_ERROR(solver::Finish(problem, leaves.exitance, &result));
  return result;
}

}  // namespace isolux
