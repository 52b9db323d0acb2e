// The sky of isolux.json: models, and maps from images, all made into texels (common/scene/sky.h).
#pragma once

#include <string>

#include "client/import/json_element.h"
#include "common/scene/sky.h"

namespace isolux {

// Of an object with a "type": constant, gradient, cie_overcast, cie_clear, map. Images are looked
// for in `folder` and below.
Result<Sky> ReadSky(const JsonElement& element, const std::string& folder);

// An equirectangular image as texels: `pixels` row by row from the zenith down, three channels a
// pixel; what is in the middle lies ahead, what is to the right of it goes right.
Sky FromEquirectangular(const std::vector<float>& pixels, uint32_t width, uint32_t height);

}  // namespace isolux
