#include "worker/radiosity/closure.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

constexpr uint32_t kMostProducts = 20;
// Of a factor. Above the most, a link is missing; the least only guards against nonsense.
constexpr double kLeast = 1e-3, kMost = 2.0;
// Of one step: larger ones overshoot where neighbours are scaled too.
constexpr double kSmallestStep = 0.5, kLargestStep = 1.25;

}  // namespace

Result<ClosureSummary> Close(Product& product, LeafSystem& leaves,
                             std::span<const RowBounds> bounds, double tolerance,
                             Exchange& exchange) {
  ClosureSummary summary;
  const size_t n = leaves.size();
  std::vector<Lanes> radiosity(n), row(n);
  // Row sum over what it should be; 1 where nothing is to be done.
  const auto excess = [&](size_t i) {
    const double sum = leaves.closure[i] * row[i][0];
    if (!(sum > 0)) return 1.0;
    if (sum > bounds[i].high) return sum / std::max(bounds[i].high, kLeast * kLeast);
    return sum < bounds[i].low ? sum / bounds[i].low : 1.0;
  };
  while (true) {
    for (size_t i = 0; i < n; ++i) radiosity[i] = Lanes{leaves.closure[i], 0, 0, 0};
    RETURN_IF_ERROR(product.Irradiance(radiosity, kMost, 1, row));
    ++summary.products;
    Reduction reduction;
    reduction.maxima = {0};
    for (size_t i = 0; i < n; ++i) {
      reduction.maxima[0] = std::max(reduction.maxima[0], std::abs(excess(i) - 1));
    }
    ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(reduction)));
    summary.worst_after = total.maxima[0];
    if (summary.products == 1) summary.worst_before = total.maxima[0];
    if (summary.worst_after <= tolerance || summary.products >= kMostProducts) return summary;
    for (size_t i = 0; i < n; ++i) {
      double& factor = leaves.closure[i];
      const double step = std::clamp(std::sqrt(1 / excess(i)), kSmallestStep, kLargestStep);
      factor = std::clamp(factor * step, kLeast, kMost);
    }
  }
}

}  // namespace isolux
