#include "worker/visibility/occluder_set.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/occluders.h"
#include "common/hierarchy/planes.h"

namespace isolux {

void OccluderSet::Add(std::span<const Vec3> corners) {
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

OccluderSet MakeOccluders(const Scene& scene) {
  const std::vector<OccluderPolygon> polygons = MergeOccluders(scene, FindPlanes(scene));
  std::vector<std::pair<double, uint32_t>> order;
  for (uint32_t i = 0; i < polygons.size(); ++i) {
    const auto& corners = polygons[i].corners;
    Vec3 area(0.0);
    for (size_t k = 2; k < corners.size(); ++k) {
      area += glm::cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
    }
    order.emplace_back(-glm::length(area), i);
  }
  std::sort(order.begin(), order.end());
  OccluderSet set(ExtentOf(scene));
  for (const auto& [size, i] : order) set.Add(polygons[i].corners);
  return set;
}

}  // namespace isolux
