// What lights that are no polygons bring straight to surfaces: the irradiance H0 in
// H = F(E + ρH) + H0, at points and as means over elements, past obstacles.
//
// All of it is a pure function of the scene, the element or point, and a seed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/hierarchy/mirrors.h"
#include "common/scene/effect_costs.h"
#include "common/scene/effects_plan.h"
#include "common/scene/scene.h"
#include "worker/radiosity/disc_grid.h"
#include "worker/radiosity/escape.h"
#include "worker/radiosity/medium_in_box.h"
#include "worker/radiosity/sky_field.h"

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
  LightRays rays;  // that it took
};

class LightField {
 public:
  // Of the lights that the plan wants, and their images in mirrors. Keeps references; without
  // obstacles where the plan says so. The sky is not looked for where the scout has found a closed
  // component. `medium`, `panes`: null where there are none. `accuracy`: of the output, which says
  // how closely to look at the sky.
  LightField(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
             const Scout& scout, const EffectsPlan& plan, const Medium* medium, const Panes* panes,
             double accuracy, uint64_t seed);

  // No less than what all lights bring without obstacles, W.
  Rgb power_w() const { return power_w_; }

  // Over an element of a surface. Of a point alike in all directions and of a directional light the
  // mean without obstacles is exact.
  GivenIrradiance Over(const NodeId& id, const ConvexPolygon& polygon) const;
  // Without looking closely, for a first guess: of the sky what the scout says escapes.
  GivenIrradiance OverSurface(uint32_t surface) const;
  // No less than what any element gets, were all of it as bright as its brightest point, W.
  double MostPower(const NodeId& id, const ConvexPolygon& polygon) const;

  // Where points of an element are to look for the sky; empty where there is none to see.
  SkyOpenings OpeningsOf(const NodeId& id, const ConvexPolygon& polygon) const;
  // At a point of that element.
  Rgb At(const LitPoint& point, const SkyOpenings& openings, LightRays* rays) const;

 private:
  // A light, and two directions across it; or, where `image` is not null, the image of one, with
  // what the mirrors leave of its intensity, and the light itself.
  struct Source {
    Light light;
    Vec3 side{0.0}, across{0.0};
    const MirrorImage* image = nullptr;
    Light original = {};
    std::vector<uint32_t> lights_up = {};  // closed components that it is in
  };
  struct Arrival;
  struct LeftRange;
  struct Samples;
  struct Look;
  // Of one light over an element, W/m² summed over the channels.
  struct Doubt {
    double unoccluded, share;  // its mean without obstacles, and how much of that arrives
    double range, most;        // without obstacles
    bool reaches, is_hidden;   // somewhere
    bool uneven;               // whether its intensity varies by direction
    bool may_be_hidden;        // from some points
  };

  Arrival ArrivalAt(const Source& source, const Vec3& point, const Vec3& normal,
                    const std::array<double, 2>& disc) const;
  void AddSource(const Light& light, const MirrorImage* image, std::vector<uint32_t> lights_up);
  // Whether the light is outside of the closed component that the surface is in.
  bool IsShutOut(const Source& source, uint32_t surface) const;
  Rgb LeftByPanes(const Source& source, const Vec3& point, const Vec3& from) const;
  Rgb LeftFromOutside(const Source& source, const Vec3& point) const;
  Rgb Intensity(const Source& source, const Vec3& direction) const;
  // The bits of the rays to a source that arrive.
  uint32_t Reaches(const Source& source, const RayPacket& packet) const;
  bool MayBeHidden(const Source& source) const { return shadows_ || source.image != nullptr; }
  Look LookAt(const Source& source, const Samples& samples, uint32_t polygon,
              std::span<const Vec3> points, size_t first) const;
  double AreaShare(const ConvexPolygon& polygon) const;
  uint32_t FreeOf(size_t first, const RayPacket& packet) const;
  Rgb FromSun(const Source& sun, const LitPoint& point, LightRays* rays) const;
  void LookAtDisc(const Source& sun, const LitPoint& point, std::span<const uint32_t> cells,
                  DiscGrid* grid) const;
  double UnoccludedRange(const Source& source, const ConvexPolygon& inside, const Vec3& normal,
                         double least, double most) const;
  GivenIrradiance FromLights(const NodeId& id, const ConvexPolygon& polygon,
                             const Samples& samples) const;
  void AddSky(const NodeId& id, const Samples& samples, GivenIrradiance* sum) const;
  void AddDoubt(const Doubt& doubt, GivenIrradiance* sum) const;
  void AddLight(const Source& source, const NodeId& id, const ConvexPolygon& polygon,
                const Samples& samples, GivenIrradiance* sum) const;

  const Hierarchy& hierarchy_;
  const RayScene& rays_;
  const Mirrors& mirrors_;
  const Scout& scout_;
  bool shadows_;
  uint64_t seed_;
  double far_m_;  // beyond all of the scene
  std::optional<MediumInBox> medium_;
  const Panes* panes_;
  std::vector<Source> lights_, suns_;  // those without a disc, those with one
  std::optional<SkyField> sky_;
  std::vector<uint8_t> sees_sky_;  // of surfaces: whether light leaves their component
  std::vector<float> escape_;      // of surfaces: share of their light that does
  Rgb brightest_sky_{0.0};
  int finest_;     // cells a side of the hemisphere, at points of the output
  int sun_cells_;  // and of a sun's disc, where its light is partly hidden
  Rgb power_w_{0.0};
};

}  // namespace isolux
