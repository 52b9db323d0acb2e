// In a closed room what leaves an element arrives somewhere: the row of a leaf must add up to its
// area. Couplings with errors miss that, and the solution magnifies what they miss by 1/(1 − ρ).
// The closure scales C → D C D, one factor a leaf, which keeps it symmetric and positive (Knight
// and Ruiz 2013).
#pragma once

#include "worker/radiosity/solver.h"

namespace isolux {

struct ClosureSummary {
  uint32_t products = 0;
  double worst_before = 0;  // largest |row sum / area − 1| of closed leaves without any factor
  double worst_after = 0;
};

// Rows of leaves that may lose light can add up to anything below their area. Couplings that spread
// evenly over a node what varies make them scatter by a fifth about the truth, so only rows far
// above are cut down; cutting all above 1 would lose what the rows below 1 lack.
inline constexpr double kLargestOpenRow = 1.5;

// Improves leaves.closure, starting from what is there, until every row of a leaf with closed[i] !=
// 0 adds up to its area within `tolerance` and no other row to more than `largest_open_row` areas,
// or twenty products are spent. Open rows below that keep factor 1.
Result<ClosureSummary> Close(Product& product, LeafSystem& leaves, std::span<const uint8_t> closed,
                             double tolerance, double largest_open_row, Exchange& exchange);

}  // namespace isolux
