#include "worker/coupling/clip.h"

#include <algorithm>
#include <cmath>

namespace isolux {

double ClippedPolygon::Area() const {
  Vec3 sum(0.0);
  for (int i = 1; i + 1 < count; ++i) sum += glm::cross(v[i] - v[0], v[i + 1] - v[0]);
  return 0.5 * glm::length(sum);
}

ClippedPolygon ClipToFront(const ConvexPolygon& polygon, const Vec3& point, const Vec3& normal,
                           double tolerance_m) {
  std::array<double, 4> height{};
  for (int i = 0; i < polygon.count; ++i) {
    height[i] = glm::dot(normal, polygon.v[i] - point);
    if (std::abs(height[i]) <= tolerance_m) height[i] = 0;
  }
  ClippedPolygon result;
  bool front = false, behind = false;
  for (int i = 0; i < polygon.count; ++i) {
    front |= height[i] > 0;
    behind |= height[i] < 0;
  }
  if (!behind) {
    result.count = front ? polygon.count : 0;
    std::copy_n(polygon.v.begin(), result.count, result.v.begin());
    return result;
  }
  for (int i = 0; i < polygon.count; ++i) {
    const int j = (i + 1) % polygon.count;
    if (height[i] >= 0 && result.count < 5) result.v[result.count++] = polygon.v[i];
    if (height[i] * height[j] < 0 && result.count < 5) {
      result.v[result.count++] =
          polygon.v[i] + height[i] / (height[i] - height[j]) * (polygon.v[j] - polygon.v[i]);
    }
  }
  if (!front || result.count < 3) result.count = 0;
  return result;
}

}  // namespace isolux
