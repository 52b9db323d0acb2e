// Wavefront OBJ files: points, faces and materials as the file has them, in the file's unit, before
// anything is mended. Errors name file, line and remedy.
#pragma once

#include <string>

#include "client/import/scene_file.h"

namespace isolux {

Result<SceneFile> ReadObj(const std::string& path, const SceneLimits& limits = {});
// The same from bytes; material libraries are looked for beside `path`.
Result<SceneFile> ParseObj(std::string bytes, const std::string& path,
                           const SceneLimits& limits = {});

}  // namespace isolux
