#include "tests/support/path_tracer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <optional>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/panes.h"
#include "common/util/random.h"
#include "tests/support/surface_points.h"
#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux::testing {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kPathsAPass = 1024;
constexpr double kDarkShare = 0.05;

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Paths from a point: light sampled by area and by direction, weighted by the balance heuristic.
class PathTracer {
 public:
  PathTracer(const Scene& scene, bool by_mirrors_alone)
      : hierarchy_(scene), rays_(hierarchy_), by_mirrors_alone_(by_mirrors_alone) {
    if (scene.glazing.exists()) panes_.emplace(scene.glazing, hierarchy_.extent_m(), false);
    surface_of_.resize(scene.polygons.size(), {kNone, kNone});
    const auto surfaces = hierarchy_.surfaces();
    for (uint32_t s = 0; s < surfaces.size(); ++s) {
      surface_of_[surfaces[s].polygon][static_cast<int>(surfaces[s].side)] = s;
      const double power = hierarchy_.surface_area_m2(s) * Sum(surfaces[s].exitance);
      power_up_to_.push_back((s > 0 ? power_up_to_.back() : 0) + power);
    }
  }

  struct Place {
    Vec3 position{0.0};
    uint32_t surface = 0;
  };

  const Hierarchy& hierarchy() const { return hierarchy_; }
  Vec3 NormalOf(uint32_t surface) const { return hierarchy_.geometry(surface).Normal(); }

  // One sample of the irradiance at a place.
  Rgb Sample(Place place, Random& random) const {
    Rgb sum(0.0);
    glm::dmat3 weight(1.0);  // of channels there on channels here
    bool counts = !by_mirrors_alone_;
    for (int bounce = 0; bounce < 1000; ++bounce) {
      const Rgb direct = FromLights(place, random);
      if (counts) sum += weight * direct;
      Place next;
      Vec3 direction(0.0);
      double cosine_pdf = 0;
      if (!Bounce(place, random, next, direction, cosine_pdf)) break;
      weight *= Left(place, next);
      // What a cosine-distributed ray meets: its exitance is the sample of the irradiance.
      const double light_pdf = LightPdf(next.surface);
      const double chosen = cosine_pdf / (cosine_pdf + light_pdf);
      if (counts) sum += weight * SurfaceAt(next).exitance * chosen;
      // Mirrors by chance: nothing else samples what they show.
      bool arrives = true;
      while (arrives && random.Unit() < SpecularAt(next)) {
        const Vec3 n = NormalOf(next.surface);
        direction -= 2 * glm::dot(n, direction) * n;
        const Place mirror = next;
        arrives = Follow(next, direction, next);
        if (arrives) weight *= Left(mirror, next);
        counts = true;
        if (arrives) sum += weight * SurfaceAt(next).exitance;
      }
      if (!arrives || SpecularAt(next) == 1) break;
      // What leaves here came from this side of a sheet, or by chance from the other.
      const Rgb reflected = SurfaceAt(next).reflectance, passed = PassedAt(next);
      const double through = Sum(passed) > 0 ? Sum(passed) / (Sum(passed) + Sum(reflected)) : 0.0;
      const bool goes_through = through > 0 && random.Unit() < through;
      const double chance = (goes_through ? through : 1 - through) * (1 - SpecularAt(next));
      const Rgb share = (goes_through ? passed : reflected) / chance;
      glm::dmat3 hands_on(share.x, 0, 0, 0, share.y, 0, 0, 0, share.z);  // a column a channel in
      if (!goes_through) {
        const Reradiation& m = ReradiationAt(next);
        hands_on[1][0] = m.green_to_red / chance;
        hands_on[2][0] = m.blue_to_red / chance;
        hands_on[2][1] = m.blue_to_green / chance;
      }
      weight = weight * hands_on;
      if (goes_through) {
        const Surface& here = SurfaceAt(next);
        next.surface = surface_of_[here.polygon][here.side == Side::kFront ? 1 : 0];
      }
      double go_on = 0;
      for (int c = 0; c < 3; ++c) {
        go_on = std::max({go_on, weight[c].x, weight[c].y, weight[c].z});
      }
      go_on = std::min(0.98, go_on);
      if (random.Unit() >= go_on) break;
      weight /= go_on;
      place = next;
    }
    return sum;
  }

 private:
  static constexpr uint32_t kNone = 0xffffffffu;

  static uint32_t Pick(const std::vector<double>& up_to, Random& random) {
    const double target = random.Unit() * up_to.back();
    const auto at = std::upper_bound(up_to.begin(), up_to.end(), target);
    return static_cast<uint32_t>(std::min<ptrdiff_t>(at - up_to.begin(), up_to.size() - 1));
  }

  // Density over area with which FromLights picks points of a surface, 1/m².
  double LightPdf(uint32_t s) const {
    return Sum(hierarchy_.surfaces()[s].exitance) / power_up_to_.back();
  }

  Rgb FromLights(const Place& place, Random& random) const {
    const uint32_t s = Pick(power_up_to_, random);
    const double u = random.Unit();
    const Vec3 to = SamplePolygon(hierarchy_.geometry(s), u, random.Unit());
    const Vec3 d = to - place.position;
    const double d2 = glm::dot(d, d);
    const double cosine = glm::dot(NormalOf(place.surface), d);
    const double other = -glm::dot(NormalOf(s), d);
    if (!(d2 > 0) || cosine <= 0 || other <= 0) return Rgb(0.0);
    const double kernel = cosine * other / (kPi * d2 * d2);  // also the density of a cosine ray
    const double pdf = LightPdf(s);
    std::array<Escape, RayScene::kPacket> rays;
    rays[0] = {place.position, d / std::sqrt(d2), hierarchy_.surfaces()[place.surface].polygon};
    const RayHit hit = rays_.Trace(rays, 1)[0];
    if (hit.polygon != hierarchy_.surfaces()[s].polygon) return Rgb(0.0);
    return hierarchy_.surfaces()[s].exitance * (kernel / (pdf + kernel)) * Left(place, {to, s});
  }

