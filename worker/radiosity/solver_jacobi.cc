// Jacobi: H ← F(E + ρH), all at once; one bounce of light a product. And Chebyshev's acceleration
// of it [GolubVarga61]: H_{k+1} = ω_{k+1} (F(E + ρH_k) − H_{k−1}) + H_{k−1}, with ω from the
// largest eigenvalue λ of ρF, whose spectrum lies in [−λ, λ] since F is not negative.
#include <algorithm>
#include <cmath>

#include "worker/radiosity/solver_parts.h"

namespace isolux::solver {
namespace {

// Plain steps before Rayleigh's quotient is believed: it then has lost most of what is not of the
// largest eigenvalue.
constexpr uint32_t kSettling = 5;
// Chebyshev starts anew where the gap 1 − λ turns out smaller than this share of what it assumes.
constexpr double kGapTolerance = 0.9;
// A residual this many times the least so far does not come back.
constexpr double kGrowth = 1e6;

// What one product shows of the way: δ = F(E + ρH) − H, its power Σ ρA|δ|, and how the operator
// acts on the δ of the step before.
template <typename V>
struct Shown {
  V left_w{}, squared{}, image{};  // Σ ρA|δ|, Σ ρA δ'², Σ ρA δ' Mδ'; δ' of the step before
};

template <typename V>
class Run {
 public:
  Run(const Problem<V>& problem, bool accelerated)
      : problem_(problem),
        leaves_(problem.leaves),
        accelerated_(accelerated),
        stopping_(problem),
        irradiance_(problem.start.begin(), problem.start.end()),
        before_(irradiance_),
        change_(irradiance_.size(), V{}),
        change_before_(irradiance_.size(), V{}) {}

  Result<SolverResultOf<V>> Solve() {
    while (true) {
      RETURN_IF_ERROR(Product());
      ASSIGN_OR_RETURN(const Shown<V> shown, Measure());
      Judge(shown);
      SetResidual(problem_, shown.left_w, &result_);
      const bool done = stopping_.Done(shown.left_w, rate_, result_.iterations >= kSettling);
      if (done || diverges_ || result_.products >= problem_.options.max_products) break;
      Step();
      const auto& watch = problem_.options.watch;
      if (watch && watch(RadiosityFrom(leaves_, irradiance_))) break;
    }
    // The last product is taken plainly.
    for (V& h : product_) h = Maximum(h, V{});
    result_.irradiance = std::move(product_);
    result_.indefinite = diverges_;
    SetEigenvalue<V>(rate_, &result_);
    return std::move(result_);
  }

 private:
  Status Product() {
    std::vector<V> radiosity = RadiosityFrom(leaves_, irradiance_);
    for (V& b : radiosity) ClearSpare(b);
    V bound = LargestOf<V>(radiosity);
    ASSIGN_OR_RETURN(const auto sums, ReduceSums<V>(problem_.exchange, {}, &bound));
    product_.resize(radiosity.size());
    ++result_.products;
    return problem_.transport.Irradiance(radiosity, bound, product_);
  }

  Result<Shown<V>> Measure() {
    ChannelSums<V> left, squared, image;
    const V omega = omega_;
    for (size_t i = 0; i < product_.size(); ++i) {
      const V weight = leaves_.reflectance[i] * leaves_.area_m2[i];
      const V change = product_[i] - irradiance_[i];
      // δ_{k+1} = ω_{k+1} (Mδ_k − δ_{k−1}) + δ_{k−1}, with ω = 1 for a plain step.
      const V moved = (change - change_before_[i]) / omega + change_before_[i];
      Add(weight * Absolute(change), left);
      Add(weight * change_[i] * change_[i], squared);
      Add(weight * change_[i] * moved, image);
      change_before_[i] = change_[i];
      change_[i] = change;
    }
    ASSIGN_OR_RETURN(const auto sums,
                     ReduceSums<V>(problem_.exchange, {left, squared, image}, nullptr));
    return Shown<V>{sums[0], sums[1], sums[2]};
  }

  // Rayleigh's quotients never exceed the largest eigenvalue, so the largest of them is the best.
  void Judge(const Shown<V>& shown) {
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      if (stopping_.done(c)) continue;
      if (result_.iterations > 0 && shown.squared[c] > 0) {
        rate_[c] = std::max(rate_[c], shown.image[c] / shown.squared[c]);
      }
      least_w_[c] = std::min(least_w_[c], shown.left_w[c]);
      diverges_ |= rate_[c] > kLargestEigenvalue || !(shown.left_w[c] <= kGrowth * least_w_[c]);
    }
  }

  void Step() {
    ++result_.iterations;
    for (int c = 0; c < kChannelsOf<V>; ++c) omega_[c] = NextOmega(c);
    const MaskOf<V> going = stopping_.Going();
    for (size_t i = 0; i < irradiance_.size(); ++i) {
      const V next = omega_ * (product_[i] - before_[i]) + before_[i];
      before_[i] = irradiance_[i];
      irradiance_[i] = Select(going, next, irradiance_[i]);
    }
  }

  double NextOmega(int c) {
    if (!accelerated_ || result_.iterations <= kSettling) return 1;
    if (1 - rate_[c] < kGapTolerance * (1 - assumed_[c])) {
      assumed_[c] = std::min(rate_[c], kLargestEigenvalue);
      steps_[c] = 0;
      return 1;
    }
    const double square = assumed_[c] * assumed_[c];
    return ++steps_[c] == 1 ? 1 / (1 - 0.5 * square) : 1 / (1 - 0.25 * square * omega_[c]);
  }

  const Problem<V>& problem_;
  const LeafSystemOf<V>& leaves_;
  const bool accelerated_;
  Stopping<V> stopping_;
  std::vector<V> irradiance_, before_, product_;  // H_k, H_{k−1}, F(E + ρH_k)
  std::vector<V> change_, change_before_;         // δ_k, δ_{k−1}
  V omega_ = V{} + 1.0;
  V least_w_ = V{} + HUGE_VAL;
  Scalars<V> rate_{}, assumed_{};                 // λ as seen, and as ω assumes it
  std::array<uint32_t, kChannelsOf<V>> steps_{};  // since Chebyshev started
  bool diverges_ = false;
  SolverResultOf<V> result_;
};

}  // namespace

template <typename V>
Result<SolverResultOf<V>> Jacobi(const Problem<V>& problem) {
  return Run<V>(problem, false).Solve();
}
template <typename V>
Result<SolverResultOf<V>> Chebyshev(const Problem<V>& problem) {
  return Run<V>(problem, true).Solve();
}

template Result<SolverResultOf<Single>> Jacobi(const Problem<Single>&);
template Result<SolverResultOf<Lanes>> Jacobi(const Problem<Lanes>&);
template Result<SolverResultOf<Single>> Chebyshev(const Problem<Single>&);
template Result<SolverResultOf<Lanes>> Chebyshev(const Problem<Lanes>&);

}  // namespace isolux::solver
