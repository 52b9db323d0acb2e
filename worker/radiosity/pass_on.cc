#include "worker/radiosity/pass_on.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "worker/radiosity/solver_parts.h"

namespace isolux {
namespace {

using solver::Add;
using solver::ChannelSums;
using solver::ReduceSums;
using solver::Scalars;

constexpr int kMostPasses = 100;
// Passes that are looked back at.
constexpr size_t kMemory = 5;
// Of the accuracy times 1 − q times the emitted power: how much of what is passed on may still
// change, with q the factor by which a pass shrinks it at worst; and of that in turn what a solve
// may leave.
constexpr double kMayChange = 0.05, kMayLeave = 0.25;
constexpr double kLeastGap = 0.02;
// Of the largest diagonal element: smaller pivots are directions that the memory already has.
constexpr double kLeastPivot = 1e-10;

// Of what arrives in each channel, what is taken to be given out in others.
template <typename V>
V TakenBy(const LeafSystemOf<V>& leaves, size_t i) {
  if constexpr (kChannelsOf<V> == 3) {
    if (!leaves.reradiation.empty()) {
      const Rgb taken = leaves.reradiation[i].Taken();
      return V{taken.x, taken.y, taken.z, 0};
    }
  }
  return V{};
}

template <typename V>
V Reradiated(const LeafSystemOf<V>& leaves, size_t i, const V& irradiance) {
  if constexpr (kChannelsOf<V> == 3) {
    if (!leaves.reradiation.empty()) {
      const Rgb out = leaves.reradiation[i].Of({irradiance[0], irradiance[1], irradiance[2]});
      return V{out.x, out.y, out.z, 0};
    }
  }
  return V{};
}

// What comes through, and what is reradiated, of what arrives.
template <typename V>
V PassedShare(const LeafSystemOf<V>& leaves, size_t i) {
  const V taken = TakenBy(leaves, i);
  return leaves.transmittance.empty() ? taken : taken + leaves.transmittance[i];
}

// The leaves of sheets and of what fluoresces, and what is passed on to them.
template <typename V>
class Passing {
 public:
  Passing(Product& product, const LeafSystemOf<V>& leaves, Exchange& exchange)
      : product_(product), leaves_(leaves), exchange_(exchange), behind_(leaves.size(), V{}) {
    const auto& behind = product.active().behind;
    for (uint32_t i = 0; i < leaves.size(); ++i) {
      const bool sheet = !behind.empty() && behind[i] != kNoNode;
      const bool fluoresces = !leaves.reradiation.empty() && leaves.reradiation[i].exists();
      if (sheet || fluoresces) passing_.push_back(i);
    }
  }

  // Emitted power, and the factor by which a pass shrinks what is passed on at worst. Where light
  // changes its channel, the power of all channels counts for each.
  Status Measure() {
    ChannelSums<V> emitted;
    V worst{};
    for (size_t i = 0; i < leaves_.size(); ++i) {
      V e = leaves_.exitance[i];
      if (!leaves_.given.empty()) {
        e += (leaves_.reflectance[i] + PassedShare(leaves_, i)) * leaves_.given[i];
      }
      Add(leaves_.area_m2[i] * e, emitted);
      worst = Maximum(PassedShare(leaves_, i) / (1.0 - leaves_.reflectance[i]), worst);
    }
    solver::ClearSpare(worst);
    ASSIGN_OR_RETURN(const auto sums, ReduceSums<V>(exchange_, {emitted}, &worst));
    emitted_w_ = sums[0];
    double all_w = 0, largest = 0;
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      gap_[c] = std::max(kLeastGap, 1 - worst[c]);
      all_w += emitted_w_[c];
      largest = std::max(largest, double{worst[c]});
    }
    if (product_.tree().fluorescence() == nullptr) return {};
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      gap_[c] = std::max(kLeastGap, 1 - largest);
      emitted_w_[c] = all_w;
    }
    return {};
  }

