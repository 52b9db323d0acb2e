// The vocabulary of vectors: GLM under our own names. Points are in metres, relative to the scene's
// centre, in double: differences of nearby points must not cancel away.
#pragma once

#include <array>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace isolux {

using Vec3 = glm::dvec3;
using Rgb = glm::dvec3;  // one value a colour channel, linear

inline double Sum(const Rgb& c) { return c.x + c.y + c.z; }

// Axis-aligned box; empty until a point is added.
struct Bounds3 {
  Vec3 low{std::numeric_limits<double>::infinity()};
  Vec3 high{-std::numeric_limits<double>::infinity()};

  void Add(const Vec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  void Add(const Bounds3& b) {
    low = glm::min(low, b.low);
    high = glm::max(high, b.high);
  }
  bool Empty() const { return low.x > high.x; }
  Vec3 Centre() const { return 0.5 * (low + high); }
  Vec3 Extent() const { return high - low; }
  double Diagonal() const { return Empty() ? 0.0 : glm::length(high - low); }
};

// Distance between two boxes; 0 where they touch or overlap.
inline double Distance(const Bounds3& a, const Bounds3& b) {
  const Vec3 gap = glm::max(glm::max(a.low - b.high, b.low - a.high), Vec3(0.0));
  return glm::length(gap);
}

}  // namespace isolux
