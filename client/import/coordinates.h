// Texture coordinates of polygons as affine maps, from those of their corners.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

// The affine map over a polygon that takes its corners to these texture coordinates; nothing where
// they are not finite, too far out, or (of a quad) no affine map does so. A map that leaves out a
// direction of the polygon is given a hair of it, so that means over parts stay additive.
std::optional<TextureCoordinates> FitCoordinates(const ConvexPolygon& shape,
                                                 std::span<const glm::dvec2> corners);

// Whether the images of a material repeat few enough times over the polygon to be followed.
bool IsUsable(const ConvexPolygon& shape, const TextureCoordinates& coordinates,
              const Material& material);

// Gives polygons of one plane, material and set of sides whose maps agree on both the same number,
// so that they may be merged.
void UnifyCoordinates(Scene* scene, const std::vector<uint32_t>& plane_of);

}  // namespace isolux
