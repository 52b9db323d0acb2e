#include "common/scene/surface_maps.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

// Of a surface that no map varies.
Optics Even(const Surface& surface) {
  Optics optics;
  optics.reflectance = surface.reflectance;
  optics.exitance = surface.exitance;
  return optics;
}

double Dot(const std::array<double, 4>& row, const Vec3& p) {
  return row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
}

void Apply(const TextureMoments& moments, Rgb* value, Rgb* deviation) {
  for (int c = 0; c < 3; ++c) {
    const double variance = moments.square[c] - moments.mean[c] * moments.mean[c];
    (*deviation)[c] = (*value)[c] * std::sqrt(std::max(0.0, variance));
    (*value)[c] *= std::max(0.0, moments.mean[c]);
  }
}

}  // namespace

SurfaceMaps::SurfaceMaps(const Scene& scene) : scene_(&scene) {
  for (const Texture& texture : scene.textures) {
    textures_.emplace_back(texture);
    largest_.push_back(LargestTexel(texture));
    bool coloured = false;
    for (size_t i = 0; i < texture.texels.size(); i += 3) {
      const float* texel = &texture.texels[i];
      coloured = coloured || texel[0] != texel[1] || texel[1] != texel[2];
    }
    coloured_.push_back(coloured);
  }
}

double SurfaceMaps::Largest(const Surface& surface) const {
  if (!Varies(surface.polygon) || Sum(surface.reflectance) == 0) {
    return std::max({surface.reflectance.x, surface.reflectance.y, surface.reflectance.z});
  }
  const Material& material = scene_->materials[scene_->polygons[surface.polygon].material];
  const uint32_t texture = material.reflectance_map.texture;
  const Rgb most = material.reflectance * (texture == kNoTexture ? Rgb(1.0) : largest_[texture]);
  return std::max({most.x, most.y, most.z});
}

bool SurfaceMaps::TintsReflectance(const Surface& surface) const {
  if (!Varies(surface.polygon)) return false;
  const Polygon& polygon = scene_->polygons[surface.polygon];
  const uint32_t texture = scene_->materials[polygon.material].reflectance_map.texture;
  return texture != kNoTexture && coloured_[texture];
}

bool SurfaceMaps::TintsExitance(const Surface& surface) const {
  if (!Varies(surface.polygon)) return false;
  const Polygon& polygon = scene_->polygons[surface.polygon];
  const uint32_t texture = scene_->materials[polygon.material].exitance_map.texture;
  return texture != kNoTexture && coloured_[texture];
}

bool SurfaceMaps::VariesReflectance(uint32_t polygon) const {
  const Material& material = scene_->materials[scene_->polygons[polygon].material];
  return Varies(polygon) && material.reflectance_map.texture != kNoTexture;
}

bool SurfaceMaps::Varies(uint32_t polygon) const {
  if (textures_.empty() || scene_->polygons[polygon].coordinates == kNoCoordinates) return false;
  const Material& material = scene_->materials[scene_->polygons[polygon].material];
  return material.reflectance_map.texture != kNoTexture ||
         material.exitance_map.texture != kNoTexture;
}

TextureMoments SurfaceMaps::Moments(const TextureUse& use, const TextureCoordinates& coordinates,
                                    const ConvexPolygon& part) const {
  const TextureIntegral& texture = textures_[use.texture];
  std::array<TexturePoint, 4> corners;
  for (int i = 0; i < part.count; ++i) {
    const double u = Dot(coordinates.u, part.v[i]), v = Dot(coordinates.v, part.v[i]);
    const auto& t = use.transform;
    corners[i] = {texture.width() * (t[0] * u + t[1] * v + t[2]),
                  texture.height() * (t[3] * u + t[4] * v + t[5])};
  }
  return texture.Over(std::span(corners).first(part.count));
}

Optics SurfaceMaps::Over(const Surface& surface, const ConvexPolygon& part) const {
  if (!Varies(surface.polygon)) return Even(surface);
  const Polygon& polygon = scene_->polygons[surface.polygon];
  const Material& material = scene_->materials[polygon.material];
  const TextureCoordinates& coordinates = scene_->coordinates[polygon.coordinates];
  const bool front = surface.side == Side::kFront;
  const bool reflects = (polygon.sides & (front ? kFrontTakesPart : kBackTakesPart)) != 0;
  const bool emits = (polygon.sides & (front ? kFrontEmits : kBackEmits)) != 0;
  Optics optics;
  if (reflects) optics.reflectance = material.reflectance;
  const bool by_mean = !follows_reflectance_ && material.reflectance_map.texture != kNoTexture;
  if (by_mean) optics.reflectance = surface.reflectance;
  if (emits) optics.exitance = material.exitance;
  if (reflects && !by_mean && material.reflectance_map.texture != kNoTexture) {
    Apply(Moments(material.reflectance_map, coordinates, part), &optics.reflectance,
          &optics.reflectance_deviation);
  }
  if (emits && material.exitance_map.texture != kNoTexture) {
    Apply(Moments(material.exitance_map, coordinates, part), &optics.exitance,
          &optics.exitance_deviation);
  }
  return optics;
}

Optics SurfaceMaps::AtCorner(const Surface& surface, const ConvexPolygon& part, int corner) const {
  if (!Varies(surface.polygon)) return Even(surface);
  ConvexPolygon quarter = part;
  for (int i = 0; i < part.count; ++i) quarter.v[i] = 0.5 * (part.v[i] + part.v[corner]);
  return Over(surface, quarter);
}

}  // namespace isolux
