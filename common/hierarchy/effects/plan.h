// Simulate only what a scene calls for. Each effect has a detector, which says whether it is
// present, on what evidence, and what neglecting it would cost at most; the plan follows from that,
// the accuracy asked for and what the user insists on. `inspect` and the coordinator show the same
// table.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/hierarchy/effects/effect.h"
#include "common/hierarchy/hierarchy.h"
#include "common/scene/effects_choice.h"
#include "common/scene/effects_plan.h"
#include "common/scene/measured_effect.h"

namespace isolux {

struct EffectsTable {
  std::vector<Effect> effects;  // in a fixed order, present or not
  EffectsPlan plan;
  double neglected = 0;  // sum of the bounds of effects that are present and left out for it
  // Effects whose neglect the first round should measure: they are on for want of a better bound.
  // And mirrors that are too many to be simulated, and gloss, which never is.
  std::vector<std::string> to_measure;
};

// An effect is left out where its bound is below a fifth of the accuracy; where the bounds of all
// that are left out add up to more than half of it, those of the largest are switched on.
// `measured`: of a job whose first round has measured these; what is off by that stays off, and
// nothing is switched on that was off before.
EffectsTable PlanEffects(const Hierarchy& hierarchy, double accuracy, const EffectsChoice& choice,
                         std::span<const MeasuredEffect> measured = {});

// Sets bounds and decisions of what was measured to those of this table, which knows of it. Whether
// any effect is left out for it.
bool NoteDecisions(const EffectsTable& table, std::vector<MeasuredEffect>* measured);

// The plan for a group of a scene's bands: that of the whole scene, in one channel where the bands
// differ in nothing. `of_group`: the hierarchy with the group's optics (SceneOfGroup).
EffectsPlan PlanGroup(const Hierarchy& of_group, const Scene& whole, uint32_t group,
                      const EffectsPlan& plan);

}  // namespace isolux
