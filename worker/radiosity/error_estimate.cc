#include "worker/radiosity/error_estimate.h"

#include <algorithm>
#include <cmath>

#include "worker/radiosity/arriving_light.h"

namespace isolux {
namespace {

// Mean of |x| over the root mean square of x, for a normal x.
constexpr double kMeanOfAbsolute = 0.8;
// Share of a link's visibility error that rays at the output points leave: at these points, and in
// what is reflected there.
constexpr double kVisibilityAfterGather = 0.4, kVisibilityReflected = 0.6;
// The same of its source variation, which the oracle weighs three times: the gather opens sources.
constexpr double kSpreadAfterGather = 0.28;
// The estimate is at least this share of how much the solution moved in the round. In the first
// one, from ambient light, links do not know yet how the radiosity of their ends varies; from the
// second on the terms of the links see nearly all that is missing.
constexpr double kShareOfFirstChange = 0.38, kShareOfChange = 0.1;

// Squares of amplitudes in units of the mean irradiance, as integers: amplitudes from 1e-4 to 4,096
// of it.
constexpr double kSquareScale = 0x1p26, kLargestAmplitude = 4096;

// Of the sum of two squares.
double Root(double a, double b) { return std::sqrt(a * a + b * b); }

double SumOf(const Lanes& v) { return v[0] + v[1] + v[2]; }

// Mean over the channels of what is reflected, passed on or reradiated.
double AlbedoOf(const LeafSystem& leaves, size_t i) {
  double albedo = SumOf(leaves.reflectance[i]) / 3;
  if (!leaves.transmittance.empty()) albedo += SumOf(leaves.transmittance[i]) / 3;
  if (!leaves.reradiation.empty()) albedo += Sum(leaves.reradiation[i].Taken()) / 3;
  return albedo;
}

double Square(double amplitude) {
  const double a = std::min(amplitude, kLargestAmplitude);
  return a * a * kSquareScale;
}

// Of links by the values of now, squares in units of `unit`: range of irradiance; errors by spread,
// visibility and coupling.
Result<std::vector<IntLanes>> SumSquares(Product& product, const Tree& tree,
                                         std::span<const Single> radiosity, double unit) {
  std::vector<IntLanes> sums(radiosity.size());
  using Inherit = Product::Inherit;
  RETURN_IF_ERROR(product.Sums<IntLanes>(
      radiosity, {Inherit::kHalf, Inherit::kWhole, Inherit::kWhole, Inherit::kWhole},
      [&](const Link& link, const Slots::Ends& ends, double xp, double xq, Lanes& to_p,
          Lanes& to_q) {
        const LinkError error = DoubtedError(tree, link, xp, xq);
        const bool cluster = tree.is_cluster(link.p) || tree.is_cluster(link.q);
        const double share = cluster ? 0.0 : std::max(link.visibility(), 0.1) / unit;
        const double at_p = product.inverse_area(ends.p) / unit;
        const double at_q = product.inverse_area(ends.q) / unit;
        to_p = Lanes{Square(static_cast<float>(xq) * link.variation_p * share),
                     Square(error.spread_p_w * at_p), Square(error.visibility_p_w * at_p),
                     Square(error.coupling_p_w * at_p)};
        to_q = Lanes{Square(static_cast<float>(xp) * link.variation_q * share),
                     Square(error.spread_q_w * at_q), Square(error.visibility_q_w * at_q),
                     Square(error.coupling_q_w * at_q)};
      },
      std::span<IntLanes>(sums)));
  return sums;
}

// Σ A |mean of H − H before| over the old leaves that own leaves lie on; and Σ A (H − H before).
void AddChange(const LeafSystem& leaves, std::span<const Lanes> irradiance,
               const Previous& previous, ExactSum& sum, ExactSum& signed_sum) {
  if (previous.irradiance.empty()) return;
  for (size_t begin = 0, end = 0; begin < leaves.size(); begin = end) {
    Lanes now{};
    double area = 0;
    for (; end < leaves.size() && previous.leaf[end] == previous.leaf[begin]; ++end) {
      now += leaves.area_m2[end] * irradiance[end];
      area += leaves.area_m2[end];
    }
    const Lanes more = now - area * previous.irradiance[begin];
    sum.Add(SumOf(Absolute(more)));
    signed_sum.Add(SumOf(more));
  }
}

}  // namespace

LinkError DoubtedError(const Tree& tree, const Link& link, double radiosity_p, double radiosity_q) {
  NodeValues p = tree.values(link.p), q = tree.values(link.q);
  p.radiosity = static_cast<float>(radiosity_p);
  q.radiosity = static_cast<float>(radiosity_q);
  LinkError error = ErrorOf(tree, link, p, q);
  const double deviation = link.visibility_deviation();
  const double doubt = deviation > 0 ? link.doubt() / deviation : 0.0;
  error.visibility_p_w *= doubt;
  error.visibility_q_w *= doubt;
  return error;
}

double DriftToCome(double coarser) {
  constexpr double kPower = 0.3, kMost = 2;
  const double step = std::pow(coarser, kPower) - 1;
  return step * kMost > 1 ? 1 / step : kMost;
}

Result<ErrorEstimate> EstimateError(Product& product, const Tree& tree, const LeafSystem& leaves,
                                    std::span<const Lanes> irradiance,
                                    std::span<const RowMeasure> rows,
                                    std::span<const GivenIrradiance> given,
                                    const Previous& previous, const SolverResult& solved,
                                    Exchange& exchange) {
  const size_t n = leaves.size();
  std::vector<Single> radiosity(n);
  Reduction power;
  power.sums.resize(4);  // of H A, of lit area, of lit A (1 − ρ̄ − τ̄), of (E + ρH0) A
  for (size_t i = 0; i < n; ++i) {
    radiosity[i] = Single{SumOf(leaves.exitance[i] + leaves.reflectance[i] * irradiance[i])};
    const double area = leaves.area_m2[i];
    const double arriving = SumOf(irradiance[i]);
    power.sums[3].Add(area * SumOf(leaves.exitance[i]));
    if (!leaves.passed_on.empty()) power.sums[3].Add(-area * SumOf(leaves.passed_on[i]));
    if (!given.empty()) {
      power.sums[3].Add(area * SumOf(leaves.reflectance[i] * leaves.given[i]));
    }
    if (!(arriving > 0)) continue;
    power.sums[0].Add(area * arriving);
    power.sums[1].Add(area);
    power.sums[2].Add(area * (1 - AlbedoOf(leaves, i)));
  }
  ASSIGN_OR_RETURN(const Reduction totals, exchange.Reduce(std::move(power)));
  ErrorEstimate estimate;
  estimate.leaves.resize(n);
  const double arriving = totals.sums[0].Value();
  const double lit_area = totals.sums[1].Value();
  if (!(arriving > 0)) return estimate;
  const double unit = arriving / lit_area;
  const double mean_albedo = 1 - totals.sums[2].Value() / lit_area;

  ASSIGN_OR_RETURN(const auto squares, SumSquares(product, tree, radiosity, unit));
  ASSIGN_OR_RETURN(const auto arriving_light, SumArrivingLight(product, tree, radiosity, unit));

  // Local errors, and how much ambient light they make or lose.
  struct Local {
    double spread, visibility, coupling, total;
  };
  std::vector<Local> local(n);
  Reduction parts;
  parts.sums.resize(5);  // of A |ΔH| by cause, of (A ρ ΔH)², of what should return and stay
  for (size_t i = 0; i < n; ++i) {
    const auto amplitude = [&](int lane) {
      return unit * std::sqrt(static_cast<double>(squares[i][lane]) / kSquareScale);
    };
    const ArrivingLight& light = arriving_light[i];
    estimate.leaves[i].spread = std::min(amplitude(0), unit * light.LargestRange());
    // At points what lights bring is found anew: its error over leaves counts as far as they
    // reflect.
    double unreflected = 0;
    if (!given.empty()) {
      estimate.leaves[i].spread = Root(estimate.leaves[i].spread, given[i].range);
      unreflected = given[i].error;
    }
    estimate.leaves[i].doubt = unit * light.doubt;
    Local& l = local[i];
    l.spread = kSpreadAfterGather * amplitude(1);
    l.visibility = kVisibilityAfterGather * amplitude(2);
    l.coupling = amplitude(3);
    l.total =
        std::sqrt(l.spread * l.spread + l.visibility * l.visibility + l.coupling * l.coupling);
    const double area = leaves.area_m2[i];
    parts.sums[0].Add(area * l.spread);
    parts.sums[1].Add(area * l.visibility);
    parts.sums[2].Add(area * l.coupling);
    const double lost_elsewhere = !rows.empty() && rows[i].deviation == 0 ? mean_albedo : 0.0;
    const double to_reflect = Root(Root(l.spread, l.coupling), kVisibilityReflected * amplitude(2));
    const double reflected = area * Root((AlbedoOf(leaves, i) - lost_elsewhere) * to_reflect,
                                         AlbedoOf(leaves, i) * unreflected);
    parts.sums[3].Add(reflected * reflected);
    parts.sums[4].Add(area * light.UnevenReturn(SumOf(leaves.reflectance[i]) / 3));
  }
  ASSIGN_OR_RETURN(const Reduction by_cause, exchange.Reduce(std::move(parts)));
  const double absorbing = std::max(totals.sums[2].Value(), 1e-6 * lit_area);
  const double ambient = std::sqrt(by_cause.sums[3].Value()) / absorbing;
  // Relative to the mean irradiance, as the sums of returns are.
  const double unreturned = by_cause.sums[4].Value() / absorbing;

  Reduction whole;
  whole.sums.resize(3);
  AddChange(leaves, irradiance, previous, whole.sums[1], whole.sums[2]);
  for (size_t i = 0; i < n; ++i) {
    const double rms = std::sqrt(local[i].total * local[i].total + ambient * ambient);
    estimate.leaves[i].error =
        SumOf(irradiance[i]) > 0
            ? Root(kLinkErrorCalibration * kMeanOfAbsolute * rms, unit * unreturned)
            : 0.0;
    if (!given.empty()) estimate.leaves[i].error += given[i].border;
    whole.sums[0].Add(leaves.area_m2[i] * estimate.leaves[i].error);
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(whole)));
  const double factor = kLinkErrorCalibration * kMeanOfAbsolute / arriving;
  estimate.spread = Root(factor * by_cause.sums[0].Value(), unreturned);
  estimate.visibility = factor * by_cause.sums[1].Value();
  estimate.coupling = factor * by_cause.sums[2].Value();
  estimate.solver =
      solved.neglected + solved.residual * totals.sums[3].Value() /
                             (arriving * std::max(1e-6, 1 - solved.largest_eigenvalue));
  estimate.change = total.sums[1].Value() / arriving;
  estimate.drift = std::abs(total.sums[2].Value()) / arriving;
  estimate.total =
      std::max({total.sums[0].Value() / arriving + estimate.solver,
                (previous.is_ambient ? kShareOfFirstChange : kShareOfChange) * estimate.change,
                previous.is_ambient ? 0.0 : DriftToCome(previous.coarser) * estimate.drift});
  return estimate;
}

}  // namespace isolux
