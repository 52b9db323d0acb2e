#include "worker/radiosity/effect_shares.h"

#include <algorithm>

#include "common/util/stopwatch.h"
#include "worker/radiosity/visibility.h"

namespace isolux {
namespace {

constexpr size_t kSample = 128;  // links whose rays are cast once more

double Share(double part, double whole) { return whole > 0 ? part / whole : 0; }

}  // namespace

double MeanRaySeconds(const RefineScene& scene, const Tree& tree, const LinkSet& links,
                      const ThreadPool& pool) {
  const std::vector<Link>& from = links.own.empty() ? links.crown : links.own;
  if (!scene.occlusion || from.empty()) return 0;
  const size_t step = std::max<size_t>(1, from.size() / kSample);
  const Stopwatch watch(pool);
  uint64_t traced = 0;
  for (size_t i = 0; i < from.size(); i += step) {
    if (from[i].through_mirrors() || tree.is_cluster(from[i].p) || tree.is_cluster(from[i].q)) {
      continue;
    }
    traced += static_cast<uint64_t>(
        SampleVisibility(tree, *scene.rays, from[i].p, from[i].q, scene.seed).traced);
  }
  return Share(watch.cpu_s(), static_cast<double>(traced));
}

void AddRefineCosts(const RefineCounters& counters, double cpu_s, double ray_s,
                    EffectCosts& costs) {
  const double mirrors = Share(static_cast<double>(counters.image_evaluations),
                               static_cast<double>(counters.evaluations));
  EffectCost& of_mirrors = costs["mirrors"];
  of_mirrors.rays += counters.image_rays;
  of_mirrors.cpu_s += mirrors * cpu_s;
  EffectCost& occlusion = costs["occlusion"];
  occlusion.rays += counters.rays;
  occlusion.cpu_s += std::min(ray_s * static_cast<double>(counters.rays), (1 - mirrors) * cpu_s);
}

LightKinds KindsOf(const Scene& scene, const EffectsPlan& plan) {
  LightKinds kinds;
  for (const Light& light : scene.lights) (light.is_sun() ? kinds.sun : kinds.lights) = true;
  return {plan.lights && kinds.lights, plan.sun && kinds.sun, plan.sky && scene.sky.exists()};
}

void AddLightCosts(const LightKinds& kinds, const LightRays& rays, double cpu_s,
                   EffectCosts& costs) {
  const auto all = static_cast<double>(rays.Total());
  const int count = (kinds.lights ? 1 : 0) + (kinds.sun ? 1 : 0) + (kinds.sky ? 1 : 0);
  const auto add = [&](const char* name, bool shines, uint64_t of_it) {
    if (!shines) return;
    costs[name].rays += of_it;
    costs[name].cpu_s += cpu_s * (all > 0 ? static_cast<double>(of_it) / all : 1.0 / count);
  };
  add("lights", kinds.lights, rays.lights);
  add("sun", kinds.sun, rays.sun);
  add("sky", kinds.sky, rays.sky);
}

double ShareThroughMirrors(const LinkSet& links) {
  uint64_t through = 0;
  for (const std::vector<Link>* list : {&links.own, &links.crown}) {
    for (const Link& link : *list) through += link.through_mirrors() ? 1 : 0;
  }
  return Share(static_cast<double>(through),
               static_cast<double>(links.own.size() + links.crown.size()));
}

void AddSolveCosts(const SolveTimes& times, const EffectsPlan& plan, bool sheets, bool fluorescence,
                   EffectCosts& costs) {
  costs["textures"].cpu_s += times.maps_s;
  costs["closure"].cpu_s += times.closure_s;
  costs["medium"].cpu_s += times.medium_s;
  costs["clear-glass"].cpu_s += times.panes_s;
  costs["mirrors"].cpu_s += times.mirrors * times.solver_s;
  double left_s = (1 - times.mirrors) * times.solver_s;
  const double products = times.solver_products;
  if (plan.channels == 3 && times.closure_products > 0) {
    const double single_s = times.closure_s / times.closure_products;
    const double colour_s = std::max(0.0, left_s - products * single_s);
    costs["colour"].cpu_s += colour_s;
    left_s -= colour_s;
  }
  if (!(products > 0)) return;
  const double again_s = left_s * times.again / products;
  const double halves = sheets && fluorescence ? 0.5 : 1;
  if (sheets) costs["sheets"].cpu_s += halves * again_s;
  if (fluorescence) costs["fluorescence"].cpu_s += halves * again_s;
  const double further = products - times.again - 1;
  if (plan.interreflection) costs["interreflection"].cpu_s += left_s * further / products;
}

void AddGatherCosts(double cpu_s, double ray_s, double light_ray_s, EffectCosts& costs) {
  EffectCosts added;
  for (const char* name : {"occlusion", "mirrors"}) {
    added[name].cpu_s = ray_s * static_cast<double>(costs[name].rays);
  }
  for (const char* name : {"lights", "sun", "sky"}) {
    added[name].cpu_s = light_ray_s * static_cast<double>(costs[name].rays);
  }
  // Means from elsewhere may come to more than it took.
  const double all_s = added.Total().cpu_s;
  const double scale = all_s > cpu_s ? cpu_s / all_s : 1;
  for (size_t i = 0; i < EffectCosts::kCount; ++i) costs.at(i).cpu_s += scale * added.at(i).cpu_s;
}

}  // namespace isolux
