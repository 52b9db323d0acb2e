// Lights of a glTF scene: KHR_lights_punctual at its nodes.
#pragma once

#include <vector>

#include "client/import/gltf_document.h"
#include "client/import/gltf_nodes.h"
#include "common/scene/light.h"

namespace isolux {

// One for each node that carries a light, with positions in the file's unit. Candela and lux are
// taken as they are, like the nits of emissive materials. Errors name the node and the light.
Result<std::vector<Light>> ReadGltfLights(const GltfDocument& document, const GltfNodes& nodes);

}  // namespace isolux
