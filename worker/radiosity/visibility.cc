#include "worker/radiosity/visibility.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "common/util/random.h"
#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/slots.h"

namespace isolux {

uint32_t SurfaceFacing(const Tree& tree, uint32_t cluster, int direction, double w) {
  const ClusterFacing& facing = tree.facing();
  double left_m2 = w * facing.area_m2(cluster, direction);
  uint32_t chosen = cluster;
  while (tree.is_cluster(chosen)) {
    const uint32_t above = chosen;
    chosen = kNoNode;
    bool found = false;
    tree.ForEachChild(above, [&](uint32_t child) {
      const double part_m2 =
          tree.is_cluster(child)
              ? facing.part_m2(above, child, direction)
              : tree.area_m2(child) * facing.cosine(tree.node(child).id.surface, direction);
      if (found || !(part_m2 > 0)) return;
      chosen = child;  // the last one, where rounding leaves something
      found = left_m2 < part_m2;
      if (!found) left_m2 -= part_m2;
    });
  }
  return chosen;
}

namespace {

// Of a surface of a cluster, however little it faces the other end's centre: others would have to
// answer for it.
constexpr float kLeastCosine = 0.1F;
// Where no pair of points of a packet faces each other.
constexpr uint64_t kPackets = 4;

// A rank-1 lattice of eight points, shifted at random: stratified in every coordinate.
FloatLanes Stratified(int coordinate, Random& random) {
  constexpr std::array<FloatLanes, 4> kLattice = {{
      {0, .125F, .25F, .375F, .5F, .625F, .75F, .875F},  // generators 1, 3, 5, 7
      {0, .375F, .75F, .125F, .5F, .875F, .25F, .625F},
      {0, .625F, .25F, .875F, .5F, .125F, .75F, .375F},
      {0, .875F, .75F, .625F, .5F, .375F, .25F, .125F},
  }};
  constexpr std::array<int, 6> kGenerator = {0, 1, 2, 3, 1, 2};
  const FloatLanes u = kLattice[kGenerator[coordinate]] + static_cast<float>(random.Unit());
  return Minimum(u - Select(u >= 1.0F, SplatFloat(1), FloatLanes{}), SplatFloat(1 - 0x1p-24F));
}

// Eight points of one end of a link.
struct EndPoints {
  FloatPoints position{}, normal{};
  FloatLanes density = SplatFloat(1);  // of points, up to a factor
  std::array<uint32_t, 8> polygon{};
};

EndPoints PointsOf(const Tree& tree, uint32_t node, int direction, double noise_m, FloatLanes u,
                   FloatLanes v, FloatLanes w) {
  EndPoints points;
  if (!tree.is_cluster(node)) {
    points.position =
        PolygonSampler(DrawnIn(tree.polygon(node), tree.centre(node), noise_m)).At(u, v);
    const Vec3 n = tree.normal(node);
    for (int c = 0; c < 3; ++c) points.normal[c] = SplatFloat(static_cast<float>(n[c]));
    points.polygon.fill(tree.surface_of(node).polygon);
    return points;
  }
  if (!(tree.facing().area_m2(node, direction) > 0)) return points;
  for (int i = 0; i < 8; ++i) {
    const uint32_t surface = SurfaceFacing(tree, node, direction, w[i]);
    const FloatPoints at =
        PolygonSampler(tree.polygon(surface)).At(SplatFloat(u[i]), SplatFloat(v[i]));
    const Vec3 n = tree.normal(surface);
    for (int c = 0; c < 3; ++c) {
      points.position[c][i] = at[c][0];
      points.normal[c][i] = static_cast<float>(n[c]);
    }
    points.density[i] = std::max(kLeastCosine, static_cast<float>(tree.facing().cosine(
                                                   tree.node(surface).id.surface, direction)));
    points.polygon[i] = tree.surface_of(surface).polygon;
  }
  return points;
}

// cosθ_x cosθ_y / d² of eight pairs of points, 1/m²; 0 where they face away.
FloatLanes Kernel(const EndPoints& x, const EndPoints& y) {
  FloatLanes distance2{}, at_x{}, at_y{};
  for (int c = 0; c < 3; ++c) {
    const FloatLanes d = y.position[c] - x.position[c];
    distance2 += d * d;
    at_x += x.normal[c] * d;
    at_y -= y.normal[c] * d;
  }
  const FloatLanes kernel =
      Maximum(at_x / distance2, FloatLanes{}) * Maximum(at_y / distance2, FloatLanes{});
  return Select(distance2 > 0.0F, kernel, FloatLanes{});
}

// Of a packet, by the weights of its rays and the bits of those that pass.
SampledVisibility ShareOf(const FloatLanes& weight, uint32_t traced, uint32_t visible) {
  SampledVisibility result;
  result.traced = std::popcount(traced);
  double total = 0, passed = 0;
  for (int i = 0; i < 8; ++i) {
    if ((traced >> i & 1) != 0) total += weight[i];
    if ((visible >> i & 1) != 0) passed += weight[i];
  }
  if (result.traced == 0) return result;
  result.share = std::clamp(passed / total, 0.0, 1.0);
  // Rays that were not traced say nothing: scale the count to eight.
  result.visible = (std::popcount(visible) * RayScene::kPacket + result.traced / 2) / result.traced;
  return result;
}

void MoveToImage(const Isometry& image, EndPoints& points) {
  for (int i = 0; i < 8; ++i) {
    const auto lane = [&](const FloatPoints& of) { return Vec3(of[0][i], of[1][i], of[2][i]); };
    const Vec3 at = image.Point(lane(points.position));
    const Vec3 n = image.Direction(lane(points.normal));
    for (int c = 0; c < 3; ++c) {
      points.position[c][i] = static_cast<float>(at[c]);
      points.normal[c][i] = static_cast<float>(n[c]);
    }
  }
}

// Of the first packet that has any.
SampledRays SomeRaysBetween(const Tree& tree, const RayScene& rays, uint32_t image, uint32_t p,
                            uint32_t q, uint64_t seed) {
  SampledRays sampled = RaysBetween(tree, rays, image, p, q, seed);
  for (uint64_t k = 1; sampled.packet.valid == 0 && k < kPackets; ++k) {
    sampled = RaysBetween(tree, rays, image, p, q, Hash(seed, k));
  }
  return sampled;
}

}  // namespace

SampledRays RaysBetween(const Tree& tree, const RayScene& rays, uint32_t image, uint32_t p,
                        uint32_t q, uint64_t seed) {
  const NodeId& a = tree.node(p).id;
  const NodeId& b = tree.node(q).id;
  const MirrorImage* through = image == kStraight ? nullptr : &tree.mirrors()->images()[image];
  Random random(Hash(through == nullptr ? seed : Hash(seed, image), Hash(a.surface, a.path),
                     Hash(b.surface, b.path)));
  std::array<FloatLanes, 6> u;
  for (int d = 0; d < 6; ++d) u[d] = Stratified(d, random);
  const double noise_m = rays.coordinate_noise_m();
  const Slots slots(tree);
  const Slots::Ends ends = slots.Of(tree, p, q, through);
  const EndPoints x = PointsOf(tree, p, slots.DirectionOf(ends.p), noise_m, u[0], u[1], u[4]);
  EndPoints y = PointsOf(tree, q, slots.DirectionOf(ends.q), noise_m, u[2], u[3], u[5]);
  if (through != nullptr) MoveToImage(through->image, y);
  // The kernel's peak where the ends touch would leave one ray to decide.
  const auto most = static_cast<float>(1.0 / std::min(tree.area_m2(p), tree.area_m2(q)));
  SampledRays sampled;
  sampled.weight = Minimum(Kernel(x, y), SplatFloat(most)) / (x.density * y.density);
  sampled.packet = {x.position, y.position, x.polygon, y.polygon, 0};
  for (int i = 0; i < 8; ++i) {
    if (through == nullptr && x.polygon[i] == y.polygon[i]) sampled.weight[i] = 0;
    if (sampled.weight[i] > 0) sampled.packet.valid |= 1U << i;
  }
  return sampled;
}

SampledVisibility SampleThrough(const Tree& tree, const RayScene& rays, uint32_t image, uint32_t p,
                                uint32_t q, bool look, uint64_t seed) {
  const auto [packet, weight] = SomeRaysBetween(tree, rays, image, p, q, seed);
  return ShareOf(
      weight, packet.valid,
      VisibleThrough(rays, *tree.mirrors(), tree.mirrors()->images()[image], packet, look));
}

SampledVisibility SampleVisibility(const Tree& tree, const RayScene& rays, uint32_t p, uint32_t q,
                                   uint64_t seed, const Obstacles* known) {
  const auto [packet, weight] = SomeRaysBetween(tree, rays, kStraight, p, q, seed);
  if (packet.valid == 0) return {};
  std::optional<uint32_t> visible;
  if (known != nullptr) {
    visible = known->rays.Passing(packet.from, packet.to, packet.valid, known->candidates,
                                  static_cast<float>(rays.coordinate_noise_m()));
  }
  return ShareOf(weight, packet.valid, visible ? *visible : rays.Visible(packet));
}

}  // namespace isolux
