#include "worker/radiosity/leaks.h"

#include <cmath>

namespace isolux {

Result<Leaks> CountLeaks(const LeafSystem& leaves, std::span<const Lanes> irradiance,
                         std::span<const double> bend, double scene_area_m2, Exchange& exchange) {
  Reduction reduction;
  reduction.sums.resize(1);
  reduction.counts = {0};
  for (size_t i = 0; i < bend.size(); ++i) {
    const Lanes& h = irradiance[i];
    if (!(h[0] + h[1] + h[2] > 0) || !(std::abs(bend[i]) > kLeak)) continue;
    reduction.sums[0].Add(leaves.area_m2[i]);
    ++reduction.counts[0];
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(reduction)));
  if (total.counts.size() != 1 || total.sums.size() != 1) {
    return Error(StatusCode::kInternal, "a reduction came back with another length");
  }
  return Leaks{total.counts[0], total.sums[0].Value() / scene_area_m2};
}

}  // namespace isolux
