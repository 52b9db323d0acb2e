// What of the physics a job simulates: a function of its scene and options alone, so every process
// finds the same (common/hierarchy/effects/plan.h).
#pragma once

#include "common/vec.h"

namespace isolux {

struct EffectsPlan {
  // 3, or 1: then every reflectance counts as grey, and all light is `light_colour` times one
  // number, in which a lamp emits the dot product of its exitance and `exitance_weights`.
  int channels = 3;
  Rgb light_colour{1.0};  // the largest component is 1
  Rgb exitance_weights{0.0};
  bool bands = false;     // spectral ones are solved for, once the channels are
  double grey_error = 0;  // bound on what counting reflectances as grey costs, of the mean of H
  // The same of effects that are left out by what the first round measured.
  double measured_error = 0;
  bool occlusion = true;        // polygons stand in each other's light: shadow rays
  bool interreflection = true;  // solved for; else one pass of direct light
  bool closure = true;          // rows are scaled to what they must add up to
  bool lights = true;           // points, spots and directional lights shine
  bool sun = true;              // and those of them that are discs
  bool sky = true;
  bool medium = true;        // absorbs
  bool glass = true;         // panes take what they do; else nothing
  bool mirrors = true;       // reflect as such; else with their diffuse reflectance alone
  bool sheets = true;        // pass light on; else they are opaque
  bool textures = true;      // light meets reflectance maps; else their means over surfaces
  bool fluorescence = true;  // else what would be given out again is absorbed
};

// The mean of the channels; of a grey reflectance itself, to the bit.
inline double GreyOf(const Rgb& reflectance) {
  const bool grey = reflectance.x == reflectance.y && reflectance.y == reflectance.z;
  return grey ? reflectance.x : Sum(reflectance) / 3;
}

}  // namespace isolux
