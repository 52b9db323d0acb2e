#include "worker/radiosity/error_spread.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

// Root mean square over the mean of |x|, for a normal x.
constexpr double kRmsOverMean = 1.2533141373155001;
// Local errors are relative to the irradiance, but at least to this share of the mean.
constexpr double kDarkShare = 0.05;

}  // namespace

Result<ErrorSpread> SpreadError(const LeafSystem& leaves, std::span<const NodeId> ids,
                                std::span<const Lanes> irradiance, const ErrorEstimate& estimate,
                                const ClosureSummary& closing, double largest_eigenvalue,
                                double scene_area_m2, Exchange& exchange) {
  const auto arriving_at = [&](size_t i) {
    return irradiance[i][0] + irradiance[i][1] + irradiance[i][2];
  };
  Reduction reduction;
  // Of A H, of lit A, of A e, of A e², of what rows miss, and of what comes back instead.
  reduction.sums.resize(6);
  for (size_t i = 0; i < leaves.size(); ++i) {
    const double area = leaves.area_m2[i], arriving = arriving_at(i);
    if (!(arriving > 0)) continue;
    const double error = estimate.leaves[i].error;
    reduction.sums[0].Add(area * arriving);
    reduction.sums[1].Add(area);
    reduction.sums[2].Add(area * error);
    reduction.sums[3].Add(area * error * error);
    if (closing.off.empty()) continue;
    const double from_lights =
        leaves.given.empty() ? 0.0 : leaves.given[i][0] + leaves.given[i][1] + leaves.given[i][2];
    const double by_links = area * std::max(0.0, arriving - from_lights);
    reduction.sums[4].Add(closing.off[i] * by_links);
    reduction.sums[5].Add(closing.misplaced[i] * by_links);
  }
  ASSIGN_OR_RETURN(const Reduction totals, exchange.Reduce(std::move(reduction)));
  ErrorSpread spread;
  const double arriving = totals.sums[0].Value(), lit_m2 = totals.sums[1].Value();
  if (!(arriving > 0)) return spread;
  // What comes back is neither made nor lost, only in the wrong place.
  const double made = totals.sums[4].Value() / std::max(1e-6, 1 - largest_eigenvalue);
  spread.closure = (made + totals.sums[5].Value()) / arriving;
  spread.total = estimate.total + spread.closure;
  // The leaves' own errors without what is known of the whole alone; that is laid on them evenly.
  const double local = totals.sums[2].Value() / arriving;
  const double scale = local > 0 ? spread.total / local : 0.0;
  const double mean = arriving / lit_m2;
  spread.rms = local > 0 ? kRmsOverMean * scale * std::sqrt(totals.sums[3].Value() / lit_m2) / mean
                         : spread.total;
  for (size_t i = 0; i < leaves.size(); ++i) {
    const double error = scale * estimate.leaves[i].error;
    spread.local.Add(ids[i], error / std::max(arriving_at(i), kDarkShare * mean),
                     leaves.area_m2[i] / scene_area_m2);
  }
  return spread;
}

}  // namespace isolux
