#include "worker/radiosity/solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isolux {
namespace {

constexpr int kChannels = 3;

// The largest number of a lane beyond which closure may enlarge a radiosity.
constexpr double kClosureHeadroom = 4.0;

// Sums over all workers of up to four lanes each, exact and in no particular order.
Result<std::vector<Lanes>> ReduceSums(Exchange& exchange,
                                      const std::vector<std::array<ExactSum, kChannels>>& mine,
                                      double largest, double* largest_of_all) {
  Reduction reduction;
  reduction.maxima = {largest};
  for (const auto& lanes : mine)
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

double LargestOf(const Lanes& v) {
  return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
}

// The state of one run; a step is a product and two reductions.
class ConjugateGradients {
 public:
  ConjugateGradients(Transport& transport, const LeafSystem& leaves, const SolverOptions& options,
                     Exchange& exchange)
      : transport_(transport), leaves_(leaves), options_(options), exchange_(exchange) {
    const size_t n = leaves.size();
    to_radiosity_.resize(n);
    to_unknown_.resize(n);
    for (size_t i = 0; i < n; ++i) {
      to_radiosity_[i] = SquareRoot(leaves.reflectance[i] / leaves.area_m2[i]);
      to_unknown_[i] = SquareRoot(leaves.reflectance[i] * leaves.area_m2[i]);
    }
    product_.resize(n);
  }

  Status Start(std::span<const Lanes> irradiance) {
    const size_t n = leaves_.size();
    unknown_.resize(n);
    residual_.resize(n);
    std::vector<Lanes> radiosity(n);
    double bound = 0;
    std::array<ExactSum, kChannels> emitted;
    for (size_t i = 0; i < n; ++i) {
      unknown_[i] = to_unknown_[i] * irradiance[i];
      radiosity[i] = leaves_.exitance[i] + leaves_.reflectance[i] * irradiance[i];
      bound = std::max(bound, LargestOf(radiosity[i]));
      for (int c = 0; c < kChannels; ++c)
        emitted[c].Add(leaves_.exitance[i][c] * leaves_.area_m2[i]);
    }
    ASSIGN_OR_RETURN(const auto sums, ReduceSums(exchange_, {emitted}, bound, &bound));
    emitted_ = sums[0];
    RETURN_IF_ERROR(transport_.Irradiance(radiosity, bound, product_));
    ++result_.products;
    for (size_t i = 0; i < n; ++i) residual_[i] = to_unknown_[i] * (product_[i] - irradiance[i]);
    direction_ = residual_;
    RETURN_IF_ERROR(MeasureResidual());
    direction_bound_ = residual_bound_;
    return {};
  }

  // Largest residual power over emitted power, and whether every lane is done.
  bool Converged() {
    result_.residual = 0;
    bool all = true;
    for (int c = 0; c < kChannels; ++c) {
      if (!(emitted_[c] > 0)) {
        done_[c] = true;
        continue;
      }
      const double relative = residual_power_[c] / emitted_[c];
      result_.residual = std::max(result_.residual, relative);
      const double gap = 1 - Eigenvalue(c);
      // The Ritz value is trusted once it has had a few steps to settle.
      const bool settled = alpha_[c].size() >= 3 || relative < 1e-3 * options_.accuracy * gap;
      if (!(residual_squared_[c] > 0) || (settled && relative <= 0.1 * options_.accuracy * gap)) {
        done_[c] = true;
      }
      all &= done_[c];
    }
    return all;
  }

  Status Step() {
    const size_t n = leaves_.size();
    std::vector<Lanes> radiosity(n);
    for (size_t i = 0; i < n; ++i) radiosity[i] = to_radiosity_[i] * direction_[i];
    RETURN_IF_ERROR(transport_.Irradiance(radiosity, direction_bound_, product_));
    ++result_.products;
    std::array<ExactSum, kChannels> curvature;
    for (size_t i = 0; i < n; ++i) {
      product_[i] = direction_[i] - to_unknown_[i] * product_[i];
      const Lanes term = direction_[i] * product_[i];
      for (int c = 0; c < kChannels; ++c) curvature[c].Add(term[c]);
    }
    double unused = 0;
    ASSIGN_OR_RETURN(const auto sums, ReduceSums(exchange_, {curvature}, 0, &unused));
    Lanes alpha{};
    for (int c = 0; c < kChannels; ++c) {
      if (done_[c]) continue;
      if (!(sums[0][c] > 0)) {
        result_.indefinite |= sums[0][c] < 0;
        done_[c] = true;
        continue;
      }
      alpha[c] = residual_squared_[c] / sums[0][c];
    }
    for (size_t i = 0; i < n; ++i) {
      unknown_[i] += alpha * direction_[i];
      residual_[i] -= alpha * product_[i];
    }
    const Lanes before = residual_squared_;
    RETURN_IF_ERROR(MeasureResidual());
    Lanes beta{};
    for (int c = 0; c < kChannels; ++c) {
      if (done_[c] || !(before[c] > 0)) continue;
      beta[c] = residual_squared_[c] / before[c];
      alpha_[c].push_back(alpha[c]);
      beta_[c].push_back(beta[c]);
    }
    for (size_t i = 0; i < n; ++i) direction_[i] = residual_[i] + beta * direction_[i];
    direction_bound_ = residual_bound_ + LargestOf(beta) * direction_bound_;
    return {};
  }

  // One product from B = E + ρH gives the irradiance everywhere, also where nothing is reflected.
  Result<SolverResult> Finish() {
    const size_t n = leaves_.size();
    std::vector<Lanes> radiosity(n);
    double bound = 0;
    for (size_t i = 0; i < n; ++i) {
      radiosity[i] = Maximum(leaves_.exitance[i] + to_radiosity_[i] * unknown_[i], Splat(0.0));
      radiosity[i][3] = 0;
      bound = std::max(bound, LargestOf(radiosity[i]));
    }
    ASSIGN_OR_RETURN(const auto sums, ReduceSums(exchange_, {}, bound, &bound));
    RETURN_IF_ERROR(transport_.Irradiance(radiosity, bound, product_));
    ++result_.products;
    result_.irradiance = product_;
    for (int c = 0; c < kChannels; ++c) {
      result_.largest_eigenvalue = std::max(result_.largest_eigenvalue, Eigenvalue(c));
    }
    result_.indefinite |= result_.largest_eigenvalue >= 1;
    return std::move(result_);
  }

  bool MayContinue() const { return result_.products + 1 < options_.max_products; }

 private:
  // r·r, the power Σ √(ρA)|r| it stands for, and a bound on the radiosities it may become.
  Status MeasureResidual() {
    std::array<ExactSum, kChannels> squared, power;
    double bound = 0;
    for (size_t i = 0; i < residual_.size(); ++i) {
      const Lanes square = residual_[i] * residual_[i];
      const Lanes watts = to_unknown_[i] * Absolute(residual_[i]);
      for (int c = 0; c < kChannels; ++c) {
        squared[c].Add(square[c]);
        power[c].Add(watts[c]);
      }
      bound = std::max(bound, LargestOf(to_radiosity_[i] * residual_[i]));
    }
    ASSIGN_OR_RETURN(const auto sums,
                     ReduceSums(exchange_, {squared, power}, bound, &residual_bound_));
    residual_squared_ = sums[0];
    residual_power_ = sums[1];
    return {};
  }

  // Largest Ritz value of R K R in one lane, from the coefficients so far.
  double Eigenvalue(int c) const {
    const auto& alpha = alpha_[c];
    const auto& beta = beta_[c];
    if (alpha.empty()) return 0;
    std::vector<double> diagonal(alpha.size()), off(alpha.size() - 1);
    for (size_t k = 0; k < alpha.size(); ++k) {
      diagonal[k] = 1 / alpha[k] + (k > 0 ? beta[k - 1] / alpha[k - 1] : 0.0);
      if (k > 0) off[k - 1] = std::sqrt(beta[k - 1]) / alpha[k - 1];
    }
    return std::clamp(1 - SmallestEigenvalue(diagonal, off), 0.0, 1.0);
  }

  Transport& transport_;
  const LeafSystem& leaves_;
  const SolverOptions& options_;
  Exchange& exchange_;
  std::vector<Lanes> to_radiosity_, to_unknown_;  // √(ρ/A), √(ρA)
  std::vector<Lanes> unknown_, residual_, direction_, product_;
  Lanes emitted_{}, residual_squared_{}, residual_power_{};
  double residual_bound_ = 0, direction_bound_ = 0;
  std::array<bool, kChannels> done_{};
  std::array<std::vector<double>, kChannels> alpha_, beta_;
  SolverResult result_;
};

}  // namespace

Status Transport::Irradiance(std::span<const Lanes> radiosity, double bound,
                             std::span<Lanes> irradiance) {
  scaled_.resize(radiosity.size());
  for (size_t i = 0; i < radiosity.size(); ++i) scaled_[i] = radiosity[i] * leaves_.closure[i];
  RETURN_IF_ERROR(product_.Irradiance(scaled_, kClosureHeadroom * bound, kChannels, irradiance));
  for (size_t i = 0; i < radiosity.size(); ++i) irradiance[i] *= leaves_.closure[i];
  return {};
}

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

Result<SolverResult> SolveConjugateGradients(Transport& transport, const LeafSystem& leaves,
                                             std::span<const Lanes> start,
                                             const SolverOptions& options, Exchange& exchange) {
  ConjugateGradients solver(transport, leaves, options, exchange);
  RETURN_IF_ERROR(solver.Start(start));
  while (!solver.Converged() && solver.MayContinue()) RETURN_IF_ERROR(solver.Step());
  return solver.Finish();
}

}  // namespace isolux