  // What this irradiance passes on, by leaf that passes some.
  Result<std::vector<V>> PassedBy(std::span<const V> irradiance) {
    const bool sheets = product_.tree().sheets() != nullptr;
    if (sheets) RETURN_IF_ERROR(product_.Behind(irradiance, std::span<V>(behind_)));
    std::vector<V> passed;
    passed.reserve(passing_.size());
    for (const uint32_t i : passing_) {
      passed.push_back(Reradiated(leaves_, i, irradiance[i]));
      if (sheets) passed.back() += leaves_.transmittance[i] * behind_[i];
    }
    return passed;
  }

  // The leaves with this on top of what they emit.
  void Put(std::span<const V> passed, LeafSystemOf<V>& leaves) const {
    for (size_t k = 0; k < passing_.size(); ++k) {
      leaves.exitance[passing_[k]] = leaves_.exitance[passing_[k]] + passed[k];
    }
  }

  // Over the channels: how much more is emitted with what is passed on, and the least 1 − q.
  std::pair<double, double> GrowthAndGap(const V& with_passed_w) const {
    double growth = 1, least_gap = 1;
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      if (!(emitted_w_[c] > 0)) continue;
      growth = std::max(growth, with_passed_w[c] / emitted_w_[c]);
      least_gap = std::min(least_gap, gap_[c]);
    }
    return {growth, least_gap};
  }

  double area_m2(size_t k) const { return leaves_.area_m2[passing_[k]]; }
  size_t size() const { return passing_.size(); }
  const V& emitted_w() const { return emitted_w_; }
  double gap(int c) const { return gap_[c]; }
  Exchange& exchange() const { return exchange_; }

 private:
  Product& product_;
  const LeafSystemOf<V>& leaves_;
  Exchange& exchange_;
  std::vector<V> behind_;
  std::vector<uint32_t> passing_;  // numbers of leaves
  V emitted_w_{};
  Scalars<V> gap_{};
};

// Solves the positive definite system of the lower triangle `a` (by rows) in place; directions
// that are none get 0.
void SolveSmall(size_t n, std::vector<double>& a, std::vector<double>& x) {
  double largest = 0;
  for (size_t i = 0; i < n; ++i) largest = std::max(largest, a[i * n + i]);
  std::vector<bool> none(n, false);
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k <= i; ++k) {
      double sum = a[i * n + k];
      for (size_t m = 0; m < k; ++m) sum -= a[i * n + m] * a[k * n + m];
      if (k < i) {
        a[i * n + k] = none[k] ? 0 : sum / a[k * n + k];
        continue;
      }
      none[i] = !(sum > kLeastPivot * largest);
      a[i * n + i] = none[i] ? 1 : std::sqrt(sum);
    }
    double sum = x[i];
    for (size_t m = 0; m < i; ++m) sum -= a[i * n + m] * x[m];
    x[i] = none[i] ? 0 : sum / a[i * n + i];
  }
  for (size_t i = n; i-- > 0;) {
    double sum = x[i];
    for (size_t m = i + 1; m < n; ++m) sum -= a[m * n + i] * x[m];
    x[i] = none[i] ? 0 : sum / a[i * n + i];
  }
}

// What to try next: the mixture of the last passes that changes least, by channel.
template <typename V>
class Mixer {
 public:
  explicit Mixer(const Passing<V>& passing) : passing_(passing) {}

