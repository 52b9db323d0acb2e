// What lights that are no polygons bring straight to surfaces: the irradiance H0 in
// H = F(E + ρH) + H0, at points and as means over elements, past obstacles.
//
// All of it is a pure function of the scene, the element or point, and a seed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/effects_plan.h"
#include "common/scene/scene.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {

// Over an element, W/m².
struct GivenIrradiance {
  Rgb mean{0.0};
  // Summed over the channels: how far points of it differ, as far as one can tell, and what the
  // mean may be wrong by (standard deviation).
  double range = 0, error = 0;
  // Mean absolute error of the output over the element if it is a leaf: it is interpolated, and
  // borders of shadows are sharp.
  double border = 0;
  uint32_t rays = 0;  // that it took
};

// Where irradiance is wanted.
struct LitPoint {
  Vec3 position{0.0}, normal{0.0};  // of length 1
  uint32_t polygon = 0;
};

class LightField {
 public:
  // Of the lights that the plan wants. Keeps references; without obstacles where the plan says so.
  LightField(const Hierarchy& hierarchy, const RayScene& rays, const EffectsPlan& plan,
             uint64_t seed);

  // Whether there is any light.
  bool empty() const { return lights_.empty(); }
  // No less than what all lights bring without obstacles, W.
  Rgb power_w() const { return power_w_; }

  // Over an element of a surface. Of a point alike in all directions and of a directional light the
  // mean without obstacles is exact.
  GivenIrradiance Over(const NodeId& id, const ConvexPolygon& polygon) const;
  Rgb At(const LitPoint& point, uint64_t* rays) const;

 private:
  struct Samples;
  struct Look;
  // Of one light over an element, W/m² summed over the channels.
  struct Doubt {
    double unoccluded, share;  // its mean without obstacles, and how much of that arrives
    double range, most;        // without obstacles
    bool reaches, is_hidden;   // somewhere
    bool uneven;               // whether its intensity varies by direction
  };

  Look LookAt(const Light& light, const Vec3& normal, uint32_t polygon,
              std::span<const Vec3> points) const;
  void AddDoubt(const Doubt& doubt, GivenIrradiance* sum) const;
  void AddLight(const Light& light, const NodeId& id, const ConvexPolygon& polygon,
                const Samples& samples, GivenIrradiance* sum) const;

  const Hierarchy& hierarchy_;
  const RayScene& rays_;
  bool shadows_;
  uint64_t seed_;
  double far_m_;  // beyond all of the scene
  std::vector<Light> lights_;
  Rgb power_w_{0.0};
};

}  // namespace isolux
