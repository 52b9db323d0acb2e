// What finds effects in a scene, a function each, a file a group. Each fills in all of a row but
// the decision. A new effect is a function here and a line in plan.cc.
#pragma once

#include "common/hierarchy/effects/effect.h"
#include "common/hierarchy/hierarchy.h"
#include "common/scene/effects_plan.h"

namespace isolux {

// light.cc: how light goes from side to side.
Effect DetectOcclusion(const Hierarchy& hierarchy);
Effect DetectInterreflection(const Hierarchy& hierarchy);
Effect DetectClosure(const Hierarchy& hierarchy);
Effect DetectTwoSided(const Hierarchy& hierarchy);

// lights.cc: what comes from no polygon.
Effect DetectLights(const Hierarchy& hierarchy);
Effect DetectSun(const Hierarchy& hierarchy);
Effect DetectSky(const Hierarchy& hierarchy);
// Power that a light brings to the surfaces at most, W.
Rgb BroughtPower(const Hierarchy& hierarchy, const Light& light);
// What an even sky of its mean would bring to all sides that take part if nothing hid it, W.
Rgb SkyPower(const Hierarchy& hierarchy);
// Whether a light may stand behind a side that takes part, or far away: then things stand between
// even in a convex room.
bool ShinesFromOutside(const Hierarchy& hierarchy, const Light& light);

// medium.cc
Effect DetectMedium(const Hierarchy& hierarchy);

// glass.cc
Effect DetectClearGlass(const Hierarchy& hierarchy);

// mirrors.cc
// accuracy: of the irradiance, which says how many images it takes.
Effect DetectMirrors(const Hierarchy& hierarchy, double accuracy);

// gloss.cc
Effect DetectGloss(const Hierarchy& hierarchy);

// fluorescence.cc
Effect DetectFluorescence(const Hierarchy& hierarchy);

// textures.cc: what it costs at most if of reflectance maps the mean over each surface counts.
double BoundOfTextures(const Hierarchy& hierarchy);

// sheets.cc
Effect DetectSheets(const Hierarchy& hierarchy);

// colour.cc
Effect DetectColour(const Hierarchy& hierarchy);
// The same for the three channels alone, without spectral bands.
Effect DetectChannels(const Hierarchy& hierarchy);

// What the importer found in the file and replaced by something simpler (replaced.cc), by what the
// repair report says of it. Maps are followed where the scene has them.
Effect DetectTextures(const Hierarchy& hierarchy);
Effect DetectEmissionMaps(const Scene& scene);
Effect DetectOpacityMaps(const Scene& scene);
Effect DetectReplacedMirrors(const Scene& scene);
Effect DetectReplacedGlass(const Scene& scene);

// The light of all lamps as one colour times one number, for a plan of one channel.
void SetLightColour(const Hierarchy& hierarchy, EffectsPlan* plan);

// What surfaces do with light in several ways together: the largest component of any, of channels
// or of spectral bands.
struct Shares {
  bool reflected = false;
  bool passed = false;      // by sheets
  bool reradiated = false;  // in others, of what arrives in one
};
double LargestShare(const Hierarchy& hierarchy, const Shares& shares);
// Of all three.
double LargestAlbedo(const Hierarchy& hierarchy);
// What a side passes on: 0 where it is not that of a sheet.
Rgb TransmittanceOf(const Hierarchy& hierarchy, const Surface& surface);

}  // namespace isolux
