#include "common/hierarchy/planes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "common/scene/box_tree.h"

namespace isolux {
namespace {

constexpr uint32_t kNone = 0xffffffffu;
// Sine of the angle up to which well shaped polygons may be of one plane: ten times what printing
// with six digits turns them by. A sphere has it from 10^8 facets on.
constexpr double kSameDirection = 5e-4;
// How far a neighbour may be, over the polygon's own size: tiles have joints.
constexpr double kReach = 0.05;

struct Plane {
  Vec3 normal, point;
  double size = 0;  // metres, of the largest polygon in it
  double Height(const Vec3& p) const { return glm::dot(normal, p - point); }
};

// Regions of near polygons in one plane.
class RegionGrower {
 public:
  RegionGrower(const Scene& scene, double extent)
      : scene_(scene),
        extent_(extent),
        boxes_(MakeBoxes(scene)),
        tree_(boxes_),
        region_of_(scene.polygons.size(), kNone) {}

  void Run() {
    std::vector<double> area(scene_.polygons.size());
    for (uint32_t p = 0; p < area.size(); ++p) {
      const ConvexPolygon shape = SideGeometry(scene_, p, Side::kFront);
      const Vec3 vector = shape.AreaVector();
      area[p] = glm::length(vector);
      normals_.push_back(vector / area[p]);
      const double size = boxes_[p].Diagonal();
      tolerance_.push_back(ContactTolerance(extent_, size));
      // The normal of a narrow polygon is known no better than its corners over its width.
      sine_.push_back(kSameDirection + tolerance_[p] * size / (2 * area[p]));
    }
    std::vector<uint32_t> order(area.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return area[a] > area[b]; });
    for (const uint32_t seed : order) {
      if (region_of_[seed] == kNone) Grow(seed);
    }
  }

  const std::vector<uint32_t>& region_of() const { return region_of_; }
  const std::vector<Plane>& planes() const { return planes_; }

 private:
  static std::vector<Bounds3> MakeBoxes(const Scene& scene) {
    std::vector<Bounds3> boxes;
    for (uint32_t p = 0; p < scene.polygons.size(); ++p) boxes.push_back(BoundsOf(scene, p));
    return boxes;
  }

  void Grow(uint32_t seed) {
    const auto region = static_cast<uint32_t>(planes_.size());
    const ConvexPolygon shape = SideGeometry(scene_, seed, Side::kFront);
    Plane plane{normals_[seed], shape.Centroid(), boxes_[seed].Diagonal()};
    std::vector<uint32_t> members{seed};
    region_of_[seed] = region;
    size_t fitted = 1;
    for (size_t i = 0; i < members.size(); ++i) {
      const double size = boxes_[members[i]].Diagonal();
      tree_.ForEachOverlap(Widened(boxes_[members[i]], kReach * size), [&](uint32_t q) {
        if (region_of_[q] != kNone || !LiesIn(q, plane, 1)) return;
        region_of_[q] = region;
        members.push_back(q);
      });
      if (members.size() >= 2 * fitted && i + 1 >= fitted) {
        fitted = members.size();
        Fit(members, &plane);
      }
    }
    if (members.size() > 1) Fit(members, &plane);
    for (const uint32_t p : members) {  // what the plane has turned away from stands alone again
      if (p != seed && !LiesIn(p, plane, 2)) region_of_[p] = kNone;
    }
    planes_.push_back(plane);
  }

  bool LiesIn(uint32_t p, const Plane& plane, double slack) const {
    const Vec3 cross = glm::cross(normals_[p], plane.normal);
    if (glm::dot(cross, cross) > slack * slack * sine_[p] * sine_[p]) return false;
    const Polygon& polygon = scene_.polygons[p];
    for (int i = 0; i < polygon.vertex_count(); ++i) {
      if (std::abs(plane.Height(scene_.vertices[polygon.vertices[i]])) > slack * tolerance_[p])
        return false;
    }
    return true;
  }

