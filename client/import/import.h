// Scene file → canonical Scene, with everything mended on the way counted in Scene::repairs.
#pragma once

#include <string>

#include "common/scene/scene.h"

namespace isolux {

struct ImportOptions {
  bool emit_both = false;        // --emit both: emitters radiate from both sides (default: front)
  bool reflect_front = false;    // --reflect front: only fronts take part (default: both sides)
  std::string unit = "m";        // --unit m|cm|mm|in|ft: of the file's coordinates
  bool strict = false;           // --strict: refuse what would be repaired
  bool require_emission = true;  // refuse a scene in which nothing emits
  // False: the polygons stay those of the file. Only what is neither a triangle nor a convex planar
  // quad is divided into triangles, each with the number of its polygon in the file. Of a face and
  // its reversed twin both stay, with their fronts.
  bool prepare_for_transport = true;
};

// Reads `path` by its extension (.obj, .gltf or .glb in any case). Errors name the file, the line
// or element, and the remedy.
Result<Scene> ImportScene(const std::string& path, const ImportOptions& options);

}  // namespace isolux
