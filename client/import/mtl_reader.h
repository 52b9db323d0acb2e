// Wavefront MTL files: what a material says, before anything is mended.
#pragma once

#include <string>
#include <vector>

#include "client/import/scene_file.h"

namespace isolux {

// The materials of a file in its order. Kd and Ke that are no numbers, not finite or negative are
// errors that name file and line.
Result<std::vector<FileMaterial>> ReadMtl(const std::string& path);
// The same from bytes; `path` stands in messages and gives the folder of the maps.
Result<std::vector<FileMaterial>> ParseMtl(std::string bytes, const std::string& path);

}  // namespace isolux
