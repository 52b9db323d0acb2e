// From the materials of a file to those of a scene, with the textures that vary them.
#pragma once

#include <vector>

#include "client/import/repair.h"
#include "client/import/scene_file.h"

namespace isolux {

// One material for each of the file's, and a last grey one for faces without. Only those of faces
// count: their maps are read, their defects reported. A map that is even is folded into the
// material; where the file has no texture coordinates, the mean of a map counts. Reflectances of 1
// or more, a map's texels included, become 0.98.
// The glass of each is returned (glass.h says which of them count).
std::vector<Glass> MakeMaterials(const SceneFile& file, Scene* scene, RepairLog* log);

}  // namespace isolux
