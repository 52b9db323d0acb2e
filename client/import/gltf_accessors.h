// The numbers of glTF accessors, with every range checked: buffer views, strides, sparse
// replacements, normalised integers.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "client/import/gltf_document.h"
#include "common/vec.h"

namespace isolux {

// The bytes of a buffer view.
Result<std::span<const uint8_t>> BytesOfView(const GltfDocument& document, int view);

// Points (VEC3 of floats or, with KHR_mesh_quantization, of integers), all finite. More than `most`
// are refused before memory is taken.
Result<std::vector<Vec3>> ReadPoints(const GltfDocument& document, int accessor, uint64_t most);

// Texture coordinates (VEC2 of floats or normalised integers). More than `most` are refused before
// memory is taken.
Result<std::vector<glm::dvec2>> ReadCoordinates(const GltfDocument& document, int accessor,
                                                uint64_t most);

// Indices (unsigned SCALAR) of a primitive. More than `most` are refused before memory is taken.
Result<std::vector<uint32_t>> ReadIndices(const GltfDocument& document, int accessor,
                                          uint64_t most);

}  // namespace isolux
