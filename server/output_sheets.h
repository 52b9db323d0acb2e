// Both sides of translucent sheets in the output: what arrives on the one is seen on the other, so
// they are divided alike.
#pragma once

#include <vector>

#include "common/hierarchy/translucent_sheets.h"
#include "server/output_element.h"

namespace isolux {

// Cuts elements of sheets, interpolating, until no element of the other side is finer. `elements`
// are sorted by id; at most as many come to them as there are on the other sides.
void DivideSheetsAlike(const Hierarchy& hierarchy, const TranslucentSheets& sheets,
                       std::vector<OutputElement>* elements);

// Of each element the place of the same piece on the other side, or TranslucentSheets::kNone where
// there is none, or nothing arrives there.
std::vector<uint32_t> ElementsBehind(const TranslucentSheets& sheets,
                                     const std::vector<OutputElement>& elements);

}  // namespace isolux
