// The first solution, from which the first links are judged: every component of the scene lit
// evenly, by what is emitted in it and neither absorbed nor lost.
#pragma once

#include "common/hierarchy/fluorescence.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "worker/radiosity/escape.h"
#include "worker/radiosity/light_field.h"

namespace isolux {

// H = Σ A E / Σ A (1 − ρ + ρ o) in each component and channel, o the share that escapes; 0 where
// nothing emits. What lights bring to the surfaces (`given`, empty where there are none) is added,
// and what is reflected of it counts as emitted. Sheets pass light from component to component:
// what comes out of them counts as emitted too, and so does what is reradiated. Depends on these
// alone.
Snapshot AmbientSnapshot(const Hierarchy& hierarchy, const Scout& scout,
                         std::span<const GivenIrradiance> given, const TranslucentSheets& sheets,
                         const Fluorescence& fluorescence);

}  // namespace isolux
