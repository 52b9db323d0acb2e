// Wavefront MTL files: what a material says, before anything is mended.
#pragma once

#include <string>
#include <vector>

#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

struct MtlMaterial {
  std::string name;
  std::string where;        // "room.mtl:17"
  std::string folder;       // of the MTL file: where its maps are looked for
  Rgb diffuse{0.0};         // Kd; 1 where only a map is given
  Rgb radiance{0.0};        // Ke, W/(m² sr)
  std::string diffuse_map;  // map_Kd as named, or empty
  bool emission_map = false;
  bool opacity_map = false;
  bool mirror = false;  // illum 3, 5 or 8
  bool glossy = false;  // Ks above 0, but no mirror
  bool glass = false;   // d below 1, or a transmission filter Tf
};

// The materials of a file in its order. Kd and Ke that are no numbers, not finite or negative are
// errors that name file and line.
Result<std::vector<MtlMaterial>> ReadMtl(const std::string& path);
// The same from bytes; `path` stands in messages and gives the folder of the maps.
Result<std::vector<MtlMaterial>> ParseMtl(std::string bytes, const std::string& path);

}  // namespace isolux
