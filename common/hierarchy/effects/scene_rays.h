// Rays against every polygon of a scene, for what effects need to know before there is a worker.
#pragma once

#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/util/random.h"

namespace isolux {

struct SceneRay {
  Vec3 from{0.0}, direction{0.0};  // of length 1
  uint32_t polygon = 0;            // that it leaves; neither it nor any in its plane is met
};

// A cosine-distributed ray from a uniform point of a surface.
SceneRay RayFrom(const Hierarchy& hierarchy, uint32_t surface, Random& random);

class SceneRays {
 public:
  static constexpr size_t kMostPolygons = 50'000;  // more would take long: each ray meets them all
  static constexpr uint32_t kNothing = 0xffffffffu;

  // Keeps a reference.
  explicit SceneRays(const Hierarchy& hierarchy);

  struct Met {
    uint32_t polygon = kNothing;
    Side side = Side::kFront;
    bool lands = false;   // on a side that takes part
    double distance = 0;  // m
  };
  // What the ray meets first.
  Met Meet(const SceneRay& ray) const;

 private:
  const Hierarchy& hierarchy_;
  std::vector<ConvexPolygon> shapes_;
  std::vector<Vec3> normals_;
};

}  // namespace isolux
