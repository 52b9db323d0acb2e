// Points in a penumbra, gathered through coarse links: each gets rays of its own, as many as make
// it sure. Against the part of the lamp that is seen past an edge, in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/surface_points.h"
#include "worker/shard.h"

namespace isolux {
namespace {

constexpr double kHeight = 1, kEdgeHeight = 0.5, kHalf = 0.2, kExitance = 100;

// A square lamp over a black floor, and halfway a card over x < 0.
Scene LampAndCard() {
  testing::SceneSketch sketch;
  const uint32_t black = sketch.Material("black", 0), lamp = sketch.Material("lamp", 0, kExitance);
  sketch.Rectangle(2, 0, {-2, -2}, {2, 2}, true, black, kFrontTakesPart);
  sketch.Rectangle(2, kEdgeHeight, {-2, -2}, {0, 2}, true, black, testing::kBothTakePart);
  sketch.Rectangle(2, kHeight, {-kHalf, -kHalf}, {kHalf, kHalf}, false, lamp,
                   kFrontTakesPart | kFrontEmits);
  return sketch.Take();
}

// Form factor from a point to a parallel rectangle, of which it lies under a corner ([Howell]
// B-3).
double UnderCorner(double x, double y, double z) {
  const double a = std::hypot(x, z), b = std::hypot(y, z);
  return (x / a * std::atan(y / a) + y / b * std::atan(x / b)) / (2 * std::numbers::pi);
}

// To the lamp's part from `from` on along x.
double Factor(const Vec3& point, double from) {
  const auto corner = [&](double x, double y) {
    return UnderCorner(x - point.x, y - point.y, kHeight);
  };
  if (from >= kHalf) return 0;
  return corner(kHalf, kHalf) - corner(from, kHalf) - corner(kHalf, -kHalf) + corner(from, -kHalf);
}

double Seen(const Vec3& point) {
  const double past = -point.x * kEdgeHeight / (kHeight - kEdgeHeight);
  return kExitance * Factor(point, std::clamp(past, -kHalf, kHalf));
}

struct Penumbra {
  double deviation = 0, bias = 0;  // over the irradiance of the unhidden lamp there
  double rays = 0;                 // a point
};

Penumbra Gather(double accuracy, double low, double high) {
  const auto scene = std::make_shared<const Scene>(LampAndCard());
  const Hierarchy hierarchy(*scene);
  uint32_t floor = 0;
  while (hierarchy.surfaces()[floor].polygon != 0) ++floor;
  ThreadPool pool(2);
  Shard shard(scene, &pool);
  SolveOptions options;
  options.accuracy = accuracy;
  EXPECT_TRUE(shard.Start(options, {{{NodeId::kCluster, 0}}, {0}, 1}, 0).ok());
  NullExchange exchange;
  for (const double share : {0.02, 0.1 * accuracy}) {
    EXPECT_TRUE(shard.RunRound(share * Sum(shard.EmittedPower()), accuracy, exchange).has_value());
    EXPECT_TRUE(shard.InstallSnapshot(shard.TakeSnapshot()).ok());
  }
  Random random(3);
  std::vector<NodeId> ids;
  while (ids.size() < 400) {
    const NodeId id{floor, (1ULL << 40) | random.Bits() >> 24};
    const Vec3 at = ElementGeometry(hierarchy.geometry(floor), id.path).Centroid();
    if (at.x > low && at.x < high && std::abs(at.y) < 0.5) ids.push_back(id);
  }
  std::sort(ids.begin(), ids.end());
  const GatherPart part = shard.Gather(ids, std::vector<uint8_t>(ids.size(), 1), accuracy).value();
  Penumbra found;
  for (size_t i = 0; i < ids.size(); ++i) {
    const Vec3 at = ElementGeometry(hierarchy.geometry(floor), ids[i].path).Centroid();
    const double h = testing::IrradianceOf(part, i).x, whole = kExitance * Factor(at, -kHalf);
    const double off = (h - Seen(at)) / whole;
    found.deviation += off * off / static_cast<double>(ids.size());
    found.bias += off / static_cast<double>(ids.size());
  }
  found.deviation = std::sqrt(found.deviation);
  found.rays = static_cast<double>(part.rays) / static_cast<double>(ids.size());
  std::printf("accuracy %.3f, x from %.1f to %.1f: deviation %.4f, bias %+.4f, %.1f rays a point\n",
              accuracy, low, high, found.deviation, found.bias, found.rays);
  return found;
}

TEST(Penumbra, IsAsSmoothAsTheAccuracyAsked) {
  for (const double accuracy : {0.1, 0.05, 0.02}) {
    const Penumbra within = Gather(accuracy, -kHalf, kHalf);
    EXPECT_LT(within.deviation, accuracy);
    EXPECT_LT(std::abs(within.bias), 0.2 * accuracy);
    // Out of it rays agree, and no more follow.
    const Penumbra outside = Gather(accuracy, 0.3, 1.2);
    EXPECT_LT(outside.deviation, 0.2 * accuracy);
    EXPECT_LE(outside.rays, 16);
    const Penumbra shadow = Gather(accuracy, -1.2, -0.3);
    EXPECT_LT(shadow.deviation, 0.2 * accuracy);
    EXPECT_LE(shadow.rays, 16);
  }
}

}  // namespace
}  // namespace isolux
