// Sheets as scenes have them.
#pragma once

#include <vector>

#include "common/scene/scene.h"

namespace isolux::testing {

// A sheet of these corners; its number in the scene.
inline uint32_t AddSheet(Scene& scene, const std::vector<Vec3>& corners, const Rgb& reflectance,
                         const Rgb& transmittance) {
  Polygon sheet;
  for (size_t i = 0; i < corners.size(); ++i) {
    sheet.vertices[i] = static_cast<uint32_t>(scene.vertices.size());
    scene.vertices.push_back(corners[i]);
  }
  sheet.material = static_cast<uint32_t>(scene.materials.size());
  sheet.file_polygon = scene.file_polygon_count++;
  scene.materials.push_back({"sheet", reflectance, Rgb(0.0)});
  scene.materials.back().transmittance = transmittance;
  scene.polygons.push_back(sheet);
  return sheet.file_polygon;
}

}  // namespace isolux::testing
