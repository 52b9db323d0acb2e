#include "worker/radiosity/couple_through.h"

#include <algorithm>
#include <numbers>

#include "worker/coupling/clip.h"
#include "worker/coupling/coupling.h"
#include "worker/coupling/variation.h"

namespace isolux {
namespace {

// What a coupling may err by, of the smaller end's area.
constexpr double kFinest = 1e-6, kCoarsest = 1e-2;

struct Corners {
  int count = 0;
  std::array<Vec3, 8> v{};
  std::span<const Vec3> points() const { return {v.data(), static_cast<size_t>(count)}; }
};

// Corners of an element, or of a cluster's box.
Corners CornersOf(const Tree& tree, uint32_t node) {
  Corners corners;
  if (!tree.is_cluster(node)) {
    const ConvexPolygon& polygon = tree.polygon(node);
    for (int i = 0; i < polygon.count; ++i) corners.v[corners.count++] = polygon.v[i];
    return corners;
  }
  const Bounds3& box = tree.cluster(node).bounds;
  for (int i = 0; i < 8; ++i) {
    corners.v[corners.count++] = {(i & 1) != 0 ? box.high.x : box.low.x,
                                  (i & 2) != 0 ? box.high.y : box.low.y,
                                  (i & 4) != 0 ? box.high.z : box.low.z};
  }
  return corners;
}

Corners Moved(const Isometry& image, Corners corners) {
  for (Vec3& v : corners.v) v = image.Point(v);
  return corners;
}

Bounds3 BoundsOf(const Corners& corners) {
  Bounds3 bounds;
  for (const Vec3& v : corners.points()) bounds.Add(v);
  return bounds;
}

// The part of an element on one side of all planes of mirrors that it meets: before them, or, of an
// image, behind.
Corners CutBy(const MirrorImage& image, const ConvexPolygon& polygon, double sign,
              double tolerance_m) {
  Corners corners;
  for (int i = 0; i < polygon.count; ++i) corners.v[corners.count++] = polygon.v[i];
  for (const MirrorOpening& opening : image.openings) {
    // Of more corners than clipping takes, what one plane leaves is enough: no proof is lost but a
    // finer one.
    if (corners.count > 4) break;
    ConvexPolygon rest;
    rest.count = corners.count;
    std::copy_n(corners.v.begin(), 4, rest.v.begin());
    if (rest.count < 3) return {};
    const ClippedPolygon cut =
        ClipToFront(rest, opening.height_m * opening.normal, sign * opening.normal, tolerance_m);
    corners.count = cut.count;
    std::copy_n(cut.v.begin(), cut.count, corners.v.begin());
  }
  return corners;
}

double SelfShare(uint32_t p, uint32_t q) { return p == q ? 0.5 : 1.0; }

}  // namespace

double BoundThrough(const Tree& tree, uint32_t image, uint32_t p, uint32_t q) {
  const Mirrors& mirrors = *tree.mirrors();
  const MirrorImage& through = mirrors.images()[image];
  const Corners here = CornersOf(tree, p), there = Moved(through.image, CornersOf(tree, q));
  if (PassageThrough(mirrors, through.openings, here.points(), there.points()) == Passage::kNone)
    return 0;
  // Everything of the other behind an element's plane?
  const auto behind = [](const Corners& points, const Vec3& on, const Vec3& normal) {
    return std::ranges::all_of(points.points(),
                               [&](const Vec3& v) { return glm::dot(normal, v - on) <= 0; });
  };
  if (!tree.is_cluster(p) && behind(there, here.v[0], tree.normal(p))) return 0;
  if (!tree.is_cluster(q) && behind(here, there.v[0], through.image.Direction(tree.normal(q)))) {
    return 0;
  }
  double most = std::min(tree.area_m2(p), tree.area_m2(q));
  for (const MirrorOpening& opening : through.openings) {
    most = std::min(most, mirrors.planes()[opening.plane].area_m2);
  }
  const double distance = Distance(BoundsOf(here), BoundsOf(there));
  if (distance > 0) {
    most = std::min(most,
                    tree.area_m2(p) * tree.area_m2(q) / (std::numbers::pi * distance * distance));
  }
  return SelfShare(p, q) * through.share * most;
}

double ClusterCouplingThrough(const Tree& tree, uint32_t image, uint32_t p, uint32_t q) {
  const MirrorImage& through = tree.mirrors()->images()[image];
  const Vec3 d = through.image.Point(tree.centre(q)) - tree.centre(p);
  const double distance2 = glm::dot(d, d);
  if (!(distance2 > 0)) return 0;
  const auto facing = [&](uint32_t node, const Vec3& towards) {
    return tree.is_cluster(node)
               ? tree.facing().area_m2(node, NearestDirection(towards))
               : tree.area_m2(node) * std::max(0.0, glm::dot(tree.normal(node), towards)) /
                     std::sqrt(distance2);
  };
  const double seen_p = facing(p, d), seen_q = facing(q, through.back.Direction(-d));
  return SelfShare(p, q) * through.share * seen_p * seen_q /
         (std::numbers::pi * distance2 + std::max(seen_p, seen_q));
}

ThroughMirrors CoupleThrough(const Tree& tree, uint32_t image, uint32_t p, uint32_t q,
                             double wanted_m2) {
  const Mirrors& mirrors = *tree.mirrors();
  const MirrorImage& through = mirrors.images()[image];
  const ConvexPolygon there = through.image.Of(tree.polygon(q));
  const double tolerance_m = mirrors.tolerance_m();
  ThroughMirrors result;
  // Nothing passes but from before the mirrors to behind them.
  const Corners before = CutBy(through, tree.polygon(p), 1, tolerance_m);
  const Corners behind = CutBy(through, there, -1, tolerance_m);
  if (before.count < 3 || behind.count < 3) return result;
  result.passage = PassageThrough(mirrors, through.openings, before.points(), behind.points());
  if (result.passage == Passage::kNone) return result;
  const auto uncut = [&](const Corners& corners, const ConvexPolygon& whole) {
    return corners.count == whole.count &&
           std::equal(corners.v.begin(), corners.v.begin() + whole.count, whole.v.begin());
  };
  if (!uncut(before, tree.polygon(p)) || !uncut(behind, there)) result.passage = Passage::kSome;
  const CouplingEnd here = MakeCouplingEnd(tree.polygon(p)), goal = MakeCouplingEnd(there);
  const double smaller_m2 = std::min(here.area_m2, goal.area_m2);
  const PairCoupling coupling =
      Couple(here, goal,
             std::clamp(wanted_m2 / through.share, kFinest * smaller_m2, kCoarsest * smaller_m2));
  if (!(coupling.coupling_m2 > 0)) return result;
  const FormFactorVariation variation =
      VariationWith(RangesOver(here, goal), here, goal, coupling.coupling_m2);
  const double share = SelfShare(p, q) * through.share;
  result.coupling_m2 = share * coupling.coupling_m2;
  result.variation_p = share * variation.over_p;
  result.variation_q = share * variation.over_q;
  return result;
}

}  // namespace isolux
