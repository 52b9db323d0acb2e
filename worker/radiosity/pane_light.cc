#include "worker/radiosity/pane_light.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "worker/coupling/clip.h"
#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

// Over the channels, W/m².
struct Source {
  const ConvexPolygon* polygon;
  double emitted = 0;
  double reflected = 0;  // beyond what counts as all round
};

// Mean form factor from four points of a pane, on the side of this normal, to a source.
double FactorTo(const ConvexPolygon& source, const Vec3x4& points, const Vec3& on_pane,
                const Vec3& normal, double tolerance_m) {
  const ClippedPolygon seen = ClipToFront(source, on_pane, normal, tolerance_m);
  if (seen.count < 3) return 0;
  const Lanes factors = PointFormFactors(points, normal, seen.corners());
  const Vec3 facing = source.Normal();
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const Vec3 x(points.x[i], points.y[i], points.z[i]);
    if (glm::dot(facing, x - source.v[0]) > 0) sum += factors[i] / 4;
  }
  return sum;
}

// What all but the brightest surfaces reflect at most, so many of them.
double BrightestBeyond(std::span<const double> reflected_w_m2, size_t count) {
  if (count >= reflected_w_m2.size()) return 0;
  std::vector<double> falling(reflected_w_m2.begin(), reflected_w_m2.end());
  const auto at = falling.begin() + static_cast<ptrdiff_t>(count);
  std::ranges::nth_element(falling, at, std::ranges::greater());
  return *at;
}

}  // namespace

double MostTakenByPanes(const Hierarchy& hierarchy, std::span<const double> reflected_w_m2,
                        uint64_t most_pairs) {
  const Glazing& glazing = hierarchy.scene().glazing;
  const auto surfaces = hierarchy.surfaces();
  const auto lamps = static_cast<size_t>(
      std::ranges::count_if(surfaces, [](const Surface& s) { return Sum(s.exitance) > 0; }));
  const size_t most = most_pairs / std::max<size_t>(glazing.panes.size(), 1);
  if (lamps > most) return std::numeric_limits<double>::infinity();
  const bool of_each = reflected_w_m2.size() == surfaces.size();
  const double all_round = BrightestBeyond(reflected_w_m2, of_each ? most - lamps : 0);
  const double brightest = std::ranges::max(reflected_w_m2);
  std::vector<Source> sources;
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    const double beyond = of_each ? std::max(0.0, reflected_w_m2[s] - all_round) : 0.0;
    const double emitted = Sum(surfaces[s].exitance);
    if (emitted + beyond > 0) sources.push_back({&hierarchy.geometry(s), emitted, beyond});
  }
  const double tolerance_m = 1e-9 * hierarchy.extent_m();
  double power_w = 0;
  for (const Pane& pane : glazing.panes) {
    ConvexPolygon shape;
    shape.count = static_cast<int>(pane.count);
    shape.v = pane.corners;
    const Vec3 middle = shape.Centroid();
    std::array<Vec3, 4> at;
    for (int i = 0; i < 4; ++i)
      at[static_cast<size_t>(i)] = 0.5 * (middle + shape.v[i % shape.count]);
    const Vec3x4 points(at);
    double falls_w_m2 = 0;
    for (const Vec3& normal : {shape.Normal(), -shape.Normal()}) {
      double reflected = all_round;
      for (const Source& source : sources) {
        const double factor = FactorTo(*source.polygon, points, middle, normal, tolerance_m);
        falls_w_m2 += factor * source.emitted;
        reflected += factor * source.reflected;
      }
      falls_w_m2 += std::min(reflected, brightest);
    }
    const Rgb taken = Rgb(1.0) - glazing.glasses[pane.glass].MeanTransmittance();
    power_w += shape.Area() * std::max({taken.x, taken.y, taken.z}) * falls_w_m2;
  }
  return power_w;
}

}  // namespace isolux
