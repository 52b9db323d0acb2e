// Southwell's relaxation, known as shooting or progressive refinement
// [CohenChenWallaceGreenberg88]: the leaf with the most unshot power radiates it to all others. A
// pass is as many shots as there are leaves, at each worker among its own; what crosses between
// workers goes after the pass. A shot touches all leaves and the next is looked for among all: a
// pass is quadratic in the leaves of a worker.
#include <algorithm>
#include <cmath>

#include "worker/radiosity/solver_parts.h"

namespace isolux::solver {
namespace {

template <typename V>
class Run {
 public:
  explicit Run(const Problem<V>& problem)
      : problem_(problem),
        leaves_(problem.leaves),
        stopping_(problem),
        radiosity_(RadiosityFrom(leaves_, problem.start)),
        pending_(leaves_.size()),
        from_others_(leaves_.size()) {}

  Result<SolverResultOf<V>> Solve() {
    V bound = LargestOf<V>(radiosity_);
    ASSIGN_OR_RETURN(const auto sums, ReduceSums<V>(problem_.exchange, {}, &bound));
    RETURN_IF_ERROR(problem_.transport.Irradiance(radiosity_, bound, pending_));
    ++result_.products;
    for (size_t i = 0; i < pending_.size(); ++i) pending_[i] -= problem_.start[i];
    RETURN_IF_ERROR(Measure());
    while (!stopping_.Done(unshot_w_, rate_, result_.iterations > 0) && !diverges_ &&
           result_.products + 1 < problem_.options.max_products) {
      RETURN_IF_ERROR(Pass());
      if (problem_.options.watch && problem_.options.watch(WithAmbient())) break;
    }
    RETURN_IF_ERROR(Finish(problem_, WithAmbient(), &result_));
    result_.indefinite = diverges_;
    SetEigenvalue<V>(rate_, &result_);
    return std::move(result_);
  }

 private:
  // Unshot radiosity is what is reflected of the pending irradiance.
  V Unshot(size_t i) const { return Select(going_, leaves_.reflectance[i] * pending_[i], V{}); }

  size_t Brightest() const {
    size_t best = 0;
    double most = -1;
    for (size_t i = 0; i < pending_.size(); ++i) {
      const V power = leaves_.area_m2[i] * Absolute(Unshot(i));
      double sum = 0;
      for (int c = 0; c < kChannelsOf<V>; ++c) sum += power[c];
      if (sum > most) {
        most = sum;
        best = i;
      }
    }
    return best;
  }

  Status Pass() {
    going_ = stopping_.Going();
    std::vector<V> sent(leaves_.size(), V{});
    ChannelSums<V> shot;
    for (size_t k = 0; k < leaves_.size(); ++k) {
      if (k % 256 == 0 && problem_.exchange.Cancelled()) {
        return {StatusCode::kCancelled, "the solution was cancelled"};
      }
      const size_t i = Brightest();
      const V radiosity = Unshot(i);
      Add(leaves_.area_m2[i] * Absolute(radiosity), shot);
      radiosity_[i] += radiosity;
      sent[i] += radiosity;
      pending_[i] = Select(going_, V{}, pending_[i]);
      problem_.transport.Shoot(i, radiosity, pending_);
    }
    V bound = LargestOf<V>(sent);
    ASSIGN_OR_RETURN(const auto sums, ReduceSums<V>(problem_.exchange, {shot}, &bound));
    RETURN_IF_ERROR(problem_.transport.IrradianceFromOthers(sent, bound, from_others_));
    for (size_t i = 0; i < pending_.size(); ++i) pending_[i] += from_others_[i];
    ++result_.products;
    ++result_.iterations;
    const V before_w = unshot_w_;
    RETURN_IF_ERROR(Measure());
    // Unshot power fell by what was shot and rose by what of it was reflected: λ of the shots.
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      if (stopping_.done(c) || !(sums[0][c] > 0)) continue;
      rate_[c] = std::max(rate_[c], 1 - (before_w[c] - unshot_w_[c]) / sums[0][c]);
      diverges_ |= !(rate_[c] <= kLargestEigenvalue);
    }
    return {};
  }

  Status Measure() {
    ChannelSums<V> unshot, balance, reflecting;
    for (size_t i = 0; i < pending_.size(); ++i) {
      const V reflecting_m2 = leaves_.area_m2[i] * leaves_.reflectance[i];
      Add(reflecting_m2 * Absolute(pending_[i]), unshot);
      Add(reflecting_m2 * pending_[i], balance);
      Add(reflecting_m2, reflecting);
    }
    ASSIGN_OR_RETURN(const auto sums,
                     ReduceSums<V>(problem_.exchange, {unshot, balance, reflecting}, nullptr));
    unshot_w_ = sums[0];
    balance_w_ = sums[1];
    reflecting_m2_ = sums[2];
    return {};
  }

  // What is unshot counts as radiated, and what it will still cause as spread evenly over the
  // scene: the ambient light of the shooting method.
  std::vector<V> WithAmbient() const {
    V ambient{};
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      if (!(reflecting_m2_[c] > 0) || !(rate_[c] < kLargestEigenvalue)) continue;
      ambient[c] = balance_w_[c] * rate_[c] / (1 - rate_[c]) / reflecting_m2_[c];
    }
    std::vector<V> radiosity(leaves_.size());
    for (size_t i = 0; i < radiosity.size(); ++i) {
      // What no light has reached so far may lie in a dark room.
      const MaskOf<V> lit = (radiosity_[i] > 0.0) | (pending_[i] != 0.0);
      radiosity[i] =
          radiosity_[i] + leaves_.reflectance[i] * (pending_[i] + Select(lit, ambient, V{}));
    }
    return radiosity;
  }

  const Problem<V>& problem_;
  const LeafSystemOf<V>& leaves_;
  Stopping<V> stopping_;
  std::vector<V> radiosity_;              // shot so far
  std::vector<V> pending_, from_others_;  // irradiance of which nothing was reflected yet
  MaskOf<V> going_{};
  V unshot_w_{}, balance_w_{}, reflecting_m2_{};
  Scalars<V> rate_{};
  bool diverges_ = false;
  SolverResultOf<V> result_;
};

}  // namespace

template <typename V>
Result<SolverResultOf<V>> Southwell(const Problem<V>& problem) {
  return Run<V>(problem).Solve();
}

template Result<SolverResultOf<Single>> Southwell(const Problem<Single>&);
template Result<SolverResultOf<Lanes>> Southwell(const Problem<Lanes>&);

}  // namespace isolux::solver
