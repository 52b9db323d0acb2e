#include "common/scene/triangulate.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

constexpr size_t kChooseBest = 64;  // corners up to which the best ear is looked for

struct Point2 {
  double x = 0, y = 0;
};

// Twice the signed area of a triangle.
double Cross(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double Distance2(const Point2& a, const Point2& b) {
  return (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
}

// Along the mean normal (Newell), in the plane it leaves; counter-clockwise.
std::vector<Point2> Project(std::span<const Vec3> corners) {
  Vec3 normal(0.0);
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    normal += glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  }
  const double length = glm::length(normal);
  normal = length > 0 ? normal / length : Vec3(0, 0, 1);
  const Vec3 helper = std::abs(normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 u = glm::normalize(glm::cross(helper, normal));
  const Vec3 v = glm::cross(normal, u);
  std::vector<Point2> points;
  for (const Vec3& corner : corners) {
    const Vec3 d = corner - corners[0];
    points.push_back({glm::dot(d, u), glm::dot(d, v)});
  }
  return points;
}

class EarClipper {
 public:
  EarClipper(std::vector<Point2> points, std::span<const uint32_t> ids)
      : points_(std::move(points)), ids_(ids) {
    for (uint32_t i = 0; i < points_.size(); ++i) ring_.push_back(i);
    double extent2 = 0;
    for (const Point2& p : points_) extent2 = std::max(extent2, Distance2(p, points_[0]));
    flat_ = 1e-13 * extent2;
    for (size_t i = 1; i + 1 < points_.size(); ++i) {
      area_ += Cross(points_[0], points_[i], points_[i + 1]);
    }
  }

  Triangulation Run() {
    while (ring_.size() > 3) CutOne();
    Emit(0);
    result_.simple = result_.simple && std::abs(covered_ - area_) <= 1e-9 * area_ + flat_;
    return std::move(result_);
  }

 private:
  size_t Before(size_t i) const { return i == 0 ? ring_.size() - 1 : i - 1; }
  size_t After(size_t i) const { return i + 1 == ring_.size() ? 0 : i + 1; }
  const Point2& At(size_t i) const { return points_[ring_[i]]; }
  double Turn(size_t i) const { return Cross(At(Before(i)), At(i), At(After(i))); }

  // Whether no other corner lies in or on the triangle at i, apart from copies of its own corners.
  bool IsFree(size_t i) const {
    const size_t before = Before(i);
    const size_t after = After(i);
    const Point2& a = At(before);
    const Point2& b = At(i);
    const Point2& c = At(after);
    for (size_t k = 0; k < ring_.size(); ++k) {
      if (k == before || k == i || k == after) continue;
      const uint32_t id = ids_[ring_[k]];
      if (id == ids_[ring_[before]] || id == ids_[ring_[i]] || id == ids_[ring_[after]]) continue;
      const Point2& p = At(k);
      if (Cross(a, b, p) >= -flat_ && Cross(b, c, p) >= -flat_ && Cross(c, a, p) >= -flat_) {
        return false;
      }
    }
    return true;
  }

  // Area over squared longest side: what an ear is chosen by.
  double Quality(size_t i) const {
    const Point2& a = At(Before(i));
    const Point2& b = At(i);
    const Point2& c = At(After(i));
    return Turn(i) / std::max({Distance2(a, b), Distance2(b, c), Distance2(c, a)});
  }

  void CutOne() {
    size_t best = ring_.size();
    double best_quality = 0;
    for (size_t i = 0; i < ring_.size(); ++i) {
      const double turn = Turn(i);
      if (std::abs(turn) <= flat_) return Remove(i);  // on a line with its neighbours
      if (turn < 0 || !IsFree(i)) continue;
      if (best < ring_.size() && Quality(i) <= best_quality) continue;
      best = i;
      best_quality = Quality(i);
      if (ring_.size() > kChooseBest) break;
    }
    if (best == ring_.size()) {  // only outlines that cross themselves have no ear
      result_.simple = false;
      best = 0;
      for (size_t i = 1; i < ring_.size(); ++i) {
        if (Turn(i) > Turn(best)) best = i;
      }
    }
    Emit(best);
    Remove(best);
  }

  void Emit(size_t i) {
    const double turn = Turn(i);
    if (turn <= flat_) return;
    covered_ += turn;
    result_.triangles.push_back({ring_[Before(i)], ring_[i], ring_[After(i)]});
  }

  void Remove(size_t i) { ring_.erase(ring_.begin() + static_cast<ptrdiff_t>(i)); }

  std::vector<Point2> points_;
  std::span<const uint32_t> ids_;
  std::vector<uint32_t> ring_;  // corners left
  double flat_ = 0;             // twice an area below which a triangle counts as a line
  double area_ = 0;             // twice that of the polygon
  double covered_ = 0;          // twice that of the triangles
  Triangulation result_;
};

}  // namespace

Triangulation Triangulate(std::span<const Vec3> corners, std::span<const uint32_t> ids) {
  return EarClipper(Project(corners), ids).Run();
}

}  // namespace isolux
