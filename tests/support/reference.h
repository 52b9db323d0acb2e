// An independent solution to compare with: a dense collocation solve on a fixed mesh, with exact
// point-to-polygon form factors and many shadow rays, none of it shared with the solver (no
// hierarchy, no links, no Embree). Slow; for scenes of a few dozen polygons.
#pragma once

#include <vector>

#include "common/scene/scene.h"
#include "common/util/parallel.h"

namespace isolux::testing {

class DenseReference {
 public:
  // Divides the surfaces into about `patches` patches and solves B = E + ρH for them, with this
  // many shadow rays a pair.
  DenseReference(const Scene& scene, int patches, int rays, ThreadPool& pool);

  // Irradiance at a point of a surface, W/m², from all patches with `rays` shadow rays each.
  Rgb IrradianceAt(uint32_t surface, const Vec3& point, int rays, uint64_t seed) const;

  size_t size() const { return patches_.size(); }

 private:
  struct Patch {
    uint32_t surface = 0;
    ConvexPolygon polygon;
    Vec3 centre{0.0};
    double area_m2 = 0;
    Rgb radiosity{0.0};
  };
  double Visibility(const Vec3& from, uint32_t from_polygon, const Patch& to, int rays,
                    uint64_t seed) const;
  bool Blocked(const Vec3& from, const Vec3& to, uint32_t from_polygon, uint32_t to_polygon) const;
  double FormFactor(const Vec3& point, const Vec3& normal, const Patch& patch) const;

  const Scene& scene_;
  std::vector<Surface> surfaces_;
  std::vector<Patch> patches_;
};

}  // namespace isolux::testing
