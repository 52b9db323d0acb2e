#include "worker/radiosity/error_estimate.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

// Mean of |x| over the root mean square of x, for a normal x.
constexpr double kMeanOfAbsolute = 0.8;
// Share of a link's visibility error that rays at the output points leave.
constexpr double kVisibilityAfterGather = 0.6;
// The same of its source variation, which the oracle weighs three times: the gather opens sources.
constexpr double kSpreadAfterGather = 0.28;
// The estimate is at least this share of how much the solution moved in the round. In the first
// one, from ambient light, links do not know yet how the radiosity of their ends varies; from the
// second on the terms of the links see nearly all that is missing.
constexpr double kShareOfFirstChange = 0.4, kShareOfChange = 0.1;
// Errors of one leaf's links are less than independent, and some terms are bounds. With this factor
// estimate/true lies in 0.7 … 3 for nine of ten runs of random rooms (docs/accuracy.md says how it
// is measured). It is up to 4 where small lamps stand close to a ceiling or a table at fine
// accuracies.
constexpr double kCalibration = 0.55;

// Squares of amplitudes in units of the mean irradiance, as integers: amplitudes from 1e-4 to 4,096
// of it.
constexpr double kSquareScale = 0x1p26, kLargestAmplitude = 4096;
constexpr double kAmplitudeScale = 0x1p30;  // of sums of amplitudes
// Of sums for what returns, which near lamps are many times the mean: up to 2^31 and 2^37 of it.
constexpr double kBrightScale = 0x1p20, kBrightestScale = 0x1p14;

// Variance of the irradiance over an element, over the most that it can be, mean · (range − mean):
// 1 where there are but two values, 1/3 where it grows evenly from 0.
constexpr double kShareOfVariance = 0.5;

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

double Amplitude(double amplitude) {
  return std::min(amplitude, kLargestAmplitude) * kAmplitudeScale;
}

double Square(double amplitude) {
  const double a = std::min(amplitude, kLargestAmplitude);
  return a * a * kSquareScale;
}

// Light that an element gets, in units of the mean irradiance.
struct Arriving {
  double whole = 0;           // irradiance
  double range = 0;           // Σ B · range of F over the element: no less than the whole's range
  double roots = 0;           // Σ B F √B
  double from_absorbers = 0;  // Σ B F (1 − albedo of the sender)
};

// The radiosity of its senders, by what they bring: no point gets more, whatever their form
// factors.
double BrightnessOfSenders(const Arriving& light) {
  if (!(light.whole > 0)) return 0;
  const double root = light.roots / light.whole;
  return root * root;
}

// The most that the irradiance deviates over an element when no point has less than nothing or more
// than the senders' radiosity (where there are but these two), twice: the range of two halves.
double LargestRange(const Arriving& light) {
  const double rest = std::max(0.0, BrightnessOfSenders(light) - light.whole);
  return 2 * std::sqrt(std::max(0.0, light.whole) * rest);
}

// What of an element's light comes back to the senders, beyond what even radiosity brings, and is
// absorbed there, per area: the element is brightest where it also sees the senders best. With H of
// its points, ρ (mean H² − (mean H)²) / B. Always more, so that such errors add up: they rule where
// lamps hang close below a ceiling. What senders of one brightness give together counts: below a
// lamp of many elements the whole is even.
double UnevenReturn(const Arriving& light, double reflectance) {
  const double brightest = BrightnessOfSenders(light);
  const double varies = std::min(light.range, brightest) - light.whole;
  if (!(varies > 0)) return 0;
  return reflectance * kShareOfVariance * light.from_absorbers / brightest * varies;
}

double MeanReflectance(const Tree& tree, uint32_t node) {
  const Rgb& reflectance = tree.surface_of(node).reflectance;
  return (reflectance.x + reflectance.y + reflectance.z) / 3;
}

