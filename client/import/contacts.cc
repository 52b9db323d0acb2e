#include "client/import/contacts.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/planes.h"

namespace isolux {
namespace {

std::vector<Bounds3> BoxesOf(const Scene& scene) {
  std::vector<Bounds3> boxes;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) boxes.push_back(BoundsOf(scene, p));
  for (size_t i = 0; i < scene.glazing.panes.size(); ++i) {
    const ConvexPolygon shape = ShapeOf(scene, static_cast<uint32_t>(boxes.size()));
    Bounds3 box;
    for (int k = 0; k < shape.count; ++k) box.Add(shape.v[k]);
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace

ContactFinder::ContactFinder(const Scene& scene)
    : scene_(scene), extent_(ExtentOf(scene)), boxes_(BoxesOf(scene)), tree_(boxes_) {}

std::vector<CutSegment> ContactFinder::Of(uint32_t polygon) const {
  const ConvexPolygon shape = SideGeometry(scene_, polygon, Side::kFront);
  const double size = boxes_[polygon].Diagonal();
  const Vec3 normal = shape.Normal(), point = shape.Centroid();
  std::vector<CutSegment> segments;
  tree_.ForEachOverlap(Widened(boxes_[polygon], ContactTolerance(extent_, size)),
                       [&](uint32_t other) {
                         if (other != polygon) AddFrom(other, point, normal, size, &segments);
                       });
  return segments;
}

void ContactFinder::AddFrom(uint32_t other, const Vec3& point, const Vec3& normal, double size,
                            std::vector<CutSegment>* segments) const {
  const double tolerance = ContactTolerance(extent_, std::min(size, boxes_[other].Diagonal()));
  const ConvexPolygon shape = ShapeOf(scene_, other);
  std::array<double, 4> height{};
  bool above = false, below = false;
  for (int i = 0; i < shape.count; ++i) {
    height[i] = glm::dot(normal, shape.v[i] - point);
    above |= height[i] > tolerance;
    below |= height[i] < -tolerance;
  }
  if (!(above && below)) {
    for (int i = 0; i < shape.count; ++i) {
      const int next = (i + 1) % shape.count;
      if (std::abs(height[i]) > tolerance || std::abs(height[next]) > tolerance) continue;
      segments->push_back({shape.v[i], shape.v[next], false});
    }
    return;
  }
  // A convex outline crosses the plane twice: in corners that lie in it or between corners.
  std::vector<Vec3> crossings;
  for (int i = 0; i < shape.count; ++i) {
    const int next = (i + 1) % shape.count;
    const double a = height[i], b = height[next];
    if (std::abs(a) <= tolerance) crossings.push_back(shape.v[i]);
    if ((a > tolerance && b < -tolerance) || (a < -tolerance && b > tolerance)) {
      crossings.push_back(shape.v[i] + a / (a - b) * (shape.v[next] - shape.v[i]));
    }
  }
  if (crossings.size() == 2) segments->push_back({crossings[0], crossings[1], true});
}

}  // namespace isolux
