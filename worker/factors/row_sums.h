// Row sums of a table of factors, and what is done about those above 1.
#pragma once

#include "worker/factors/factors.h"

namespace isolux {

// Fills in the row sums and lowers couplings so that none is above 1: with d_p = min(1, 1 / row_p),
// C_pq becomes C_pq · min(d_p, d_q). Symmetric, raises nothing, and one pass is enough: row p
// becomes at most d_p · row_p ≤ 1. What is taken away is added to the stated error.
void LowerRows(FactorTable* table);

}  // namespace isolux
