// What of a finished solve's estimate is in doubt, in words: the parts of the error that rule it,
// each with what causes such errors and what helps.
#pragma once

#include <string>
#include <vector>

#include "common/scene/solve_options.h"

namespace isolux {

// A sentence for each part of the last round's error that is more than half of the estimate, the
// largest first, and for rows that far from add up over more than a tenth of the area. Empty where
// there are none of these, or no rounds.
std::vector<std::string> DoubtsOf(const SolveSummary& summary);

}  // namespace isolux
