#include "worker/radiosity/error_draw.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/util/random.h"
#include "worker/radiosity/error_estimate.h"

namespace isolux {
namespace {

// Errors at leaves in units of the mean irradiance, as integers.
constexpr double kScale = 0x1p36, kLargest = 4096;
// That the solver works to: what goes up and what goes down is nearly the same.
constexpr double kAccuracy = 0.01;
// One alone might be small by chance: light between two rooms knows only more and less.
constexpr int kDraws = 4;

double SumOf(const Lanes& v) { return v[0] + v[1] + v[2]; }

// Up or down, in each of the draws: the same whoever holds the link, either way round.
Lanes SignsOf(const NodeId& p, const NodeId& q) {
  const auto number = [](const NodeId& id) { return Hash(id.surface, id.path); };
  const uint64_t hash = Hash(number(p) + number(q), 0);
  Lanes signs;
  for (int draw = 0; draw < kDraws; ++draw) signs[draw] = (hash >> draw & 1) != 0 ? 1 : -1;
  return signs;
}

// m² that the link's coupling may be off, from the power it may be off at either end.
double CouplingError(const LinkError& error, double xp, double xq) {
  const auto over = [&](double visibility_w, double coupling_w, double source) {
    return source > 0 ? std::hypot(visibility_w, coupling_w) / source : 0.0;
  };
  return std::max(over(error.visibility_p_w, error.coupling_p_w, xq),
                  over(error.visibility_q_w, error.coupling_q_w, xp));
}

Lanes Scaled(double relative) {
  return Lanes{} + kScale * std::clamp(relative, -kLargest, kLargest);
}

// Σ A |ΔH| of what is reflected of two draws. Solved for beside an even light, which is taken off
// again: a solver wants more light than darkness.
Result<std::array<double, 2>> MovedByTwo(const LeafSystem& leaves, std::span<const IntLanes> off,
                                         int first, double unit, const SolveFunction<Lanes>& solve,
                                         Exchange& exchange) {
  LeafSystem errors = leaves;
  errors.given.clear();
  Reduction sizes;
  sizes.sums.resize(2);  // of A |what is reflected|, of A
  for (size_t i = 0; i < leaves.size(); ++i) {
    const double albedo = SumOf(leaves.reflectance[i]) / 3;
    const auto reflected = [&](int draw) {
      return albedo * unit * static_cast<double>(off[i][draw]) / kScale;
    };
    errors.reflectance[i] = Lanes{albedo, albedo, albedo, 0};
    errors.exitance[i] = Lanes{0, reflected(first), reflected(first + 1), 0};
    sizes.sums[0].Add(leaves.area_m2[i] * SumOf(Absolute(errors.exitance[i])));
    sizes.sums[1].Add(leaves.area_m2[i]);
  }
  ASSIGN_OR_RETURN(const Reduction size, exchange.Reduce(std::move(sizes)));
  const double even = size.sums[0].Value() / size.sums[1].Value();
  if (!(even > 0)) return std::array<double, 2>{};
  for (Lanes& exitance : errors.exitance) exitance += Lanes{even, even, even, 0};
  ASSIGN_OR_RETURN(const SolverResult solved,
                   solve(errors, std::vector<Lanes>(leaves.size(), Lanes{}), kAccuracy));
  Reduction moved;
  moved.sums.resize(2);
  for (size_t i = 0; i < leaves.size(); ++i) {
    for (size_t k = 0; k < 2; ++k) {
      const Lanes& h = solved.irradiance[i];
      moved.sums[k].Add(leaves.area_m2[i] * std::abs(h[static_cast<int>(k) + 1] - h[0]));
    }
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(moved)));
  return std::array{total.sums[0].Value(), total.sums[1].Value()};
}

}  // namespace

Result<double> DrawError(Product& product, const Tree& tree, const LeafSystem& leaves,
                         std::span<const Lanes> irradiance, const SolveFunction<Lanes>& solve,
                         Exchange& exchange) {
  const size_t n = leaves.size();
  std::vector<Single> radiosity(n);
  Reduction arriving;
  arriving.sums.resize(2);  // of H A, of A
  for (size_t i = 0; i < n; ++i) {
    radiosity[i] = Single{SumOf(leaves.exitance[i] + leaves.reflectance[i] * irradiance[i])};
    arriving.sums[0].Add(leaves.area_m2[i] * SumOf(irradiance[i]));
    arriving.sums[1].Add(leaves.area_m2[i]);
  }
  ASSIGN_OR_RETURN(const Reduction whole, exchange.Reduce(std::move(arriving)));
  const double unit = whole.sums[0].Value() / whole.sums[1].Value();
  if (!(unit > 0)) return 0.0;

  std::vector<IntLanes> off(n);
  using Inherit = Product::Inherit;
  RETURN_IF_ERROR(product.Sums<IntLanes>(
      radiosity, {Inherit::kWhole, Inherit::kWhole, Inherit::kWhole, Inherit::kWhole},
      [&](const Link& link, const Slots::Ends& ends, double xp, double xq, Lanes& to_p,
          Lanes& to_q) {
        const double error_m2 = CouplingError(DoubtedError(tree, link, xp, xq), xp, xq);
        const Lanes signs = SignsOf(tree.node(link.p).id, tree.node(link.q).id);
        const double moved = error_m2 * (xq - xp) / unit;
        to_p = signs * Scaled(moved * product.inverse_area(ends.p));
        to_q = signs * Scaled(-moved * product.inverse_area(ends.q));
      },
      std::span<IntLanes>(off)));

  double squares = 0;
  for (int first = 0; first < kDraws; first += 2) {
    ASSIGN_OR_RETURN(const auto moved,
                     MovedByTwo(leaves, std::span(off), first, unit, solve, exchange));
    for (const double power_w : moved) squares += power_w * power_w / kDraws;
  }
  return kLinkErrorCalibration * std::sqrt(squares) / whole.sums[0].Value();
}

}  // namespace isolux
