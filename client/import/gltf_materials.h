// The materials of a glTF document as diffuse ones, and which images they need.
#pragma once

#include <vector>

#include "client/import/gltf_document.h"
#include "client/import/scene_file.h"

namespace isolux {

// One for each material of the document. The encoded images that they name go to `images`, as many
// as the document has and an empty one for textures whose format is not read.
//
// Metallic-roughness: the reflectance is baseColorFactor · baseColorTexture · (1 − metallic).
// KHR_materials_pbrSpecularGlossiness, where given: diffuseFactor · diffuseTexture. Either is
// lowered by 1 − transmission (KHR_materials_transmission). The radiance is emissiveFactor ·
// emissiveTexture · emissiveStrength, in W/(m² sr).
Result<std::vector<FileMaterial>> ReadGltfMaterials(const GltfDocument& document,
                                                    std::vector<std::string>* images);

}  // namespace isolux
