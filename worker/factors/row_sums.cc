#include "worker/factors/row_sums.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

// Errors are stated to hold for nearly all couplings, not for each: a row this many times its
// errors above 1 has another cause.
constexpr double kBeyond = 3;

// Sums of value(factor) over the area of each end, both directions counted.
template <typename Value>
std::vector<double> RowSums(const FactorTable& table, const Value& value) {
  std::vector<double> sums(table.ends.size(), 0.0);
  for (const Factor& factor : table.factors) {
    sums[factor.p] += value(factor);
    if (factor.q != factor.p) sums[factor.q] += value(factor);
  }
  for (size_t i = 0; i < sums.size(); ++i) sums[i] /= table.ends[i].area_m2;
  return sums;
}

}  // namespace

void LowerRows(FactorTable* table) {
  const std::vector<double> before = RowSums(*table, [](const Factor& f) { return f.coupling_m2; });
  const std::vector<double> errors = RowSums(*table, [](const Factor& f) { return f.error_m2; });
  // A hair below 1, so that rounding does not leave a sum above it.
  constexpr double kOne = 1 - 1e-14;
  std::vector<double> scale(before.size(), 1.0);
  for (size_t i = 0; i < before.size(); ++i) {
    FactorEnd& end = table->ends[i];
    end.row_sum_before = before[i];
    end.row_error = errors[i];
    if (before[i] <= 1) continue;
    scale[i] = kOne / before[i];
    ++table->rows_lowered;
    if (before[i] - 1 > kBeyond * errors[i] + 1e-12) ++table->rows_beyond;
  }
  if (table->rows_lowered > 0) {
    for (Factor& factor : table->factors) {
      const double taken = (1 - std::min(scale[factor.p], scale[factor.q])) * factor.coupling_m2;
      factor.coupling_m2 -= taken;
      factor.error_m2 += taken;
    }
  }
  const std::vector<double> after = RowSums(*table, [](const Factor& f) { return f.coupling_m2; });
  for (size_t i = 0; i < after.size(); ++i) table->ends[i].row_sum = after[i];
}

}  // namespace isolux
