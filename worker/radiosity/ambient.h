// The first solution, from which the first links are judged: every component of the scene lit
// evenly, by what is emitted in it and neither absorbed nor lost.
#pragma once

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "worker/radiosity/escape.h"

namespace isolux {

// H = Σ A E / Σ A (1 − ρ + ρ o) in each component and channel, o the share that escapes; 0 where
// nothing emits. Depends on the scene and the scout alone.
Snapshot AmbientSnapshot(const Hierarchy& hierarchy, const Scout& scout);

}  // namespace isolux
