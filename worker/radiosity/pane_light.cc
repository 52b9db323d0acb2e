#include "worker/radiosity/pane_light.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "worker/coupling/clip.h"
#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

constexpr uint64_t kMostPairs = 1 << 22;  // of panes and lamps: some seconds

struct Lamp {
  const ConvexPolygon* polygon;
  double exitance_w_m2;  // over the channels
};

// Mean form factor from four points of a pane, on the side of this normal, to a lamp.
double FactorTo(const ConvexPolygon& lamp, const Vec3x4& points, const Vec3& on_pane,
                const Vec3& normal, double tolerance_m) {
  const ClippedPolygon seen = ClipToFront(lamp, on_pane, normal, tolerance_m);
  if (seen.count < 3) return 0;
  const Lanes factors = PointFormFactors(points, normal, seen.corners());
  const Vec3 facing = lamp.Normal();
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const Vec3 x(points.x[i], points.y[i], points.z[i]);
    if (glm::dot(facing, x - lamp.v[0]) > 0) sum += factors[i] / 4;
  }
  return sum;
}

}  // namespace

double MostTakenByPanes(const Hierarchy& hierarchy, double reflected_w_m2) {
  const Glazing& glazing = hierarchy.scene().glazing;
  std::vector<Lamp> lamps;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const double exitance_w_m2 = Sum(hierarchy.surfaces()[s].exitance);
    if (exitance_w_m2 > 0) lamps.push_back({&hierarchy.geometry(s), exitance_w_m2});
  }
  if (glazing.panes.size() * lamps.size() > kMostPairs) {
    return std::numeric_limits<double>::infinity();
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
    double falls_w_m2 = 2 * reflected_w_m2;
    for (const Vec3& normal : {shape.Normal(), -shape.Normal()}) {
      for (const Lamp& lamp : lamps) {
        falls_w_m2 +=
            lamp.exitance_w_m2 * FactorTo(*lamp.polygon, points, middle, normal, tolerance_m);
      }
    }
    const Rgb taken = Rgb(1.0) - glazing.glasses[pane.glass].MeanTransmittance();
    power_w += shape.Area() * std::max({taken.x, taken.y, taken.z}) * falls_w_m2;
  }
  return power_w;
}

}  // namespace isolux
