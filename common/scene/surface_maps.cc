#include "common/scene/surface_maps.h"

#include <algorithm>
#include <cmath>
#include <span>

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

TexturePoint Minus(const TexturePoint& a, const TexturePoint& b) { return {a.x - b.x, a.y - b.y}; }

double AreaOf(std::span<const TexturePoint> corners) {
  double twice = 0;
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    const TexturePoint a = Minus(corners[i], corners[0]), b = Minus(corners[i + 1], corners[0]);
    twice += a.x * b.y - a.y * b.x;
  }
  return 0.5 * std::abs(twice);
}

// Where all of a part lies on a line in the image, as on the strips of palettes and gradients, it
// becomes a ribbon a millionth of a texel wide: an area to integrate over, in which every stretch
// of the line counts by what of the part lies there.
void WidenLine(const ConvexPolygon& part, std::span<TexturePoint> corners) {
  TexturePoint along{};
  double length = 0;
  for (const TexturePoint& corner : corners) {
    const TexturePoint d = Minus(corner, corners[0]);
    if (std::hypot(d.x, d.y) <= length) continue;
    along = d;
    length = std::hypot(d.x, d.y);
  }
  if (!(length > 0) || AreaOf(corners) > 1e-9 * length * length) return;
  // Across: the direction in which the part does not move along the line. By two sides that are not
  // one straight line.
  const auto side = [&](size_t i) { return part.v[i] - part.v[0]; };
  const auto on_line = [&](size_t i) {
    const TexturePoint d = Minus(corners[i], corners[0]);
    return (d.x * along.x + d.y * along.y) / length;
  };
  const size_t last = corners.size() - 1;
  const bool straight =
      glm::length(glm::cross(side(1), side(2))) < glm::length(glm::cross(side(1), side(last)));
  const size_t other = straight ? last : 2;
  const Vec3 across = on_line(other) * side(1) - on_line(1) * side(other);
  double widest = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    widest = std::max(widest, std::abs(glm::dot(side(i), across)));
  }
  if (!(widest > 0)) return;
  constexpr double kWidth = 1e-6;
  for (size_t i = 0; i < corners.size(); ++i) {
    const double offset = kWidth * glm::dot(side(i), across) / widest / length;
    corners[i] = {corners[i].x - offset * along.y, corners[i].y + offset * along.x};
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
  const std::span of_part = std::span(corners).first(part.count);
  WidenLine(part, of_part);
  return texture.Over(of_part);
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
