// Spectra of isolux.json: bands of wavelengths, and what materials reflect, pass on, emit and
// reradiate in each.
//
//   {"spectra": {"bands_nm": [[400, 490], [490, 580], [580, 700]],
//                "materials": {"wall": {"reflectance": [0.2, 0.5, 0.7], "transmittance": …},
//                              "lamp": {"exitance_w_m2": [1, 3, 2]},
//                              "card": {"reradiation": [[0, 0.3, 0.1], [0, 0, 0.2], [0, 0, 0]]}}}}
//
// Each is one number for all bands or one a band; reradiation is a row a band that light is taken
// from, in it a number a band that it comes out in.
#pragma once

#include "client/import/json_element.h"
#include "client/import/scene_file.h"
#include "common/util/status.h"

namespace isolux {

// Reads them into the file; lights and sky lose channels that have no band.
Status ReadSpectra(const JsonElement& element, SceneFile* file);

// Gives the scene its bands and its materials, which are those of the file, their spectra, and what
// follows from them for red, green and blue. A spectrum of a material that does not exist, has a
// map, is glass or gives back more than arrives is an error.
Status ApplySpectra(const SceneFile& file, Scene* scene);

}  // namespace isolux
