// How the estimated error is spread over the leaves, and what rows that do not add up can do to the
// light: the figures beside the estimate that a round reports.
#pragma once

#include <span>

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/closure.h"
#include "worker/radiosity/error_estimate.h"

namespace isolux {

struct ErrorSpread {
  // Share of the light that the rows' residuals make or lose, with all bounces, or put in the wrong
  // place.
  double closure = 0;
  double rms = 0;     // √(mean |ΔH|²) / mean H, closure included
  double total = 0;   // the estimate's total with it
  LocalErrors local;  // of own leaves, relative to max(H, 5 % of the mean)
};

// One reduction. `ids`: of own leaves; `closing`: empty where no rows were closed. `scene_area_m2`:
// of all sides that take part.
Result<ErrorSpread> SpreadError(const LeafSystem& leaves, std::span<const NodeId> ids,
                                std::span<const Lanes> irradiance, const ErrorEstimate& estimate,
                                const ClosureSummary& closing, double largest_eigenvalue,
                                double scene_area_m2, Exchange& exchange);

}  // namespace isolux
