// From the polygons of a file to those that transport wants: merged where a modeller's tessellation
// says nothing, cut where things touch and pass through each other, and blind on sides that are
// covered.
#pragma once

#include <functional>
#include <string>

#include "client/import/repair.h"
#include "common/scene/scene.h"

namespace isolux {

// Changes the polygons of the scene, and counts what it does. `line_of(file polygon)` names the
// place of a polygon in the file, for the log.
void PrepareForTransport(Scene* scene, RepairLog* log,
                         const std::function<std::string(uint32_t)>& line_of);

}  // namespace isolux
