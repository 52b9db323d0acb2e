#include "worker/visibility/box_shaft.h"

#include <algorithm>

namespace isolux {
namespace {

// Highest and lowest of a linear function over a box, less its offset.
struct Span {
  double low, high;
};
Span HeightsOf(const Bounds3& box, const Vec3& normal, double offset) {
  const double centre = glm::dot(normal, box.Centre()) - offset;
  const double half = 0.5 * glm::dot(glm::abs(normal), box.Extent());
  return {centre - half, centre + half};
}

}  // namespace

// Seen along an axis the hull of two rectangles has a slanted side in a quadrant where the line
// through the two corners furthest that way faces into the quadrant.
BoxShaft::BoxShaft(const Bounds3& a, const Bounds3& b) : a_(a), b_(b), both_(a) {
  both_.Add(b);
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const bool up_u = (quadrant & 1) != 0, up_v = (quadrant & 2) != 0;
      const double au = up_u ? a.high[u] : a.low[u], av = up_v ? a.high[v] : a.low[v];
      const double bu = up_u ? b.high[u] : b.low[u], bv = up_v ? b.high[v] : b.low[v];
      HalfSpace plane;
      plane.normal[u] = bv - av;
      plane.normal[v] = au - bu;
      if ((plane.normal[u] > 0) != up_u) plane.normal = -plane.normal;
      if (plane.normal[u] == 0 || plane.normal[v] == 0) continue;
      if ((plane.normal[u] > 0) != up_u || (plane.normal[v] > 0) != up_v) continue;
      plane.normal = glm::normalize(plane.normal);
      plane.offset =
          std::max(HeightsOf(a, plane.normal, 0).high, HeightsOf(b, plane.normal, 0).high);
      planes_[plane_count_++] = plane;
    }
  }
}

bool BoxShaft::MayTouch(const Bounds3& box) const {
  for (int d = 0; d < 3; ++d) {
    if (box.low[d] > both_.high[d] || box.high[d] < both_.low[d]) return false;
  }
  return std::all_of(planes_.begin(), planes_.begin() + plane_count_, [&](const HalfSpace& plane) {
    return HeightsOf(box, plane.normal, plane.offset).low <= 0;
  });
}

bool BoxShaft::MayBlock(const OccluderSet& set, const Occluder& occluder) const {
  if (!MayTouch(occluder.bounds)) return false;
  const double offset = glm::dot(occluder.normal, occluder.point);
  const Span a = HeightsOf(a_, occluder.normal, offset);
  const Span b = HeightsOf(b_, occluder.normal, offset);
  if (std::min(a.low, b.low) >= -occluder.tolerance_m ||
      std::max(a.high, b.high) <= occluder.tolerance_m) {
    return false;
  }
  const auto corners = set.corners(occluder);
  return std::all_of(planes_.begin(), planes_.begin() + plane_count_, [&](const HalfSpace& plane) {
    return std::any_of(corners.begin(), corners.end(), [&](const Vec3& corner) {
      return glm::dot(plane.normal, corner) < plane.offset;
    });
  });
}

}  // namespace isolux
