// Gauss–Seidel: leaf after leaf takes B = E + ρH from all that is known by then; what crosses
// between workers is of the sweep before, as in Jacobi. Couplings are not negative, so the sweeps
// converge whatever is left to the sweep before.
#include <algorithm>
#include <cmath>

#include "worker/radiosity/solver_parts.h"

namespace isolux::solver {
namespace {

// Sweeps before the ratio of two changes is believed.
constexpr uint32_t kSettling = 3;
// By which what single sweeps leave may be more than it seems: what crosses between workers lags.
constexpr double kScatter = 4;
// Sweeps in a row that change more than the one before: a warm start may have a few.
constexpr int kMostGrowing = 8;

}  // namespace

template <typename V>
Result<SolverResultOf<V>> GaussSeidel(const Problem<V>& problem) {
  const LeafSystemOf<V>& leaves = problem.leaves;
  Stopping<V> stopping(problem);
  std::vector<V> radiosity = RadiosityFrom(leaves, problem.start), from_others(leaves.size());
  SolverResultOf<V> result;
  V change_w{};
  Scalars<V> rate{};
  int growing = 0;
  bool done = stopping.Done(problem.emitted_w, rate, false);  // where nothing emits
  while (!done && growing < kMostGrowing && result.products + 1 < problem.options.max_products) {
    for (V& b : radiosity) ClearSpare(b);
    V bound = LargestOf<V>(radiosity);
    ASSIGN_OR_RETURN(auto sums, ReduceSums<V>(problem.exchange, {}, &bound));
    RETURN_IF_ERROR(problem.transport.IrradianceFromOthers(radiosity, bound, from_others));
    const MaskOf<V> going = stopping.Going();
    ChannelSums<V> change;
    problem.transport.Sweep(radiosity, from_others, [&](size_t i, const V& irradiance) {
      const V next = leaves.exitance[i] + leaves.reflectance[i] * irradiance;
      Add(leaves.area_m2[i] * Absolute(next - radiosity[i]), change);
      return Select(going, next, radiosity[i]);
    });
    ++result.products;
    ++result.iterations;
    if (problem.options.watch && problem.options.watch(radiosity)) break;

    // The change of a sweep is more than the power it leaves undone; the sweeps to come add up to
    // change · q/(1 − q) when each is q times the one before.
    ASSIGN_OR_RETURN(sums, ReduceSums<V>(problem.exchange, {change}, nullptr));
    V left_w{};
    bool grows = false;
    for (int c = 0; c < kChannelsOf<V>; ++c) {
      if (stopping.done(c)) continue;
      if (result.iterations > 1 && change_w[c] > 0) rate[c] = sums[0][c] / change_w[c];
      grows |= result.iterations > kSettling && !(rate[c] <= kLargestEigenvalue);
      left_w[c] = kScatter * sums[0][c] * (result.iterations > 1 ? std::min(rate[c], 1.0) : 1.0);
    }
    growing = grows ? growing + 1 : 0;
    change_w = sums[0];
    done = stopping.Done(left_w, rate, result.iterations >= kSettling);
  }
  RETURN_IF_ERROR(Finish(problem, std::move(radiosity), &result));
  result.indefinite = growing >= kMostGrowing;
  SetEigenvalue<V>(rate, &result);
  return result;
}

template Result<SolverResultOf<Single>> GaussSeidel(const Problem<Single>&);
template Result<SolverResultOf<Lanes>> GaussSeidel(const Problem<Lanes>&);

}  // namespace isolux::solver
