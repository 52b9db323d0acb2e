// With y = √(ρA)·H the balance is symmetric and positive definite for ρ < 1, and never divides by
// ρ:
//   (I − R K R) y = R K E,   R = diag √(ρ/A),   K: radiosity → power received
// Conjugate gradients [HestenesStiefel52] take outliers of the spectrum one a step, and a closed
// room has one large eigenvalue: their number of steps hardly depends on the reflectance.
#include <algorithm>
#include <cmath>

#include "worker/radiosity/solver_parts.h"

namespace isolux::solver {
namespace {

// Steps that the largest Ritz value is given to settle.
constexpr size_t kSettling = 3;

// A step is a product and two reductions.
template <typename V>
class Run {
 public:
  explicit Run(const Problem<V>& problem)
      : problem_(problem), leaves_(problem.leaves), stopping_(problem) {
    const size_t n = leaves_.size();
    to_radiosity_.resize(n);
    to_unknown_.resize(n);
    for (size_t i = 0; i < n; ++i) {
      to_radiosity_[i] = SquareRoot(leaves_.reflectance[i] / leaves_.area_m2[i]);
      to_unknown_[i] = SquareRoot(leaves_.reflectance[i] * leaves_.area_m2[i]);
    }
    product_.resize(n);
  }

  Status Start() {
    const size_t n = leaves_.size();
    unknown_.resize(n);
    residual_.resize(n);
    const std::vector<V> radiosity = RadiosityFrom(leaves_, problem_.start);
    for (size_t i = 0; i < n; ++i) unknown_[i] = to_unknown_[i] * problem_.start[i];
    V bound = LargestOf<V>(radiosity);
    ASSIGN_OR_RETURN(const auto sums, ReduceSums<V>(problem_.exchange, {}, &bound));
    RETURN_IF_ERROR(problem_.transport.Irradiance(radiosity, bound, product_));
    ++result_.products;
    for (size_t i = 0; i < n; ++i)
      residual_[i] = to_unknown_[i] * (product_[i] - problem_.start[i]);
    direction_ = residual_;
    RETURN_IF_ERROR(MeasureResidual());
    direction_bound_ = residual_bound_;
    return {};
  }

  bool Converged() {
    bool settled = true;
    Scalars<V> rate{};
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      rate[c] = Eigenvalue(c);
      settled &= stopping_.done(c) || alpha_[c].size() >= kSettling;
    }
    return stopping_.Done(residual_w_, rate, settled);
  }

  bool MayContinue() const { return result_.products + 1 < problem_.options.max_products; }

  bool Watched() const {
    if (!problem_.options.watch || result_.iterations == 0) return false;
    return problem_.options.watch(Radiosity());
  }

  Status Step() {
    const size_t n = leaves_.size();
    std::vector<V> radiosity(n);
    for (size_t i = 0; i < n; ++i) radiosity[i] = to_radiosity_[i] * direction_[i];
    RETURN_IF_ERROR(problem_.transport.Irradiance(radiosity, direction_bound_, product_));
    ++result_.products;
    ++result_.iterations;
    ChannelSums<V> curvature;
    for (size_t i = 0; i < n; ++i) {
      product_[i] = direction_[i] - to_unknown_[i] * product_[i];
      Add(direction_[i] * product_[i], curvature);
    }
    ASSIGN_OR_RETURN(const auto sums, ReduceSums<V>(problem_.exchange, {curvature}, nullptr));
    V alpha{};
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      if (stopping_.done(c)) continue;
      if (!(sums[0][c] > 0)) {
        result_.indefinite |= sums[0][c] < 0;
        stopping_.End(c);
        continue;
      }
      alpha[c] = residual_squared_[c] / sums[0][c];
    }
    for (size_t i = 0; i < n; ++i) {
      unknown_[i] += alpha * direction_[i];
      residual_[i] -= alpha * product_[i];
    }
    const V before = residual_squared_;
    RETURN_IF_ERROR(MeasureResidual());
    V beta{};
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      if (stopping_.done(c) || !(before[c] > 0)) continue;
      beta[c] = residual_squared_[c] / before[c];
      alpha_[c].push_back(alpha[c]);
      beta_[c].push_back(beta[c]);
    }
    for (size_t i = 0; i < n; ++i) direction_[i] = residual_[i] + beta * direction_[i];
    direction_bound_ = residual_bound_ + beta * direction_bound_;
    return {};
  }

  Result<SolverResultOf<V>> End() {
    if (result_.iterations == 0) {
      SetResidual(problem_, residual_w_, &result_);
      result_.irradiance = std::move(product_);  // of the start, which was good enough
    } else {
      RETURN_IF_ERROR(Finish(problem_, Radiosity(), &result_));
    }
    Scalars<V> rate{};
    for (int c = 0; c < kChannelsOf<V>; ++c) rate[c] = Eigenvalue(c);
    SetEigenvalue<V>(rate, &result_);
    return std::move(result_);
  }

 private:
  std::vector<V> Radiosity() const {
    std::vector<V> radiosity(leaves_.size());
    for (size_t i = 0; i < radiosity.size(); ++i)
      radiosity[i] = leaves_.exitance[i] + to_radiosity_[i] * unknown_[i];
    return radiosity;
  }

  // r·r, the power Σ √(ρA)|r| it stands for, and a bound on the radiosities it may become.
  Status MeasureResidual() {
    ChannelSums<V> squared, power;
    residual_bound_ = V{};
    for (size_t i = 0; i < residual_.size(); ++i) {
      Add(residual_[i] * residual_[i], squared);
      Add(to_unknown_[i] * Absolute(residual_[i]), power);
      residual_bound_ = Maximum(Absolute(to_radiosity_[i] * residual_[i]), residual_bound_);
    }
    ASSIGN_OR_RETURN(const auto sums,
                     ReduceSums<V>(problem_.exchange, {squared, power}, &residual_bound_));
    residual_squared_ = sums[0];
    residual_w_ = sums[1];
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

  const Problem<V>& problem_;
  const LeafSystemOf<V>& leaves_;
  Stopping<V> stopping_;
  std::vector<V> to_radiosity_, to_unknown_;  // √(ρ/A), √(ρA)
  std::vector<V> unknown_, residual_, direction_, product_;
  V residual_squared_{}, residual_w_{};
  V residual_bound_{}, direction_bound_{};
  std::array<std::vector<double>, kChannelsOf<V>> alpha_, beta_;
  SolverResultOf<V> result_;
};

}  // namespace

template <typename V>
Result<SolverResultOf<V>> ConjugateGradients(const Problem<V>& problem) {
  Run<V> run(problem);
  RETURN_IF_ERROR(run.Start());
  while (!run.Converged() && run.MayContinue() && !run.Watched()) RETURN_IF_ERROR(run.Step());
  return run.End();
}

template Result<SolverResultOf<Single>> ConjugateGradients(const Problem<Single>&);
template Result<SolverResultOf<Lanes>> ConjugateGradients(const Problem<Lanes>&);

}  // namespace isolux::solver
