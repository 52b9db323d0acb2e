// What leaves radiate beyond E + ρH, as a snapshot has it: light that comes through translucent
// sheets, and light of shorter wavelength given out again.
#pragma once

#include <vector>

#include "common/hierarchy/fluorescence.h"
#include "common/hierarchy/snapshot.h"
#include "common/hierarchy/translucent_sheets.h"

namespace isolux {

// By leaf. Empty where there are no sheets and nothing fluoresces, between bands either; either
// may be null.
std::vector<PassedLight> PassedLightOf(const Snapshot& snapshot, const TranslucentSheets* sheets,
                                       const Fluorescence* fluorescence);

}  // namespace isolux
