// Wavefront OBJ files: points, faces and materials as the file has them, in the file's unit, before
// anything is mended. Errors name file, line and remedy.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/import/mtl_reader.h"
#include "common/scene/scene.h"

namespace isolux {

inline constexpr uint32_t kNoMaterial = 0xffffffffu;

struct ObjFace {
  uint64_t first = 0;               // of its corners, in ObjFile::corners
  uint32_t count = 0;               // at least 3
  uint32_t line = 0;                // in the OBJ file
  uint32_t material = kNoMaterial;  // in ObjFile::materials
};

struct ObjFile {
  std::string path;
  std::vector<Vec3> points;
  std::vector<uint32_t> corners;  // numbers of points, from 0
  std::vector<ObjFace> faces;     // in file order: a face's number is its place
  std::vector<MtlMaterial> materials;

  // Libraries named but not found, where ("room.obj:3"); no face needs a material of theirs.
  std::vector<std::string> missing_libraries;
  // Materials whose name was taken already, where ("room.mtl:17"); the first counts.
  std::vector<std::string> repeated_materials;
};

Result<ObjFile> ReadObj(const std::string& path, const SceneLimits& limits = {});
// The same from bytes; material libraries are looked for beside `path`.
Result<ObjFile> ParseObj(std::string bytes, const std::string& path,
                         const SceneLimits& limits = {});

}  // namespace isolux
