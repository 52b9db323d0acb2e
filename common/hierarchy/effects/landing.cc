#include "common/hierarchy/effects/landing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/scene_rays.h"
#include "common/hierarchy/panes.h"

namespace isolux {
namespace {

constexpr int kRays = 512;
constexpr uint64_t kSeed = 0x1a4d;

}  // namespace

double LandingPower(const Hierarchy& hierarchy) {
  if (hierarchy.scene().polygons.size() > SceneRays::kMostPolygons) return 0;
  std::vector<double> until;  // power of the surfaces up to each
  double power_w = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    power_w += hierarchy.surface_area_m2(s) * Sum(hierarchy.surfaces()[s].exitance);
    until.push_back(power_w);
  }
  if (!(power_w > 0)) return 0;
  const SceneRays rays(hierarchy);
  Random random(kSeed);
  double landed = 0;  // rays, each by what panes of glass leave of it
  std::optional<Panes> panes;
  const Glazing& glazing = hierarchy.scene().glazing;
  if (glazing.exists()) panes.emplace(glazing, hierarchy.extent_m(), false);
  for (int i = 0; i < kRays; ++i) {
    const double at = (i + random.Unit()) / kRays * power_w;
    const auto lamp = std::min<size_t>(
        static_cast<size_t>(std::upper_bound(until.begin(), until.end(), at) - until.begin()),
        until.size() - 1);
    const SceneRay ray = RayFrom(hierarchy, static_cast<uint32_t>(lamp), random);
    const SceneRays::Met met = rays.Meet(ray);
    if (!met.lands) continue;
    const Rgb left =
        panes ? panes->Along(ray.from, ray.from + met.distance * ray.direction) : Rgb(1.0);
    landed += std::min({left.x, left.y, left.z});
  }
  const double share = (landed + 0.5) / (kRays + 1);
  // A medium takes no more than over the longest way.
  const double arrives =
      ExpOfMinus(hierarchy.scene().medium.largest_per_m() * hierarchy.extent_m());
  return arrives * power_w * std::max(0.0, share - 3 * std::sqrt(share * (1 - share) / kRays));
}

double LargestShareOfLight(const Hierarchy& hierarchy, double area_m2) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const Scene& scene = hierarchy.scene();
  const bool from_maps = std::ranges::any_of(
      scene.materials, [](const Material& m) { return m.exitance_map.texture != kNoTexture; });
  if (!scene.lights.empty() || scene.sky.exists() || from_maps) return kUnknown;
  const double landing_w = LandingPower(hierarchy);
  if (!(landing_w > 0)) return kUnknown;
  Rgb brightest(0.0);
  for (const Surface& surface : hierarchy.surfaces()) {
    brightest = glm::max(brightest, surface.exitance);
  }
  return area_m2 * Sum(brightest) / (1 - LargestAlbedo(hierarchy)) / landing_w;
}

}  // namespace isolux
