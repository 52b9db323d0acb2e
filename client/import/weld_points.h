// Points of a file that are one in truth, though printing or arithmetic has moved them apart.
#pragma once

#include <cstdint>
#include <vector>

#include "client/import/scene_file.h"

namespace isolux {

// Joins vertices nearer than 1e-6 of the extent of all, and than a thousandth of the shortest side
// at either, to the lowest numbered: measured to that one, so that chains do not run together.
// `vertex_of` maps the points of the file to the vertices and follows them. Returns how many were
// joined.
uint64_t JoinNearPoints(const SceneFile& file, std::vector<uint32_t>* vertex_of,
                        std::vector<Vec3>* vertices);

}  // namespace isolux
