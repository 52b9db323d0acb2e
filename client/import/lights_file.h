// isolux.json: lights, a sky, a medium and spectra that stand beside a scene file, for formats that
// have none. One in a folder counts for every scene of it.
//
//   {"lights": [{"type": "point", "position": [x, y, z], "intensity": 12},
//               {"type": "spot", "position": …, "direction": [x, y, z], "intensity": [r, g, b],
//                "inner_angle": 20, "outer_angle": 30},
//               {"type": "directional", "direction": …, "irradiance": …},
//               {"type": "ies", "file": "lamp.ies", "position": …, "direction": …},
//               {"type": "sun", "direction": …, "irradiance": …, "angular_diameter": 0.533}],
//    "sky": {…},                                                        see sky_file.h
//    "medium": {"extinction_per_m": [r, g, b]},
//    "spectra": {…}}                                                    see spectra_file.h
//
// Positions are in the scene file's unit, extinctions in 1/m whatever that is, intensities W/sr,
// irradiances W/m² across the light, angles in degrees from the axis.
#pragma once

#include <string>

#include "client/import/scene_file.h"
#include "common/util/status.h"

namespace isolux {

// Adds what isolux.json in the folder of the scene says, where there is one. Unknown keys are
// errors; they name the file, the element and the remedy.
Status AddLightsFile(SceneFile* file);
// The same from its text; `name` stands in messages.
Status ParseLightsFile(const std::string& text, const std::string& name, SceneFile* file);

}  // namespace isolux
