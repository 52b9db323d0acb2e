// Lights: what brings light to a scene without being one of its polygons. A point radiates by
// direction; a directional light is so far away that it is the same everywhere.
//
// Powers are in the unit of the file's other emission: W where a material's emission is in
// W/(m² sr), lm where it is in cd/m².
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/scene/photometry.h"
#include "common/util/bytes.h"
#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

enum class LightKind : uint8_t { kPoint = 0, kSpot = 1, kDirectional = 2, kPhotometric = 3 };

struct Light {
  std::string name;
  LightKind kind = LightKind::kPoint;
  Vec3 position_m{0.0};        // relative to Scene::origin_m; not of directional lights
  Vec3 direction{0.0, 0, -1};  // in which the light goes, of length 1; not of points
  Rgb intensity{0.0};          // W/sr along the direction; of a directional light W/m² across it
  double cosine_full = 1;      // of a spot: up to this angle from its axis its intensity is whole,
  double cosine_none = 0;      // and 0 from this larger angle on (KHR_lights_punctual)
  // Of a directional light that is a disc, as the sun: half its diameter over its distance. Its
  // intensity is of the whole disc.
  double disc_radius = 0;
  // Of a photometric light: its table (Scene::photometries), which `intensity` is multiplied with,
  // the direction being its axis; and where its angles around the axis begin, across it.
  uint32_t photometry = 0;
  Vec3 ahead{1.0, 0, 0};

  bool is_sun() const { return disc_radius > 0; }

  bool operator==(const Light&) const = default;
};

// W/sr in a direction (of length 1) away from a point, spot or photometric light.
// `photometries`: of its scene.
Rgb IntensityTowards(const Light& light, std::span<const Photometry> photometries,
                     const Vec3& direction);
// No less in any direction.
Rgb LargestIntensity(const Light& light, std::span<const Photometry> photometries);

// Power of a point, spot or photometric light in all directions, W; not of directional lights,
// whose light has no end.
Rgb PowerOf(const Light& light, std::span<const Photometry> photometries);

// Whether kinds, vectors and numbers are in range. `number` stands in the message.
Status CheckLight(const Light& light, std::span<const Photometry> photometries, size_t number);

// A light as part of an encoded scene.
void Put(ByteWriter& out, const Light& light);
Light GetLight(ByteReader& in);
inline constexpr uint64_t kLeastLightBytes = 4 + 1 + 15 * 8 + 4;

}  // namespace isolux
