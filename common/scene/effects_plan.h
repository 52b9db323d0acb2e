// What of the physics a job simulates: a function of its scene and options alone, so every process
// finds the same (common/hierarchy/effects/plan.h).
#pragma once

namespace isolux {

struct EffectsPlan {
  bool occlusion = true;        // polygons stand in each other's light: shadow rays
  bool interreflection = true;  // solved for; else one pass of direct light
  bool closure = true;          // rows are scaled to what they must add up to
};

}  // namespace isolux
