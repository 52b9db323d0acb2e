// Simulate only what a scene calls for. Each effect has a detector, which says whether it is
// present, on what evidence, and what neglecting it would cost at most; the plan follows from that,
// the accuracy asked for and what the user insists on. `inspect` and the coordinator show the same
// table.
#pragma once

#include <vector>

#include "common/hierarchy/effects/effect.h"
#include "common/hierarchy/hierarchy.h"
#include "common/scene/effects_choice.h"
#include "common/scene/effects_plan.h"

namespace isolux {

struct EffectsTable {
  std::vector<Effect> effects;  // in a fixed order, present or not
  EffectsPlan plan;
  double neglected = 0;  // sum of the bounds of effects that are present and left out for it
};

// An effect is left out where its bound is below a fifth of the accuracy; where the bounds of all
// that are left out add up to more than half of it, those of the largest are switched on.
EffectsTable PlanEffects(const Hierarchy& hierarchy, double accuracy, const EffectsChoice& choice);

}  // namespace isolux