  // What panes of glass leave of light on the way.
  Rgb Left(const Place& from, const Place& to) const {
    return panes_ ? panes_->Along(from.position, to.position) : Rgb(1.0);
  }

  const Surface& SurfaceAt(const Place& place) const {
    return hierarchy_.surfaces()[place.surface];
  }
  double SpecularAt(const Place& place) const {
    const Scene& scene = hierarchy_.scene();
    return scene.materials[scene.polygons[SurfaceAt(place).polygon].material].specular;
  }

  // Of what arrives on either side of a sheet, what comes out on the other.
  Rgb PassedAt(const Place& place) const {
    const Scene& scene = hierarchy_.scene();
    const Surface& here = SurfaceAt(place);
    if (surface_of_[here.polygon][0] == kNone || surface_of_[here.polygon][1] == kNone) {
      return Rgb(0.0);
    }
    return scene.materials[scene.polygons[here.polygon].material].transmittance;
  }

  const Reradiation& ReradiationAt(const Place& place) const {
    const Scene& scene = hierarchy_.scene();
    return scene.materials[scene.polygons[SurfaceAt(place).polygon].material].reradiation;
  }

  bool Bounce(const Place& place, Random& random, Place& next, Vec3& direction, double& pdf) const {
    const Vec3 n = NormalOf(place.surface);
    const Vec3 s =
        glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
    const double r = std::sqrt(random.Unit()), phi = 2 * kPi * random.Unit();
    const double height = std::sqrt(std::max(1e-12, 1 - r * r));
    direction = r * std::cos(phi) * s + r * std::sin(phi) * glm::cross(n, s) + height * n;
    if (!Follow(place, direction, next)) return false;
    const Vec3 d = next.position - place.position;
    pdf = height * -glm::dot(NormalOf(next.surface), direction) / (kPi * glm::dot(d, d));
    return true;
  }

  // What a ray meets first, where that is a side that takes part. `next` may be `place`.
  bool Follow(const Place& from, const Vec3& direction, Place& next) const {
    const Place place = from;
    std::array<Escape, RayScene::kPacket> rays;
    rays[0] = {place.position, direction, hierarchy_.surfaces()[place.surface].polygon};
    const RayHit hit = rays_.Trace(rays, 1)[0];
    if (hit.polygon == RayHit::kNothing) return false;
    next.surface = surface_of_[hit.polygon][static_cast<int>(hit.side)];
    if (next.surface == kNone) return false;
    const Vec3 m = NormalOf(next.surface);
    const double facing = -glm::dot(m, direction);
    if (!(facing > 0)) return false;
    const double t = glm::dot(m, hierarchy_.geometry(next.surface).v[0] - place.position) / -facing;
    next.position = place.position + t * direction;
    return t > 0;
  }

  Hierarchy hierarchy_;
  RayScene rays_;
  bool by_mirrors_alone_;
  std::optional<Panes> panes_;
  std::vector<std::array<uint32_t, 2>> surface_of_;
  std::vector<double> power_up_to_;
};

struct PathTally {
  Rgb sum{0.0}, squares{0.0};
  double n = 0;
  Rgb Mean() const { return sum / n; }
  Rgb Deviation() const { return glm::sqrt(glm::max(squares / n - Mean() * Mean(), Rgb(0.0)) / n); }
};

}  // namespace

std::vector<ReferencePoint> TracePaths(const Scene& scene, const PathTracing& options,
                                       ThreadPool& pool) {
  const PathTracer tracer(scene, options.by_mirrors_alone);
  const std::vector<PointOnSurface> places =
      UniformPoints(tracer.hierarchy(), options.points, options.seed);
  std::vector<PathTally> tally(places.size());
  const double end = Now() + options.seconds;
  double mean = 0;
  for (uint64_t pass = 0; pass == 0 || Now() < end; ++pass) {
    std::vector<size_t> open;
    for (size_t i = 0; i < places.size(); ++i) {
      const PathTally& t = tally[i];
      if (pass < 4 ||
          Sum(t.Deviation()) > options.error * std::max(Sum(t.Mean()), kDarkShare * mean)) {
        open.push_back(i);
      }
    }
    if (open.empty()) break;
    pool.For(open.size(), 1, [&](size_t begin, size_t stop, int) {
      for (size_t k = begin; k < stop; ++k) {
        const PointOnSurface& place = places[open[k]];
        Random random(Hash(options.seed, open[k], pass + 1));
        PathTally& t = tally[open[k]];
        for (int j = 0; j < kPathsAPass; ++j) {
          const Rgb h = tracer.Sample({place.position_m, place.element.surface}, random);
          t.sum += h;
          t.squares += h * h;
          ++t.n;
        }
      }
    });
    mean = 0;
    for (const PathTally& t : tally) mean += Sum(t.Mean()) / static_cast<double>(tally.size());
  }
  std::vector<ReferencePoint> points;
  for (size_t i = 0; i < places.size(); ++i) {
    points.push_back(places[i].expected);
    points.back().irradiance = tally[i].Mean();
    points.back().deviation = tally[i].Deviation();
  }
  return points;
}

double NoiseOf(const std::vector<ReferencePoint>& points) {
  double noise = 0, sum = 0;
  for (const ReferencePoint& point : points) {
    noise += Sum(point.deviation);
    sum += Sum(point.irradiance);
  }
  return sum > 0 ? noise / sum : 0;
}

}  // namespace isolux::testing
