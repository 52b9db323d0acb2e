// Irradiance that is known at points of a scene's surfaces: exact values, or those of another
// program, to measure a solution by.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

struct ReferencePoint {
  Vec3 position{0.0};   // in the scene file's unit
  Vec3 normal{0.0};     // unit, of the side meant
  Rgb irradiance{0.0};  // W/m²
  Rgb deviation{0.0};   // its standard error, W/m²; 0: exact
};

// CSV without a head, a line a point: position, normal, irradiance, standard error, three numbers
// each. Errors name file and line.
Result<std::vector<ReferencePoint>> ReadReferencePoints(const std::string& path);
Status WriteReferencePoints(std::span<const ReferencePoint> points, const std::string& path);

}  // namespace isolux
