#include "worker/radiosity/transmission.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/element.h"
#include "worker/coupling/coupling.h"

namespace isolux {
namespace {

// Pairs nearer than this for their size, (r_p + r_q)/d, are divided, and those whose optical
// lengths differ by more; unless what that may change is below this share of the whole coupling.
constexpr double kNear = 0.5, kLongest = 1.0, kWorthwhile = 2e-3;
constexpr int kDeepest = 12;
// What couplings of parts may err by, of the smaller: they are weights.
constexpr double kCouplingTolerance = 1e-3;

struct Node {
  double at, weight;
};
// Gauss–Legendre with three points on [0, 1].
constexpr std::array<Node, 3> kGauss = {
    {{0.1127016653792583, 5.0 / 18}, {0.5, 8.0 / 18}, {0.8872983346207417, 5.0 / 18}}};

struct PointOfArea {
  Vec3 at{0.0};
  double area_m2 = 0;
};

// Nine points of a polygon, a triangle as a quad of which one side has no length.
std::array<PointOfArea, 9> PointsOf(const ConvexPolygon& polygon) {
  const Vec3 &a = polygon.v[0], &b = polygon.v[1], &c = polygon.v[2];
  const Vec3& d = polygon.count == 4 ? polygon.v[3] : polygon.v[0];
  std::array<PointOfArea, 9> points;
  for (size_t i = 0; i < 9; ++i) {
    const auto [u, wu] = kGauss[i % 3];
    const auto [v, wv] = kGauss[i / 3];
    const Vec3 along_u = (1 - v) * (b - a) + v * (c - d);
    const Vec3 along_v = (1 - u) * (d - a) + u * (c - b);
    points[i] = {(1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d,
                 wu * wv * glm::length(glm::cross(along_u, along_v))};
  }
  return points;
}

// The mean over pairs of points of both.
Rgb AtPoints(const Medium& medium, const CouplingEnd& p, const CouplingEnd& q) {
  const auto here = PointsOf(*p.polygon), there = PointsOf(*q.polygon);
  Rgb sum(0.0);
  double weights = 0;
  for (const PointOfArea& x : here) {
    for (const PointOfArea& y : there) {
      const Vec3 d = y.at - x.at;
      const double cosines = std::max(0.0, glm::dot(p.normal, d)) *  //
                             std::max(0.0, -glm::dot(q.normal, d));
      if (!(cosines > 0)) continue;
      const double distance2 = glm::dot(d, d);
      const double weight = x.area_m2 * y.area_m2 * cosines / (distance2 * distance2);
      weights += weight;
      sum += weight * medium.Along(std::sqrt(distance2));
    }
  }
  return weights > 0 ? sum / weights : medium.Along(glm::length(q.centre - p.centre));
}

class Pairs {
 public:
  explicit Pairs(const Medium& medium) : medium_(medium) {}

  Rgb Mean(const CouplingEnd& p, const CouplingEnd& q) {
    whole_m2_ = std::numeric_limits<double>::infinity();
    if (IsSimple(p, q)) return AtPoints(medium_, p, q);
    whole_m2_ = CouplingOf(p, q);
    if (!(whole_m2_ > 0)) return Rgb(1.0);
    Add(p, q, whole_m2_, 0);
    return weights_m2_ > 0 ? sum_ / weights_m2_ : AtPoints(medium_, p, q);
  }

 private:
  static double CouplingOf(const CouplingEnd& p, const CouplingEnd& q) {
    return Couple(p, q, kCouplingTolerance * std::min(p.area_m2, q.area_m2)).coupling_m2;
  }

  // Far apart, with ways of about the same length.
  bool IsSimple(const CouplingEnd& p, const CouplingEnd& q) const {
    const double reach = p.radius_m + q.radius_m;
    return reach < kNear * glm::length(q.centre - p.centre) &&
           2 * reach * medium_.largest_per_m() < kLongest;
  }

  void Add(const CouplingEnd& p, const CouplingEnd& q, double coupling_m2, int depth) {
    const double range = 2 * (p.radius_m + q.radius_m) * medium_.largest_per_m();
    if (depth == kDeepest || IsSimple(p, q) ||
        coupling_m2 * std::min(1.0, range) <
            kWorthwhile * whole_m2_ * std::min(1.0, whole_range_)) {
      weights_m2_ += coupling_m2;
      sum_ += coupling_m2 * AtPoints(medium_, p, q);
      return;
    }
    if (depth == 0) whole_range_ = range;
    const bool divide_p = p.radius_m >= q.radius_m;
    for (const ConvexPolygon& half : Subdivide(divide_p ? *p.polygon : *q.polygon)) {
      const CouplingEnd part = MakeCouplingEnd(half);
      const CouplingEnd &a = divide_p ? part : p, &b = divide_p ? q : part;
      const double of_part_m2 = CouplingOf(a, b);
      if (of_part_m2 > 0) Add(a, b, of_part_m2, depth + 1);
    }
  }

  const Medium& medium_;
  double whole_m2_ = 0, whole_range_ = 0;
  double weights_m2_ = 0;
  Rgb sum_{0.0};
};

}  // namespace

Rgb MeanTransmission(const Medium& medium, const ConvexPolygon& p, const ConvexPolygon& q) {
  return Pairs(medium).Mean(MakeCouplingEnd(p), MakeCouplingEnd(q));
}

Rgb TransmissionOf(const Medium& medium, const Tree& tree, const Link& link) {
  const Isometry* image =
      link.through_mirrors() ? &tree.mirrors()->images()[link.image()].image : nullptr;
  if (tree.is_cluster(link.p) || tree.is_cluster(link.q)) {
    const Vec3 there = tree.centre(link.q);
    return medium.Along(
        glm::length((image == nullptr ? there : image->Point(there)) - tree.centre(link.p)));
  }
  if (image == nullptr) {
    return MeanTransmission(medium, tree.polygon(link.p), tree.polygon(link.q));
  }
  return MeanTransmission(medium, tree.polygon(link.p), image->Of(tree.polygon(link.q)));
}

void VaryByMedium(const Medium& medium, const ConvexPolygon& p, const ConvexPolygon& other,
                  Link* link) {
  const CouplingEnd here = MakeCouplingEnd(p), there = MakeCouplingEnd(other);
  const double shortest_m =
      std::max(0.0, glm::length(there.centre - here.centre) - here.radius_m - there.radius_m);
  const Rgb& extinction = medium.extinction_per_m;
  const double least = std::min({extinction.x, extinction.y, extinction.z});
  const double most_left = ExpOfMinus(least * shortest_m);
  const auto vary = [&](const CouplingEnd& end, float* variation) {
    double range = 0;
    for (int c = 0; c < 3; ++c) {
      const double of_channel = ExpOfMinus(extinction[c] * shortest_m) *
                                (1 - ExpOfMinus(2 * extinction[c] * end.radius_m));
      range = std::max(range, of_channel);
    }
    *variation =
        static_cast<float>(most_left * *variation + range * link->unoccluded_m2 / end.area_m2);
  };
  vary(here, &link->variation_p);
  vary(there, &link->variation_q);
}

}  // namespace isolux
