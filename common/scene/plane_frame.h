// Coordinates in a plane, for geometry that happens there: clipping, convexity, outlines.
#pragma once

#include <cmath>

#include "common/vec.h"

namespace isolux {

struct Point2 {
  double x = 0, y = 0;
};

inline Point2 operator-(const Point2& a, const Point2& b) { return {a.x - b.x, a.y - b.y}; }
inline Point2 operator+(const Point2& a, const Point2& b) { return {a.x + b.x, a.y + b.y}; }
inline Point2 operator*(double s, const Point2& a) { return {s * a.x, s * a.y}; }
inline double Cross(const Point2& a, const Point2& b) { return a.x * b.y - a.y * b.x; }
inline double Dot(const Point2& a, const Point2& b) { return a.x * b.x + a.y * b.y; }
inline double Length(const Point2& a) { return std::sqrt(Dot(a, a)); }

// x, y and height of points against a plane; x to y turns counter-clockwise seen from `normal`.
class PlaneFrame {
 public:
  // `normal` is of length 1.
  PlaneFrame(const Vec3& origin, const Vec3& normal) : origin_(origin), normal_(normal) {
    const Vec3 helper = std::abs(normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    x_ = glm::normalize(glm::cross(helper, normal));
    y_ = glm::cross(normal, x_);
  }

  Point2 Flat(const Vec3& p) const {
    return {glm::dot(p - origin_, x_), glm::dot(p - origin_, y_)};
  }
  double Height(const Vec3& p) const { return glm::dot(p - origin_, normal_); }
  Vec3 Solid(const Point2& p) const { return origin_ + p.x * x_ + p.y * y_; }
  const Vec3& normal() const { return normal_; }

 private:
  Vec3 origin_, normal_, x_, y_;
};

}  // namespace isolux
