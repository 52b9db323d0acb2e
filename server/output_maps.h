// Output elements small enough to show what maps do to them.
#pragma once

#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "server/output_element.h"

namespace isolux {

// Cuts into four, up to three times, elements over which a map makes the radiosity deviate by more
// than a tenth of its mean. Nothing is gathered for them: the irradiance is interpolated. Where
// there would be more than `max_elements`, the rest stay whole. Keeps the elements sorted by id.
void DivideByMaps(const Hierarchy& hierarchy, uint64_t max_elements,
                  std::vector<OutputElement>* elements);

}  // namespace isolux