  // The plane through three corners as far apart as can be: what rounding turns it by falls with
  // the size of the region.
  void Fit(const std::vector<uint32_t>& members, Plane* plane) const {
    const auto farthest = [&](const auto& measure) {
      Vec3 best(0.0);
      double most = -1;
      for (const uint32_t p : members) {
        const Polygon& polygon = scene_.polygons[p];
        for (int i = 0; i < polygon.vertex_count(); ++i) {
          const Vec3& v = scene_.vertices[polygon.vertices[i]];
          const double value = measure(v);
          if (value <= most) continue;
          most = value;
          best = v;
        }
      }
      return best;
    };
    const auto length2 = [](const Vec3& v) { return glm::dot(v, v); };
    const Vec3 a = farthest([&](const Vec3& v) { return length2(v - plane->point); });
    const Vec3 b = farthest([&](const Vec3& v) { return length2(v - a); });
    const Vec3 c = farthest([&](const Vec3& v) { return length2(glm::cross(v - a, b - a)); });
    const Vec3 across = glm::cross(b - a, c - a);
    if (!(length2(across) > 1e-12 * length2(b - a) * length2(b - a))) return;
    const Vec3 normal = glm::normalize(across);
    plane->normal = glm::dot(normal, plane->normal) < 0 ? -normal : normal;
    plane->point = (a + b + c) / 3.0;
  }

  const Scene& scene_;
  double extent_;
  std::vector<Bounds3> boxes_;
  BoxTree tree_;
  std::vector<Vec3> normals_;
  std::vector<double> tolerance_, sine_;  // of each polygon
  std::vector<uint32_t> region_of_;
  std::vector<Plane> planes_;
};

// Planes that agree, however far apart what lies in them is: number of each, by comparison with
// the first of its number.
std::vector<uint32_t> JoinEqual(const std::vector<Plane>& planes, double extent) {
  struct Known {
    std::array<double, 4> key;
    uint32_t number;
    double reach;  // of the offset
  };
  constexpr double kCell = 1e-5, kTolerance = 1e-6;
  std::map<std::array<int64_t, 4>, std::vector<Known>> cells;
  std::vector<uint32_t> numbers(planes.size());
  for (uint32_t p = 0; p < planes.size(); ++p) {
    Vec3 n = planes[p].normal;
    const double sign = std::abs(n.x) > 0.5 ? n.x : std::abs(n.y) > 0.5 ? n.y : n.z;
    if (sign < 0) n = -n;
    const std::array<double, 4> key{n.x, n.y, n.z, glm::dot(n, planes[p].point) / extent};
    const double reach = kContactOfSize * planes[p].size / extent;
    uint32_t found = kNone;
    // The cells the key may share with an equal plane: one, but for keys near a border.
    for (int corner = 0; corner < 16 && found == kNone; ++corner) {
      std::array<int64_t, 4> cell;
      for (int d = 0; d < 4; ++d) {
        const double shift = (corner >> d & 1) != 0 ? kTolerance : -kTolerance;
        cell[d] = static_cast<int64_t>(std::floor((key[d] + shift) / kCell));
      }
      const auto it = cells.find(cell);
      if (it == cells.end()) continue;
      for (const Known& known : it->second) {
        double difference = 0;
        for (int d = 0; d < 4; ++d)
          difference = std::max(difference, std::abs(known.key[d] - key[d]));
        const double offset = std::abs(known.key[3] - key[3]);
        if (difference > kTolerance || offset > std::min(known.reach, reach)) continue;
        found = known.number;
        break;
      }
    }
    numbers[p] = found != kNone ? found : p;
    if (found != kNone) continue;
    std::array<int64_t, 4> cell;
    for (int d = 0; d < 4; ++d) cell[d] = static_cast<int64_t>(std::floor(key[d] / kCell));
    cells[cell].push_back({key, p, reach});
  }
  return numbers;
}

}  // namespace

Bounds3 BoundsOf(const Scene& scene, uint32_t polygon) {
  Bounds3 bounds;
  const Polygon& p = scene.polygons[polygon];
  for (int i = 0; i < p.vertex_count(); ++i) bounds.Add(scene.vertices[p.vertices[i]]);
  return bounds;
}

double ExtentOf(const Scene& scene) {
  Bounds3 all;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) all.Add(BoundsOf(scene, p));
  return std::max(all.Diagonal(), 1e-300);
}

std::vector<uint32_t> FindPlanes(const Scene& scene) {
  const double extent = ExtentOf(scene);
  RegionGrower grower(scene, extent);
  grower.Run();
  const std::vector<uint32_t> joined = JoinEqual(grower.planes(), extent);
  // By first polygon, so that numbers do not depend on the order of the search.
  std::vector<uint32_t> number(joined.size(), kNone), plane_of(scene.polygons.size());
  uint32_t count = 0;
  for (uint32_t p = 0; p < plane_of.size(); ++p) {
    uint32_t& n = number[joined[grower.region_of()[p]]];
    if (n == kNone) n = count++;
    plane_of[p] = n;
  }
  return plane_of;
}

}  // namespace isolux
