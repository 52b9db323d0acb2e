// glTF 2.0 files, text (.gltf) or binary (.glb): the triangles of the scene's nodes and their
// materials, before anything is mended. Errors name file, element and remedy.
#pragma once

#include <string>

#include "client/import/scene_file.h"

namespace isolux {

Result<SceneFile> ReadGltf(const std::string& path, const SceneLimits& limits = {});
// The same from bytes; other files are looked for beside `path`.
Result<SceneFile> ParseGltf(const std::string& bytes, const std::string& path,
                            const SceneLimits& limits = {});

}  // namespace isolux