  // x: what was passed on; change: what more came of it. Replaces x.
  Status Next(std::span<const V> change, std::vector<V>& x) {
    const size_t count = passing_.size();
    if (passes_ > 0) {
      std::vector<V> dx(count), df(count);
      for (size_t k = 0; k < count; ++k) {
        dx[k] = x[k] - last_x_[k];
        df[k] = change[k] - last_change_[k];
      }
      steps_.push_back({std::move(dx), std::move(df)});
      if (steps_.size() > kMemory) steps_.pop_front();
    }
    ++passes_;
    last_x_ = x;
    last_change_.assign(change.begin(), change.end());
    ASSIGN_OR_RETURN(const auto weights, Weights(change));
    for (size_t k = 0; k < count; ++k) {
      x[k] += change[k];
      for (size_t j = 0; j < steps_.size(); ++j) {
        x[k] -= weights[j] * (steps_[j].of_x[k] + steps_[j].of_change[k]);
      }
      x[k] = Maximum(x[k], V{});
      solver::ClearSpare(x[k]);
    }
    return {};
  }

 private:
  struct Step {
    std::vector<V> of_x, of_change;
  };

  // Of each step in memory, so that change − Σ weight · step is least over the area.
  Result<std::vector<V>> Weights(std::span<const V> change) const {
    const size_t n = steps_.size();
    std::vector<V> weights(n, V{});
    if (n == 0) return weights;
    std::vector<ChannelSums<V>> mine;
    const auto add = [&](std::span<const V> a, std::span<const V> b) {
      ChannelSums<V>& sums = mine.emplace_back();
      for (size_t k = 0; k < a.size(); ++k) Add(passing_.area_m2(k) * a[k] * b[k], sums);
    };
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = 0; j <= i; ++j) add(steps_[i].of_change, steps_[j].of_change);
      add(steps_[i].of_change, change);
    }
    ASSIGN_OR_RETURN(const auto sums, ReduceSums<V>(passing_.exchange(), mine, nullptr));
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      std::vector<double> a(n * n, 0.0), x(n);
      size_t at = 0;
      for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j <= i; ++j) a[i * n + j] = sums[at++][c];
        x[i] = sums[at++][c];
      }
      SolveSmall(n, a, x);
      for (size_t i = 0; i < n; ++i) weights[i][c] = x[i];
    }
    return weights;
  }

  const Passing<V>& passing_;
  std::deque<Step> steps_;
  std::vector<V> last_x_, last_change_;
  int passes_ = 0;
};

// Power by channel of what leaves emit, with what is passed on; and of a change of that.
template <typename V>
Result<std::vector<V>> Powers(const Passing<V>& passing, const LeafSystemOf<V>& sources,
                              std::type_identity_t<std::span<const V>> change) {
  std::vector<ChannelSums<V>> mine(2);
  for (size_t i = 0; i < sources.size(); ++i) {
    V e = sources.exitance[i];
    if (!sources.given.empty()) e += sources.reflectance[i] * sources.given[i];
    Add(sources.area_m2[i] * e, mine[0]);
  }
  for (size_t k = 0; k < change.size(); ++k) Add(passing.area_m2(k) * Absolute(change[k]), mine[1]);
  return ReduceSums<V>(passing.exchange(), mine, nullptr);
}

// The share of what arrives that is reflected, passed on or reradiated, over all leaves: by what
// factor light comes back.
template <typename V>
Result<double> ShareHandedOn(const LeafSystemOf<V>& leaves, std::span<const V> irradiance,
                             Exchange& exchange) {
  std::vector<ChannelSums<V>> mine(2);
  for (size_t i = 0; i < leaves.size(); ++i) {
    const V arriving = leaves.area_m2[i] * irradiance[i];
    Add(arriving, mine[0]);
    Add((leaves.reflectance[i] + PassedShare(leaves, i)) * arriving, mine[1]);
  }
  ASSIGN_OR_RETURN(const auto sums, ReduceSums<V>(exchange, mine, nullptr));
  double share = 0;
  for (int c = 0; c < kChannelsOf<V>; ++c) {
    if (sums[0][c] > 0) share = std::max(share, sums[1][c] / sums[0][c]);
  }
  return share;
}

}  // namespace

