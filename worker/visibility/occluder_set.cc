#include "worker/visibility/occluder_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "common/hierarchy/occluders.h"
#include "common/hierarchy/planes.h"
#include "common/hierarchy/regions.h"

namespace isolux {

void OccluderSet::Add(std::span<const Vec3> corners, uint32_t region, uint32_t plane) {
  Vec3 area(0.0), mean(0.0);
  for (size_t i = 0; i < corners.size(); ++i) {
    mean += corners[i] / static_cast<double>(corners.size());
    if (i > 1) area += glm::cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
  }
  const double twice_area = glm::length(area);
  if (!(twice_area > 0)) return;
  Occluder occluder;
  occluder.normal = area / twice_area;
  occluder.point = mean;
  occluder.first = static_cast<uint32_t>(corners_.size());
  double bent = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 side = corners[(i + 1) % corners.size()] - corners[i];
    const double length = glm::length(side);
    if (length == 0) continue;
    bent = std::max(bent, std::abs(occluder.Height(corners[i])));
    occluder.bounds.Add(corners[i]);
    corners_.push_back(corners[i]);
    inwards_.push_back(glm::cross(occluder.normal, side / length));
  }
  occluder.count = static_cast<uint32_t>(corners_.size()) - occluder.first;
  occluder.tolerance_m = tolerance_m_ + 2 * bent;
  occluder.region = region;
  occluder.plane = plane;
  occluders_.push_back(occluder);
}

bool OccluderSet::Blocks(uint32_t i, const Vec3& x, const Vec3& y) const {
  const Occluder& o = occluders_[i];
  const double hx = o.Height(x);
  const double hy = o.Height(y);
  const bool across =
      (hx > o.tolerance_m && hy < -o.tolerance_m) || (hx < -o.tolerance_m && hy > o.tolerance_m);
  if (!across) return false;
  const Vec3 crossing = x + (hx / (hx - hy)) * (y - x);
  const auto corner = corners(o);
  const auto inward = inwards(o);
  for (size_t k = 0; k < corner.size(); ++k) {
    if (glm::dot(inward[k], crossing - corner[k]) < -tolerance_m_) return false;
  }
  return true;
}

namespace {

double AreaOf(std::span<const Vec3> corners) {
  Vec3 area(0.0);
  for (size_t k = 2; k < corners.size(); ++k) {
    area += glm::cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
  }
  return 0.5 * glm::length(area);
}

uint32_t Root(std::vector<uint32_t>& parent, uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// The lowest polygon of each polygon's region: joined by edges within a plane, or one polygon over
// another with the same corners.
std::vector<uint32_t> FindFlatRegions(const Scene& scene, std::span<const uint32_t> plane_of) {
  const AlikeLoops alike = OrientAlike(scene, plane_of);
  const std::vector<uint64_t> key(plane_of.begin(), plane_of.end());
  std::vector<uint32_t> parent(scene.polygons.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto join = [&](uint32_t a, uint32_t b) {
    a = Root(parent, a);
    b = Root(parent, b);
    parent[std::max(a, b)] = std::min(a, b);
  };
  for (const Region& region : FindRegions(scene, alike.loops, key, alike.normals)) {
    for (const uint32_t p : region.polygons) join(region.polygons[0], p);
  }
  std::map<std::array<uint32_t, 4>, uint32_t> by_corners;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    auto corners = scene.polygons[p].vertices;
    std::sort(corners.begin(), corners.end());
    const auto [at, is_new] = by_corners.emplace(corners, p);
    if (!is_new) join(at->second, p);
  }
  for (uint32_t p = 0; p < parent.size(); ++p) parent[p] = Root(parent, p);
  return parent;
}

}  // namespace

SceneOccluders MakeOccluders(const Scene& scene) {
  const std::vector<uint32_t> plane_of = FindPlanes(scene);
  const std::vector<OccluderPolygon> polygons = MergeOccluders(scene, plane_of);
  std::vector<std::pair<double, uint32_t>> order;
  for (uint32_t i = 0; i < polygons.size(); ++i) {
    order.emplace_back(-AreaOf(polygons[i].corners), i);
  }
  std::sort(order.begin(), order.end());
  SceneOccluders result{OccluderSet(ExtentOf(scene)), FindFlatRegions(scene, plane_of), plane_of};
  for (const auto& [size, i] : order) {
    result.set.Add(polygons[i].corners, result.region_of[polygons[i].first_polygon],
                   polygons[i].plane);
  }
  return result;
}

}  // namespace isolux
