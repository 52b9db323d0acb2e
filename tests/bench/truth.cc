// The true error of a solution: path-traced irradiance at seeded points, and how far a patch file
// is from it there. Shares no transport with the solver: no hierarchy of links, no form factors.
//
//   truth make SCENE.obj POINTS.csv [--points N] [--error SHARE] [--seconds S] [--emit both]
//     N points uniform over the participating sides; paths are added until the standard error of
//     each point is below SHARE of its irradiance (or of a twentieth of the mean, if more), or S
//     seconds have passed.
//   truth compare ROOM.ply POINTS.csv
//     Prints CSV: the L1 error relative to the mean irradiance, the same net of the reference's own
//     noise, the bias (signed), and how many points lie on no face (counted as dark).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "client/import/import.h"
#include "client/output/comparison.h"
#include "client/output/reference_points.h"
#include "common/hierarchy/hierarchy.h"
#include "common/scene/patch_file.h"
#include "common/util/parallel.h"
#include "common/util/random.h"
#include "worker/radiosity/ray_scene.h"
#include "worker/radiosity/visibility.h"

namespace isolux {
namespace {

constexpr double kPi = std::numbers::pi;

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Paths from a point: light sampled by area and by direction, weighted by the balance heuristic.
class PathTracer {
 public:
  explicit PathTracer(const Scene& scene) : scene_(scene), hierarchy_(scene), rays_(hierarchy_) {
    surface_of_.resize(scene.polygons.size(), {kNone, kNone});
    const auto surfaces = hierarchy_.surfaces();
    for (uint32_t s = 0; s < surfaces.size(); ++s) {
      surface_of_[surfaces[s].polygon][static_cast<int>(surfaces[s].side)] = s;
      area_up_to_.push_back((s > 0 ? area_up_to_.back() : 0) + hierarchy_.surface_area_m2(s));
      const double power = hierarchy_.surface_area_m2(s) * Sum(surfaces[s].exitance);
      power_up_to_.push_back((s > 0 ? power_up_to_.back() : 0) + power);
    }
  }

  struct Place {
    Vec3 position{0.0};
    uint32_t surface = 0;
  };

  Place UniformPlace(Random& random) const {
    const uint32_t s = Pick(area_up_to_, random);
    const double u = random.Unit();
    return {SamplePolygon(hierarchy_.geometry(s), u, random.Unit()), s};
  }

  Vec3 NormalOf(uint32_t surface) const { return hierarchy_.geometry(surface).Normal(); }

