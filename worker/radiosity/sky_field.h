// Irradiance from the sky at a point: rays over its hemisphere, past obstacles, and more of them
// where what they see changes from one to the next, as at the sides of windows.
#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/mirrors.h"
#include "common/hierarchy/panes.h"
#include "common/scene/scene.h"
#include "worker/radiosity/medium_in_box.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {

// Where irradiance is wanted.
struct LitPoint {
  Vec3 position{0.0}, normal{0.0};  // of length 1
  uint32_t polygon = 0;
  uint64_t seed = 0;
};

// Through which directions points of an element may see the sky: cells of a grid over the square
// that stands for the hemisphere, as far as rays from all over the element have found out.
struct SkyOpenings {
  int cells = 0;                  // a side
  std::vector<uint8_t> possible;  // row by row
  uint32_t rays = 0;              // that it took
};

class SkyField {
 public:
  struct Seen {
    Rgb irradiance{0.0};
    double deviation = 0;  // expected error, summed over the channels, W/m²
    uint32_t rays = 0;
  };

  // Keeps references; without obstacles, and so without mirrors, where `shadows` is false.
  // medium, panes: null where there are none.
  SkyField(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors, double far_m,
           bool shadows, const MediumInBox* medium, const Panes* panes);

  // Of an element drawn in from its sides (polygon_sampler.h): by a ray through each of `cells`
  // times `cells`, which are joined where many see the sky.
  SkyOpenings OpeningsOf(const ConvexPolygon& inside, const LitPoint& any, int cells) const;
  // At a point of that element: a ray through each cell that may see it; cells at borders are
  // divided into four until `finest` fit a side. Cells have equal shares of the hemisphere's
  // projection, so the even and open sky of radiance L gives π L.
  Seen At(const LitPoint& point, const SkyOpenings& openings, int finest) const;

 private:
  class Hemisphere;

  const Hierarchy& hierarchy_;
  const Sky& sky_;
  const RayScene& rays_;
  const Mirrors& mirrors_;
  double far_m_;
  bool shadows_;
  const MediumInBox* medium_;
  const Panes* panes_;
};

}  // namespace isolux