template <typename V>
Result<SolverResultOf<V>> SolveWithPassedLight(Product& product, const LeafSystemOf<V>& leaves,
                                               std::type_identity_t<std::span<const V>> start,
                                               double accuracy, const SolveFunction<V>& solve,
                                               Exchange& exchange) {
  if (product.tree().sheets() == nullptr && product.tree().fluorescence() == nullptr) {
    return solve(leaves, start, accuracy);
  }
  Passing<V> passing(product, leaves, exchange);
  RETURN_IF_ERROR(passing.Measure());
  Mixer<V> mixer(passing);
  LeafSystemOf<V> sources = leaves;
  std::vector<V> irradiance(start.begin(), start.end());
  ASSIGN_OR_RETURN(std::vector<V> passed, passing.PassedBy(irradiance));
  uint32_t products = 0, iterations = 0, first = 0;
  double largest_eigenvalue = 0;
  std::vector<V> change(passing.size(), V{});
  for (int pass = 1;; ++pass) {
    passing.Put(passed, sources);
    ASSIGN_OR_RETURN(const auto before, Powers<V>(passing, sources, {}));
    const auto [growth, least_gap] = passing.GrowthAndGap(before[0]);
    ASSIGN_OR_RETURN(SolverResultOf<V> result,
                     solve(sources, irradiance, kMayLeave * least_gap / growth * accuracy));
    products += result.products;
    iterations += result.iterations;
    irradiance = result.irradiance;
    // Later passes start so near to their end that what they tell of their rates is noise.
    if (pass == 1) {
      if (result.indefinite) return result;
      first = products;
      largest_eigenvalue = result.largest_eigenvalue;
    }
    ASSIGN_OR_RETURN(const std::vector<V> next, passing.PassedBy(irradiance));
    for (size_t k = 0; k < passed.size(); ++k) change[k] = next[k] - passed[k];
    ASSIGN_OR_RETURN(const auto powers, Powers<V>(passing, sources, change));
    bool done = true;
    double left = 0;
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      const double emitted = passing.emitted_w()[c];
      if (!(emitted > 0)) continue;
      done &= powers[1][c] <= kMayChange * accuracy * passing.gap(c) * emitted;
      left = std::max(left, powers[1][c] / emitted);
    }
    if (done || pass == kMostPasses) {
      result.products = products;
      result.again = products - first;
      result.iterations = iterations;
      result.residual = growth * result.residual + left;
      ASSIGN_OR_RETURN(const double share,
                       ShareHandedOn<V>(leaves, std::span<const V>(irradiance), exchange));
      result.largest_eigenvalue = std::max(largest_eigenvalue, share);
      result.indefinite = false;
      return result;
    }
    if (product.tree().sheets() == nullptr) {
      passed = next;  // from channel to channel nothing comes back
    } else {
      RETURN_IF_ERROR(mixer.Next(change, passed));
    }
  }
}

Status AddPassedLight(Product& product, std::span<const Lanes> irradiance, LeafSystem& leaves) {
  if (product.tree().sheets() != nullptr) {
    leaves.passed_on.resize(leaves.size());
    RETURN_IF_ERROR(product.Behind(irradiance, std::span<Lanes>(leaves.passed_on)));
    for (size_t i = 0; i < leaves.size(); ++i) {
      leaves.passed_on[i] *= leaves.transmittance[i];
      leaves.exitance[i] += leaves.passed_on[i];
    }
  }
  for (size_t i = 0; i < leaves.reradiation.size(); ++i) {
    leaves.exitance[i] += Reradiated(leaves, i, irradiance[i]);
  }
  return {};
}

#define ISOLUX_FOR(V)                                                                       \
  template Result<SolverResultOf<V>> SolveWithPassedLight(Product&, const LeafSystemOf<V>&, \
                                                          std::span<const V>, double,       \
                                                          const SolveFunction<V>&, Exchange&);
ISOLUX_FOR(Single)
ISOLUX_FOR(Lanes)
#undef ISOLUX_FOR

}  // namespace isolux
