#include "common/hierarchy/effects/landing.h"

#include <algorithm>
#include <cmath>

#include "common/util/angles.h"
#include "common/util/random.h"

namespace isolux {
namespace {

constexpr int kRays = 512;
constexpr size_t kMostPolygons = 50'000;  // each ray meets them all
constexpr uint64_t kSeed = 0x1a4d;

struct Ray {
  Vec3 from{0.0}, direction{0.0};
  uint32_t polygon = 0;
};

// A cosine-distributed ray from a uniform point of a surface.
Ray RayFrom(const Hierarchy& hierarchy, uint32_t surface, Random& random) {
  const ConvexPolygon& p = hierarchy.geometry(surface);
  const double first = glm::length(glm::cross(p.v[1] - p.v[0], p.v[2] - p.v[0]));
  const double second =
      p.count == 4 ? glm::length(glm::cross(p.v[2] - p.v[0], p.v[3] - p.v[0])) : 0.0;
  const int k = random.Unit() * (first + second) < first ? 1 : 2;
  const double root = std::sqrt(random.Unit()), v = random.Unit();
  Ray ray;
  ray.from = p.v[0] + root * ((1 - v) * (p.v[k] - p.v[0]) + v * (p.v[k + 1] - p.v[0]));
  const Vec3 n = p.Normal();
  const Vec3 side =
      glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
  const double a = 2 * random.Unit() - 1;
  const auto [x, y] = SquareToDisk(a, 2 * random.Unit() - 1);
  ray.direction =
      x * side + y * glm::cross(n, side) + std::sqrt(std::max(1e-12, 1 - x * x - y * y)) * n;
  ray.polygon = hierarchy.surfaces()[surface].polygon;
  return ray;
}

// Distance at which the ray meets the polygon, infinite where it does not.
double Meets(const Ray& ray, const ConvexPolygon& polygon, const Vec3& normal) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double falls = glm::dot(normal, ray.direction);
  if (falls == 0) return kNever;
  const double t = glm::dot(normal, polygon.v[0] - ray.from) / falls;
  if (!(t > 0)) return kNever;
  const Vec3 point = ray.from + t * ray.direction;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 along = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    if (glm::dot(glm::cross(along, point - polygon.v[i]), normal) < 0) return kNever;
  }
  return t;
}

class Scout {
 public:
  explicit Scout(const Hierarchy& hierarchy) : hierarchy_(hierarchy) {
    const Scene& scene = hierarchy.scene();
    for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
      shapes_.push_back(SideGeometry(scene, p, Side::kFront));
      normals_.push_back(shapes_.back().Normal());
    }
  }

  // Whether what the ray meets first is a side that takes part.
  bool Lands(const Ray& ray) const {
    double nearest = std::numeric_limits<double>::infinity();
    bool lands = false;
    for (uint32_t p = 0; p < shapes_.size(); ++p) {
      if (hierarchy_.plane_of(p) == hierarchy_.plane_of(ray.polygon)) continue;
      const bool front = glm::dot(normals_[p], ray.direction) < 0;
      const uint8_t sides = hierarchy_.scene().polygons[p].sides;
      if ((sides & (front ? kFrontCovered : kBackCovered)) != 0) continue;
      const double t = Meets(ray, shapes_[p], normals_[p]);
      if (!(t < nearest)) continue;
      nearest = t;
      lands = (sides & (front ? kFrontTakesPart | kFrontEmits : kBackTakesPart | kBackEmits)) != 0;
    }
    return lands;
  }

 private:
  const Hierarchy& hierarchy_;
  std::vector<ConvexPolygon> shapes_;
  std::vector<Vec3> normals_;
};

}  // namespace

double LandingPower(const Hierarchy& hierarchy) {
  if (hierarchy.scene().polygons.size() > kMostPolygons) return 0;
  std::vector<double> until;  // power of the surfaces up to each
  double power_w = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    power_w += hierarchy.surface_area_m2(s) * Sum(hierarchy.surfaces()[s].exitance);
    until.push_back(power_w);
  }
  if (!(power_w > 0)) return 0;
  const Scout scout(hierarchy);
  Random random(kSeed);
  int landed = 0;
  for (int i = 0; i < kRays; ++i) {
    const double at = (i + random.Unit()) / kRays * power_w;
    const auto lamp = std::min<size_t>(
        static_cast<size_t>(std::upper_bound(until.begin(), until.end(), at) - until.begin()),
        until.size() - 1);
    landed += scout.Lands(RayFrom(hierarchy, static_cast<uint32_t>(lamp), random)) ? 1 : 0;
  }
  const double share = (landed + 0.5) / (kRays + 1);
  return power_w * std::max(0.0, share - 3 * std::sqrt(share * (1 - share) / kRays));
}

}  // namespace isolux
