#include "worker/coupling/coupling.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/coupling/clip.h"
#include "worker/coupling/contour.h"
#include "worker/coupling/facing.h"
#include "worker/coupling/rules.h"

namespace isolux {
namespace {

// The order in which a pair is evaluated: the smaller first, whatever the caller's order.
bool Before(const CouplingEnd& p, const CouplingEnd& q) {
  if (p.area_m2 != q.area_m2) return p.area_m2 < q.area_m2;
  for (int i = 0; i < std::min(p.polygon->count, q.polygon->count); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double a = p.polygon->v[i][axis], b = q.polygon->v[i][axis];
      if (a != b) return a < b;
    }
  }
  return false;
}

// A pair about the centre of the smaller, whose corners keep all their digits then, in a unit of
// length that makes the pair's extent one to two: what is left of each polygon in front of the
// other's plane.
class LocalPair {
 public:
  LocalPair(const CouplingEnd& p, const CouplingEnd& q, double tolerance_m) : centre_(p.centre) {
    double extent = 0;
    for (const CouplingEnd* end : {&p, &q}) {
      for (int i = 0; i < end->polygon->count; ++i) {
        extent = std::max(extent, glm::length(end->polygon->v[i] - centre_));
      }
    }
    int exponent = 0;
    std::frexp(extent, &exponent);
    unit_m_ = std::ldexp(1.0, exponent - 1);
    const ConvexPolygon local_p = Localize(*p.polygon), local_q = Localize(*q.polygon);
    part_[0] = ClipToFront(local_p, local_q.v[0], q.normal, tolerance_m / unit_m_);
    part_[1] = ClipToFront(local_q, local_p.v[0], p.normal, tolerance_m / unit_m_);
    shape_[0] = MakeShape(p, part_[0]);
    shape_[1] = MakeShape(q, part_[1]);
    if (shape_[1].area < shape_[0].area) std::swap(shape_[0], shape_[1]);
  }
  LocalPair(const LocalPair&) = delete;
  LocalPair& operator=(const LocalPair&) = delete;

  double unit_m() const { return unit_m_; }
  bool Empty() const { return !(shape_[0].area > 0); }
  const Shape& smaller() const { return shape_[0]; }
  const Shape& larger() const { return shape_[1]; }

 private:
  ConvexPolygon Localize(const ConvexPolygon& polygon) const {
    ConvexPolygon local = polygon;
    for (int i = 0; i < local.count; ++i) local.v[i] = (local.v[i] - centre_) / unit_m_;
    return local;
  }

  static Shape MakeShape(const CouplingEnd& end, const ClippedPolygon& part) {
    Shape shape;
    if (part.count == 0) return shape;
    shape.corners = part.corners();
    shape.normal = end.normal;
    Vec3 moment(0.0);
    for (int i = 1; i + 1 < part.count; ++i) {
      const Vec3 a = part.v[i] - part.v[0], b = part.v[i + 1] - part.v[0];
      const double area = 0.5 * glm::dot(end.normal, glm::cross(a, b));
      shape.area += area;
      moment += area / 3 * (a + b);
    }
    if (!(shape.area > 0)) return {};
    shape.centre = part.v[0] + moment / shape.area;
    for (const Vec3& v : shape.corners) {
      shape.radius = std::max(shape.radius, glm::length(v - shape.centre));
    }
    return shape;
  }

  Vec3 centre_;
  double unit_m_ = 1;
  ClippedPolygon part_[2];
  Shape shape_[2];
};

PairCoupling CoupleNear(const CouplingEnd& p, const CouplingEnd& q, double tolerance_m,
                        double tolerance_m2) {
  const LocalPair pair(p, q, tolerance_m);
  if (pair.Empty()) return {};
  const double unit_m2 = pair.unit_m() * pair.unit_m();
  const double tolerance = tolerance_m2 / unit_m2;
  const Shape& smaller = pair.smaller();
  PairCoupling result;
  if (!TryKernelRules(smaller, pair.larger(), tolerance, result) &&
      !TryPointRules(smaller, pair.larger(), tolerance, result)) {
    const ContourIntegral integral =
        IntegrateContours(smaller.corners, pair.larger().corners, tolerance);
    result = {integral.coupling, integral.error, Regime::kContour, integral.pieces};
  }
  const double most_m2 = std::min(p.area_m2, q.area_m2);
  result.coupling_m2 = std::clamp(result.coupling_m2 * unit_m2, 0.0, most_m2);
  result.error_m2 = std::min(result.error_m2 * unit_m2, most_m2);
  return result;
}

}  // namespace

CouplingEnd MakeCouplingEnd(const ConvexPolygon& polygon) {
  CouplingEnd end;
  end.polygon = &polygon;
  const Vec3 area = polygon.AreaVector();
  end.area_m2 = glm::length(area);
  end.normal = end.area_m2 > 0 ? area / end.area_m2 : Vec3(0.0, 0.0, 1.0);
  end.centre = polygon.Centroid();
  for (int i = 0; i < polygon.count; ++i) {
    end.radius_m = std::max(end.radius_m, glm::length(polygon.v[i] - end.centre));
  }
  return end;
}

PairCoupling Couple(const CouplingEnd& first, const CouplingEnd& second, double tolerance_m2) {
  const bool ordered = !Before(second, first);
  const CouplingEnd& p = ordered ? first : second;
  const CouplingEnd& q = ordered ? second : first;
  const double tolerance_m = PlaneTolerance(p, q);
  const Facing q_facing = FacingOf(q, p, tolerance_m);
  if (q_facing == Facing::kBehind) return {};
  const Facing p_facing = FacingOf(p, q, tolerance_m);
  if (p_facing == Facing::kBehind) return {};
  if (q_facing == Facing::kFront && p_facing == Facing::kFront) {
    const auto shape = [](const CouplingEnd& end) -> Shape {
      return {{end.polygon->v.data(), static_cast<size_t>(end.polygon->count)},
              end.normal,
              end.centre,
              end.area_m2,
              end.radius_m};
    };
    PairCoupling result;
    if (TryKernelRules(shape(p), shape(q), tolerance_m2, result) ||
        TryPointRules(shape(p), shape(q), tolerance_m2, result)) {
      result.coupling_m2 = std::min(result.coupling_m2, p.area_m2);
      return result;
    }
  }
  return CoupleNear(p, q, tolerance_m, tolerance_m2);
}

}  // namespace isolux
