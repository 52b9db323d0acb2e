// Light that comes from no polygon: points, spots, directions, the sun, the sky.
#include <algorithm>
#include <numbers>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/landing.h"

namespace isolux {

// What a light brings without obstacles: of points and spots no more than all of their power, of
// directional lights what falls on sides that face them.
Rgb BroughtPower(const Hierarchy& hierarchy, const Light& light) {
  if (light.kind != LightKind::kDirectional) return PowerOf(light, hierarchy.scene().photometries);
  double across_m2 = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const double cosine = -glm::dot(hierarchy.geometry(s).Normal(), light.direction);
    across_m2 += hierarchy.surface_area_m2(s) * std::max(0.0, cosine);
  }
  return across_m2 * light.intensity;
}

bool ShinesFromOutside(const Hierarchy& hierarchy, const Light& light) {
  if (light.kind == LightKind::kDirectional) return true;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const ConvexPolygon& polygon = hierarchy.geometry(s);
    if (glm::dot(polygon.Normal(), light.position_m - polygon.v[0]) < 0) return true;
  }
  return false;
}

Rgb SkyPower(const Hierarchy& hierarchy) {
  const Sky& sky = hierarchy.scene().sky;
  return std::numbers::pi * hierarchy.clusters()[0].area_m2 * sky.MeanRadiance();
}

namespace {

// What such power adds to Σ A H with all its bounces is at most power/(1 − α_max), with α the
// share that a surface reflects and passes on, and Σ A H is no
// less than what lands straight from the lamps. Nothing where no lamp is known to light anything.
std::optional<double> BoundOf(const Hierarchy& hierarchy, double power_w) {
  const double landing_w = LandingPower(hierarchy);
  if (!(landing_w > 0)) return {};
  return power_w / (1 - LargestAlbedo(hierarchy)) / landing_w;
}

// On a side no sky brings more than π times its brightest radiance, nor than all of its light.
double MostOfSky(const Hierarchy& hierarchy) {
  const Sky& sky = hierarchy.scene().sky;
  Rgb brightest(0.0);
  for (size_t i = 0; i < sky.texels.size(); i += 3) {
    brightest = glm::max(brightest, Rgb(sky.texels[i], sky.texels[i + 1], sky.texels[i + 2]));
  }
  const Rgb most = glm::min(brightest, 4.0 * sky.MeanRadiance());
  return std::numbers::pi * hierarchy.clusters()[0].area_m2 * Sum(most);
}

// The row of those lights that are suns, or those that are not.
Effect DetectOf(const Hierarchy& hierarchy, const char* name, bool suns) {
  std::vector<Light> lights;
  for (const Light& light : hierarchy.scene().lights) {
    if (light.is_sun() == suns) lights.push_back(light);
  }
  Effect effect{.name = name, .present = !lights.empty()};
  if (lights.empty()) {
    effect.evidence = suns ? "no sun" : "no light without area";
    effect.bound = 0.0;
    return effect;
  }
  Rgb power(0.0);
  for (const Light& light : lights) power += BroughtPower(hierarchy, light);
  effect.bound = BoundOf(hierarchy, Sum(power));
  const auto count = [&](LightKind kind) { return std::ranges::count(lights, kind, &Light::kind); };
  if (suns) {
    effect.evidence = fmt::format("suns: {}; {:.4g} W at most", lights.size(), Sum(power));
    return effect;
  }
  effect.evidence =
      fmt::format("points: {}, spots: {}, directions: {}, photometric: {}; {:.4g} W at most",
                  count(LightKind::kPoint), count(LightKind::kSpot), count(LightKind::kDirectional),
                  count(LightKind::kPhotometric), Sum(power));
  return effect;
}

}  // namespace

Effect DetectLights(const Hierarchy& hierarchy) { return DetectOf(hierarchy, "lights", false); }

Effect DetectSun(const Hierarchy& hierarchy) { return DetectOf(hierarchy, "sun", true); }

Effect DetectSky(const Hierarchy& hierarchy) {
  const Sky& sky = hierarchy.scene().sky;
  Effect effect{.name = "sky", .present = Sum(sky.MeanRadiance()) > 0};
  if (effect.present) {
    effect.evidence = fmt::format("{}, {} x {} texels; {:.4g} W where nothing hides it", sky.name,
                                  sky.columns, sky.rows, Sum(SkyPower(hierarchy)));
    effect.bound = BoundOf(hierarchy, MostOfSky(hierarchy));
  } else {
    effect.evidence = "no sky";
    effect.bound = 0.0;
  }
  return effect;
}

}  // namespace isolux
