#include "common/hierarchy/mirrors.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/landing.h"
#include "common/hierarchy/effects/scene_rays.h"

namespace isolux {
namespace {

// Rays that tell what images that are left out would have brought, and what is left of their light
// in the end.
constexpr int kRays = 512;
constexpr double kLeastLight = 1e-3;
constexpr uint64_t kSeed = 0x311e;

// Without mirrors H' = F(E + ρH'), with them H = F(E + ρH) + S, and S brings what they reflect:
// Σ A S = P = Σ k_s A H over the mirrors. So Σ A(H − H') ≤ P/(1 − α_max). P is at most k_s of all
// light; and no more than k_s times their area times the brightest that shines on them,
// E_max/(1 − α_max), since a mirror brightens nothing; and Σ A H is no less than what lands
// straight from the lamps.
double BoundOf(const Hierarchy& hierarchy, std::span<const MirrorPlane> planes) {
  const double rest = 1 - LargestAlbedo(hierarchy);
  double largest = 0, reflecting_m2 = 0;
  for (const MirrorPlane& plane : planes) {
    largest = std::max(largest, plane.share);
    reflecting_m2 += plane.share * plane.area_m2;
  }
  return std::min(largest, LargestShareOfLight(hierarchy, reflecting_m2)) / rest;
}

// Of the light of a ray, what goes by way of images that are left out and lands.
double LostOf(const SceneRays& rays, const Mirrors& mirrors, const Hierarchy& hierarchy,
              SceneRay ray) {
  std::vector<uint32_t> planes;
  double light = 1, lost = 0;
  while (light > kLeastLight) {
    const SceneRays::Met met = rays.Meet(ray);
    if (!met.lands) break;
    const double share = mirrors.ShareOf(met.polygon, met.side);
    if (!planes.empty() && !mirrors.Has(planes)) lost += light * (1 - share);
    if (share == 0) break;
    light *= share;
    planes.push_back(mirrors.PlaneOf(met.polygon, met.side));
    const Vec3 normal = SideGeometry(hierarchy.scene(), met.polygon, met.side).Normal();
    ray.from += met.distance * ray.direction;
    ray.direction -= 2 * glm::dot(normal, ray.direction) * normal;
    ray.polygon = met.polygon;
  }
  return lost;
}

// The same of all light that leaves surfaces, evenly over their area or, where that is more, over
// what they emit; three standard deviations above what rays say.
double LostShare(const Hierarchy& hierarchy, const Mirrors& mirrors) {
  const SceneRays rays(hierarchy);
  double most = 0;
  for (const bool emitted : {false, true}) {
    std::vector<double> until;
    double all = 0;
    for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
      const Surface& surface = hierarchy.surfaces()[s];
      const double weight =
          emitted ? Sum(surface.exitance) : 1 - mirrors.ShareOf(surface.polygon, surface.side);
      until.push_back(all += hierarchy.surface_area_m2(s) * weight);
    }
    if (!(all > 0)) continue;
    Random random(kSeed);
    double sum = 0, squares = 0;
    for (int i = 0; i < kRays; ++i) {
      const double at = (i + random.Unit()) / kRays * all;
      const auto from = std::min<size_t>(
          static_cast<size_t>(std::upper_bound(until.begin(), until.end(), at) - until.begin()),
          until.size() - 1);
      const double lost =
          LostOf(rays, mirrors, hierarchy, RayFrom(hierarchy, static_cast<uint32_t>(from), random));
      sum += lost;
      squares += lost * lost;
    }
    const double mean = sum / kRays;
    most =
        std::max(most, mean + 3 * std::sqrt(std::max(0.0, squares / kRays - mean * mean) / kRays));
  }
  return most;
}

// Images for which there is no room.
std::string WhatIsLeftOut(const Hierarchy& hierarchy, double accuracy) {
  const Mirrors mirrors(hierarchy, accuracy);
  if (!(mirrors.missing() > 0)) return {};
  const std::string text = fmt::format("; images beyond {} are left out", mirrors.images().size());
  if (hierarchy.scene().polygons.size() > SceneRays::kMostPolygons) return text;
  return text + fmt::format(": {:.2g} of all light at most", LostShare(hierarchy, mirrors));
}

}  // namespace

Effect DetectMirrors(const Hierarchy& hierarchy, double accuracy) {
  const std::vector<MirrorPlane> planes = MirrorPlanesOf(hierarchy);
  Effect replaced = DetectReplacedMirrors(hierarchy.scene());
  if (planes.empty()) {
    if (replaced.present) return replaced;
    replaced.support = Support::kSwitchable;
    return replaced;
  }
  Effect effect{.name = "mirrors", .present = true};
  double area_m2 = 0, largest = 0;
  for (const MirrorPlane& plane : planes) {
    area_m2 += plane.area_m2;
    largest = std::max(largest, plane.share);
  }
  effect.evidence = fmt::format("{:.4g} m² in {} plane{} reflect up to {:.3g} as mirrors", area_m2,
                                planes.size(), planes.size() == 1 ? "" : "s", largest);
  effect.bound = BoundOf(hierarchy, planes);
  if (planes.size() > Mirrors::kMostPlanes) {
    effect.support = Support::kNotSimulated;
    effect.reason =
        fmt::format("more than {} planes: taken as diffuse, with Kd", Mirrors::kMostPlanes);
  } else {
    effect.evidence += WhatIsLeftOut(hierarchy, accuracy);
  }
  return effect;
}

}  // namespace isolux