// What a sender's light adds to the doubt and the light of a receiver: irradiance, its range there
// and its doubt, of the sender's radiosity, all in units of the mean irradiance.
Lanes DoubtAndLight(double irradiance, double range, double doubt, double radiosity,
                    double absorbs) {
  constexpr double kMost = 0x1p50;
  return Lanes{Amplitude(doubt), std::min(kMost, range * kBrightScale),
               std::min(kMost, irradiance * std::sqrt(radiosity) * kBrightestScale),
               std::min(kMost, irradiance * absorbs * kBrightScale)};
}

// Σ A |mean of H − H before| over the old leaves that own leaves lie on.
void AddChange(const LeafSystem& leaves, std::span<const Lanes> irradiance,
               const Previous& previous, ExactSum& sum) {
  if (previous.irradiance.empty()) return;
  for (size_t begin = 0, end = 0; begin < leaves.size(); begin = end) {
    Lanes now{};
    double area = 0;
    for (; end < leaves.size() && previous.leaf[end] == previous.leaf[begin]; ++end) {
      now += leaves.area_m2[end] * irradiance[end];
      area += leaves.area_m2[end];
    }
    sum.Add(SumOf(Absolute(now - area * previous.irradiance[begin])));
  }
}

}  // namespace

Result<ErrorEstimate> EstimateError(Product& product, const Tree& tree, const LeafSystem& leaves,
                                    std::span<const Lanes> irradiance,
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

  std::vector<IntLanes> sums(n);
  using Inherit = Product::Inherit;
  RETURN_IF_ERROR(product.Sums<IntLanes>(
      radiosity, {Inherit::kHalf, Inherit::kWhole, Inherit::kWhole, Inherit::kWhole},
      [&](const Link& link, const Slots::Ends& ends, double xp, double xq, Lanes& to_p,
          Lanes& to_q) {
        NodeValues p = tree.values(link.p), q = tree.values(link.q);
        p.radiosity = static_cast<float>(xp);
        q.radiosity = static_cast<float>(xq);
        const LinkError error = ErrorOf(tree, link, p, q);
        const double deviation = link.visibility_deviation();
        const double doubt = deviation > 0 ? link.doubt() / deviation : 0.0;
        const bool cluster = tree.is_cluster(link.p) || tree.is_cluster(link.q);
        const double share = cluster ? 0.0 : std::max(link.visibility(), 0.1) / unit;
        const double at_p = product.inverse_area(ends.p) / unit;
        const double at_q = product.inverse_area(ends.q) / unit;
        to_p =
            Lanes{Square(q.radiosity * link.variation_p * share), Square(error.spread_p_w * at_p),
                  Square(doubt * error.visibility_p_w * at_p), Square(error.coupling_p_w * at_p)};
        to_q =
            Lanes{Square(p.radiosity * link.variation_q * share), Square(error.spread_q_w * at_q),
                  Square(doubt * error.visibility_q_w * at_q), Square(error.coupling_q_w * at_q)};
      },
      std::span<IntLanes>(sums)));
  std::vector<IntLanes> doubts_and_light(n);
  RETURN_IF_ERROR(product.Sums<IntLanes>(
      radiosity, {Inherit::kWhole, Inherit::kHalf, Inherit::kWhole, Inherit::kWhole},
      [&](const Link& link, const Slots::Ends& ends, double xp, double xq, Lanes& to_p,
          Lanes& to_q) {
        const double at_p = product.inverse_area(ends.p), at_q = product.inverse_area(ends.q);
        const double brings = link.unoccluded_m2 * link.doubt() / unit;
        const bool cluster = tree.is_cluster(link.p) || tree.is_cluster(link.q);
        const double coupling = cluster ? 0.0 : link.coupling_m2() / unit;
        const double share = cluster ? 0.0 : link.visibility() / unit;
        const double absorbs_p = cluster ? 0.0 : 1 - MeanReflectance(tree, link.p);
        const double absorbs_q = cluster ? 0.0 : 1 - MeanReflectance(tree, link.q);
        to_p = DoubtAndLight(xq * coupling * at_p, xq * link.variation_p * share,
                             xq * brings * at_p, xq / unit, absorbs_q);
        to_q = DoubtAndLight(xp * coupling * at_q, xp * link.variation_q * share,
                             xp * brings * at_q, xp / unit, absorbs_p);
      },
      std::span<IntLanes>(doubts_and_light)));

  // Local errors, and how much ambient light they make or lose.
  struct Local {
    double spread, visibility, coupling, total;
  };
  std::vector<Local> local(n);
  Reduction parts;
  parts.sums.resize(5);  // of A |ΔH| by cause, of (A ρ ΔH)², of what should return and stay
  for (size_t i = 0; i < n; ++i) {
    const auto amplitude = [&](int lane) {
      return unit * std::sqrt(static_cast<double>(sums[i][lane]) / kSquareScale);
    };
    const auto sum = [&](int lane, double scale) {
      return static_cast<double>(doubts_and_light[i][lane]) / scale;
    };
    const Arriving light{SumOf(irradiance[i]) / unit, sum(1, kBrightScale), sum(2, kBrightestScale),
                         sum(3, kBrightScale)};
    estimate.leaves[i].spread = std::min(amplitude(0), unit * LargestRange(light));
    // At points what lights bring is found anew: its error over leaves counts as far as they
    // reflect.
    double unreflected = 0;
    if (!given.empty()) {
      estimate.leaves[i].spread = Root(estimate.leaves[i].spread, given[i].range);
      unreflected = given[i].error;
    }
    estimate.leaves[i].doubt = unit * static_cast<double>(doubts_and_light[i][0]) / kAmplitudeScale;
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
    const double reflected = area * AlbedoOf(leaves, i) * Root(l.total, unreflected);
    parts.sums[3].Add(reflected * reflected);
    parts.sums[4].Add(area * UnevenReturn(light, SumOf(leaves.reflectance[i]) / 3));
  }
  ASSIGN_OR_RETURN(const Reduction by_cause, exchange.Reduce(std::move(parts)));
  const double absorbing = std::max(totals.sums[2].Value(), 1e-6 * lit_area);
  const double ambient = std::sqrt(by_cause.sums[3].Value()) / absorbing;
  // Relative to the mean irradiance, as the sums of returns are.
  const double unreturned = by_cause.sums[4].Value() / absorbing;

  Reduction whole;
  whole.sums.resize(2);
  AddChange(leaves, irradiance, previous, whole.sums[1]);
  for (size_t i = 0; i < n; ++i) {
    const double rms = std::sqrt(local[i].total * local[i].total + ambient * ambient);
    estimate.leaves[i].error = SumOf(irradiance[i]) > 0
                                   ? Root(kCalibration * kMeanOfAbsolute * rms, unit * unreturned)
                                   : 0.0;
    if (!given.empty()) estimate.leaves[i].error += given[i].border;
    whole.sums[0].Add(leaves.area_m2[i] * estimate.leaves[i].error);
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(whole)));
  const double factor = kCalibration * kMeanOfAbsolute / arriving;
  estimate.spread = Root(factor * by_cause.sums[0].Value(), unreturned);
  estimate.visibility = factor * by_cause.sums[1].Value();
  estimate.coupling = factor * by_cause.sums[2].Value();
  estimate.solver =
      solved.neglected + solved.residual * totals.sums[3].Value() /
                             (arriving * std::max(1e-6, 1 - solved.largest_eigenvalue));
  estimate.change = total.sums[1].Value() / arriving;
  estimate.total =
      std::max(total.sums[0].Value() / arriving + estimate.solver,
               (previous.is_ambient ? kShareOfFirstChange : kShareOfChange) * estimate.change);
  return estimate;
}

}  // namespace isolux
