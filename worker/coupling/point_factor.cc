#include "worker/coupling/point_factor.h"

#include <numbers>

namespace isolux {

Lanes PointFormFactors(const Vec3x4& points, const Vec3& n, std::span<const Vec3> q) {
  Lanes sum = Splat(0.0);
  const Vec3x4 first = q[0] - points;
  Vec3x4 a = first;
  for (size_t k = 0; k < q.size(); ++k) {
    const Vec3x4 b = k + 1 < q.size() ? q[k + 1] - points : first;
    const Vec3x4 cross = Cross(a, b);
    const Lanes length = SquareRoot(Dot(cross, cross));
    const Lanes angle = Atan2Upper(length, Dot(a, b));
    const Lanes term = angle * Dot(n, cross) / Select(length == 0.0, Splat(1.0), length);
    sum -= Select(length == 0.0, Splat(0.0), term);
    a = b;
  }
  return Minimum(Maximum(sum * (0.5 / std::numbers::pi), Splat(0.0)), Splat(1.0));
}

}  // namespace isolux
