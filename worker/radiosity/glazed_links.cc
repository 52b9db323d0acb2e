#include "worker/radiosity/glazed_links.h"

#include <algorithm>
#include <array>

#include "common/util/random.h"
#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/visibility.h"

namespace isolux {
namespace {

// Packets of rays to a link behind panes, seeded like those that value it.
constexpr uint64_t kPackets = 2;

struct Corners {
  size_t count = 0;
  std::array<Vec3, 8> v{};
  std::span<const Vec3> points() const { return {v.data(), count}; }
};

Corners CornersOf(const ConvexPolygon& polygon) {
  Corners corners;
  for (int i = 0; i < polygon.count; ++i) corners.v[corners.count++] = polygon.v[i];
  return corners;
}

Corners CornersOf(const Tree& tree, uint32_t node) {
  if (!tree.is_cluster(node)) return CornersOf(tree.polygon(node));
  const Bounds3& box = tree.cluster(node).bounds;
  Corners corners;
  for (int i = 0; i < 8; ++i) {
    corners.v[corners.count++] = {(i & 1) != 0 ? box.high.x : box.low.x,
                                  (i & 2) != 0 ? box.high.y : box.low.y,
                                  (i & 4) != 0 ? box.high.z : box.low.z};
  }
  return corners;
}

const MirrorImage* ImageOf(const Tree& tree, const Link& link) {
  return link.through_mirrors() ? &tree.mirrors()->images()[link.image()] : nullptr;
}

Vec3 PointOf(const FloatPoints& points, int i) {
  return {points[0][i], points[1][i], points[2][i]};
}

}  // namespace

Crossing PanesBetween(const Panes& panes, const Tree& tree, const Link& link) {
  if (link.through_mirrors()) return Crossing::kSome;
  return panes.Between(CornersOf(tree, link.p).points(), CornersOf(tree, link.q).points());
}

Rgb LeftByPanes(const RefineScene& scene, const Tree& tree, const Link& link) {
  const Panes& panes = *scene.panes;
  if (!(link.unoccluded_m2 > 0) || PanesBetween(panes, tree, link) == Crossing::kNone) {
    return Rgb(1.0);
  }
  const MirrorImage* image = ImageOf(tree, link);
  const bool look = scene.occlusion && link.rays() != Link::kProved;
  Rgb passed(0.0);
  double weights = 0;
  for (uint64_t k = 0; k < kPackets; ++k) {
    const uint64_t seed = k == 0 ? Hash(scene.seed, kValue) : Hash(scene.seed, kValue, k);
    const SampledRays sampled = RaysBetween(
        tree, *scene.rays, image == nullptr ? kStraight : link.image(), link.p, link.q, seed);
    const RayPacket& packet = sampled.packet;
    if (packet.valid == 0) continue;
    const uint32_t passing =
        image != nullptr ? VisibleThrough(*scene.rays, *tree.mirrors(), *image, packet, look)
        : look           ? scene.rays->Visible(packet)
                         : packet.valid;
    for (int i = 0; i < RayScene::kPacket; ++i) {
      if ((passing >> i & 1) == 0) continue;
      const Vec3 from = PointOf(packet.from, i), to = PointOf(packet.to, i);
      const double weight = sampled.weight[i];
      weights += weight;
      passed += weight * (image == nullptr ? panes.Along(from, to) : panes.Along(from, to, *image));
    }
  }
  return weights > 0 ? passed / weights : Rgb(1.0);
}

void VaryByPanes(const Panes& panes, const ConvexPolygon& p, const ConvexPolygon& other,
                 const MirrorImage* image, Link* link) {
  const Corners here = CornersOf(p), there = CornersOf(other);
  const Crossing crossing =
      image != nullptr ? Crossing::kSome : panes.Between(here.points(), there.points());
  if (crossing == Crossing::kNone) return;
  Rgb least(1.0), most(0.0);
  const auto probe = [&](const Vec3& x, const Vec3& y) {
    const Rgb left = image == nullptr ? panes.Along(x, y) : panes.Along(x, y, *image);
    least = glm::min(least, left);
    most = glm::max(most, left);
  };
  const Vec3 middle_p = p.Centroid(), middle_q = other.Centroid();
  probe(middle_p, middle_q);
  // Corners lie on the walls that panes touch: looked at from a little inside.
  constexpr double kInside = 0.01;
  for (const Vec3& x : here.points()) {
    for (const Vec3& y : there.points()) {
      probe(x + kInside * (middle_p - x), y + kInside * (middle_q - y));
    }
  }
  const auto largest = [](const Rgb& c) { return std::max({c.x, c.y, c.z}); };
  const double range = largest(most - least);
  const auto area = [](const ConvexPolygon& polygon) { return std::max(polygon.Area(), 1e-300); };
  const auto vary = [&](const ConvexPolygon& polygon, float* variation) {
    *variation = static_cast<float>(largest(most) * *variation +
                                    range * link->unoccluded_m2 / area(polygon));
  };
  vary(p, &link->variation_p);
  vary(other, &link->variation_q);
}

}  // namespace isolux
