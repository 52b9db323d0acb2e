// Reflectance and exitance over parts of a scene's surfaces, where maps vary them: a pure function
// of the scene, the surface and the part.
#pragma once

#include <vector>

#include "common/scene/scene.h"
#include "common/scene/texture.h"

namespace isolux {

// Means over a part of a surface, and the root mean square deviations from them.
struct Optics {
  Rgb reflectance{0.0};
  Rgb exitance{0.0};  // W/m²
  Rgb reflectance_deviation{0.0};
  Rgb exitance_deviation{0.0};
};

class SurfaceMaps {
 public:
  // Keeps a pointer to the scene: it must outlive the maps.
  explicit SurfaceMaps(const Scene& scene);

  // Whether reflectance is that of the maps, as it is at first, or of the surface throughout.
  void FollowReflectance(bool follow) { follows_reflectance_ = follow; }
  bool follows_reflectance() const { return follows_reflectance_; }

  // Whether anything varies over the polygon, in the scene; and whether its reflectance does.
  bool Varies(uint32_t polygon) const;
  bool VariesReflectance(uint32_t polygon) const;
  // Largest reflectance that any texel of its texture gives a surface.
  double Largest(const Surface& surface) const;
  // Whether a texture gives a surface's reflectance or exitance other colours than their mean has.
  bool TintsReflectance(const Surface& surface) const;
  bool TintsExitance(const Surface& surface) const;
  // Over a part of the surface: any polygon that lies on it. Of a surface that is even these are
  // its own values.
  Optics Over(const Surface& surface, const ConvexPolygon& part) const;
  // About a corner of a part: over the quarter of it next to the corner.
  Optics AtCorner(const Surface& surface, const ConvexPolygon& part, int corner) const;

 private:
  TextureMoments Moments(const TextureUse& use, const TextureCoordinates& coordinates,
                         const ConvexPolygon& part) const;

  const Scene* scene_;
  bool follows_reflectance_ = true;
  std::vector<TextureIntegral> textures_;
  std::vector<Rgb> largest_;    // texel of each texture
  std::vector<bool> coloured_;  // textures whose channels differ
};

}  // namespace isolux