  // One sample of the irradiance at a place.
  Rgb Sample(Place place, Random& random) const {
    Rgb sum(0.0), weight(1.0);
    for (int bounce = 0; bounce < 1000; ++bounce) {
      sum += weight * FromLights(place, random);
      Place next;
      double cosine_pdf = 0;
      if (!Bounce(place, random, next, cosine_pdf)) break;
      const Surface& surface = hierarchy_.surfaces()[next.surface];
      // What a cosine-distributed ray meets: its exitance is the sample of the irradiance.
      const double light_pdf = LightPdf(next.surface);
      sum += weight * surface.exitance * (cosine_pdf / (cosine_pdf + light_pdf));
      weight *= surface.reflectance;
      const double go_on = std::min(0.98, std::max({weight.x, weight.y, weight.z}));
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
    std::array<Segment, RayScene::kPacket> segments;
    segments[0] = {place.position, to, hierarchy_.surfaces()[place.surface].polygon,
                   hierarchy_.surfaces()[s].polygon};
    if ((rays_.Visible(segments, 1) & 1) == 0) return Rgb(0.0);
    return hierarchy_.surfaces()[s].exitance * (kernel / (pdf + kernel));
  }

  bool Bounce(const Place& place, Random& random, Place& next, double& pdf) const {
    const Vec3 n = NormalOf(place.surface);
    const Vec3 s =
        glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
    const double r = std::sqrt(random.Unit()), phi = 2 * kPi * random.Unit();
    const double height = std::sqrt(std::max(1e-12, 1 - r * r));
    const Vec3 direction =
        r * std::cos(phi) * s + r * std::sin(phi) * glm::cross(n, s) + height * n;
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
    pdf = height * facing / (kPi * t * t);
    return t > 0;
  }

  const Scene& scene_;
  Hierarchy hierarchy_;
  RayScene rays_;
  std::vector<std::array<uint32_t, 2>> surface_of_;
  std::vector<double> area_up_to_, power_up_to_;
};

struct Flags {
  size_t points = 400;
  double error = 0.003;
  double seconds = 60;
  bool emit_both = false;
};

int Fail(const Status& status) {
  std::fprintf(stderr, "%s\n", status.message().c_str());
  return 2;
}

int Make(const std::string& path, const std::string& out, const Flags& flags) {
  ImportOptions import;
  import.emit_both = flags.emit_both;
  const Result<Scene> scene = ImportScene(path, import);
  if (!scene) return Fail(scene.error());
  const PathTracer tracer(*scene);
  struct Tally {
    Rgb sum{0.0}, squares{0.0};
    double n = 0;
    Rgb Mean() const { return sum / n; }
    Rgb Deviation() const {
      return glm::sqrt(glm::max(squares / n - Mean() * Mean(), Rgb(0.0)) / n);
    }
  };
  std::vector<PathTracer::Place> places;
  for (size_t i = 0; i < flags.points; ++i) {
    Random random(Hash(7, i));
    places.push_back(tracer.UniformPlace(random));
  }
  std::vector<Tally> tally(places.size());
  ThreadPool pool(0);
  const double end = Now() + flags.seconds;
  double mean = 0;
  for (uint64_t pass = 0; Now() < end; ++pass) {
    std::vector<size_t> open;
    for (size_t i = 0; i < places.size(); ++i) {
      const Tally& t = tally[i];
      if (pass < 4 || Sum(t.Deviation()) > flags.error * std::max(Sum(t.Mean()), 0.05 * mean)) {
        open.push_back(i);
      }
    }
    if (open.empty()) break;
    pool.For(open.size(), 1, [&](size_t begin, size_t stop, int) {
      for (size_t k = begin; k < stop; ++k) {
        Random random(Hash(11, open[k], pass));
        for (int j = 0; j < 1024; ++j) {
          const Rgb h = tracer.Sample(places[open[k]], random);
          tally[open[k]].sum += h;
          tally[open[k]].squares += h * h;
          ++tally[open[k]].n;
        }
      }
    });
    mean = 0;
    for (const Tally& t : tally) mean += Sum(t.Mean()) / static_cast<double>(tally.size());
  }
  std::vector<ReferencePoint> points;
  double noise = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    const Vec3 p = (places[i].position + scene->origin_m) / scene->metres_per_unit;
    points.push_back(
        {p, tracer.NormalOf(places[i].surface), tally[i].Mean(), tally[i].Deviation()});
    noise += 0.8 * Sum(points[i].deviation) / static_cast<double>(places.size());
  }
  if (const Status written = WriteReferencePoints(points, out); !written.ok()) return Fail(written);
  std::printf("points,%zu\nmean_irradiance,%.6g\nnoise,%.3g\n", places.size(), mean, noise / mean);
  return 0;
}

int CompareFiles(const std::string& ply, const std::string& csv) {
  const Result<PatchFile> file = ReadPatchFile(ply);
  if (!file) return Fail(file.error());
  const auto points = ReadReferencePoints(csv);
  if (!points) return Fail(points.error());
  auto exact = *points;
  for (ReferencePoint& point : exact) point.deviation = Rgb(0.0);
  const Result<Comparison> raw = Compare(*file, exact), net = Compare(*file, *points);
  if (!raw || !net) return Fail(raw ? net.error() : raw.error());
  std::printf("l1,%.5f\nl1_net,%.5f\nbias,%.5f\ndark,%lu of %lu\n", raw->l1_relative,
              net->l1_relative, net->bias_relative, net->unmatched, net->samples);
  return 0;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  const std::string mode = argc > 3 ? argv[1] : "";
  isolux::Flags flags;
  for (int i = 4; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--points") == 0)
      flags.points = std::strtoul(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--error") == 0) flags.error = std::strtod(argv[i + 1], nullptr);
    if (std::strcmp(argv[i], "--seconds") == 0) flags.seconds = std::strtod(argv[i + 1], nullptr);
    if (std::strcmp(argv[i], "--emit") == 0)
      flags.emit_both = std::strcmp(argv[i + 1], "both") == 0;
  }
  if (mode == "make") return isolux::Make(argv[2], argv[3], flags);
  if (mode == "compare") return isolux::CompareFiles(argv[2], argv[3]);
  std::fprintf(stderr,
               "usage: truth make SCENE.obj POINTS.csv [...] | compare ROOM.ply POINTS.csv\n");
  return 2;
}
