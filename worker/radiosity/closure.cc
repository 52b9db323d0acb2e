#include "worker/radiosity/closure.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

constexpr uint32_t kMostProducts = 20;
constexpr double kLeast = 0.5,
                 kMost = 2.0;  // of a factor: beyond, a link is missing or light leaks

}  // namespace

Result<ClosureSummary> Close(Product& product, LeafSystem& leaves, std::span<const uint8_t> closed,
                             double tolerance, Exchange& exchange) {
  ClosureSummary summary;
  const size_t n = leaves.size();
  std::vector<Lanes> radiosity(n), row(n);
  while (true) {
    for (size_t i = 0; i < n; ++i) radiosity[i] = Lanes{leaves.closure[i], 0, 0, 0};
    RETURN_IF_ERROR(product.Irradiance(radiosity, kMost, 1, row));
    ++summary.products;
    Reduction reduction;
    reduction.maxima = {0, 0};
    for (size_t i = 0; i < n; ++i) {
      if (closed[i] == 0 || !(row[i][0] > 0)) continue;
      reduction.maxima[0] =
          std::max(reduction.maxima[0], std::abs(leaves.closure[i] * row[i][0] - 1));
      reduction.maxima[1] = 1;
    }
    ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(reduction)));
    summary.worst_after = total.maxima[0];
    if (summary.products == 1) summary.worst_before = total.maxima[0];
    if (total.maxima[1] == 0 || summary.worst_after <= tolerance ||
        summary.products >= kMostProducts) {
      return summary;
    }
    for (size_t i = 0; i < n; ++i) {
      if (closed[i] == 0 || !(row[i][0] > 0)) continue;
      double& factor = leaves.closure[i];
      const double step = std::clamp(std::sqrt(1 / (factor * row[i][0])), 0.8, 1.25);
      factor = std::clamp(factor * step, kLeast, kMost);
    }
  }
}

}  // namespace isolux
