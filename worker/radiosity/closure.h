// What leaves an element arrives somewhere or leaves the scene: the row of a leaf must add up to
// its area less the share that escapes. Couplings with errors miss that, and the solution magnifies
// what they miss by 1/(1 − ρ). The closure scales C → D C D, one factor a leaf, which keeps it
// symmetric and positive ([KnightRuiz13]).
#pragma once

#include "worker/radiosity/solver.h"

namespace isolux {

// What the row sum of a leaf may be, over its area. In a closed component both are 1; where light
// escapes they are as far apart as the measured share is uncertain.
struct RowBounds {
  double low = 0, high = 1;
};

struct ClosureSummary {
  uint32_t products = 0;
  double worst_before =
      0;  // of leaves without any factor, how far a row is from its bounds, as share
  double worst_after = 0;
  std::vector<double>
      off;  // of each own leaf, how far its row is from its bounds in the end, as share
};

// Improves leaves.inheritance and leaves.closure, starting from what is there, until every row is
// within its bounds to `tolerance`, or twenty products are spent.
Result<ClosureSummary> Close(Product& product, LeafSystem& leaves,
                             std::span<const RowBounds> bounds, double tolerance,
                             Exchange& exchange);

}  // namespace isolux
