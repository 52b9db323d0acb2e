// What points see of sources, exactly: against symmetry and against rays.
#include "worker/radiosity/exact_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/util/random.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/scenes.h"
#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {
namespace {

std::span<const Vec3> CornersOf(const ConvexPolygon& polygon) {
  return {polygon.v.data(), static_cast<size_t>(polygon.count)};
}

// A lamp over a floor, and between them a sheet over the half x < 0.5. In the lamp's plane, as its
// coordinates may be rounded, a sheet that covers it.
TEST(ExactView, SeesHalfPastAnEdge) {
  testing::SceneSketch sketch;
  const uint32_t grey = sketch.Material("grey", 0.5);
  sketch.Rectangle(2, 0, {0, 0}, {1, 1}, true, grey, kFrontTakesPart);
  sketch.Rectangle(2, 1, {0.25, 0.25}, {0.75, 0.75}, false, grey, kFrontTakesPart);
  sketch.Rectangle(2, 0.5, {0, 0}, {0.5, 1}, true, grey, testing::kBothTakePart);
  sketch.Rectangle(2, 1 - 1e-7, {0.2, 0.2}, {0.8, 0.8}, true, grey, testing::kBothTakePart);
  const Scene scene = sketch.Take();
  const Hierarchy hierarchy(scene);
  ASSERT_EQ(hierarchy.plane_of(1), hierarchy.plane_of(3));
  const LinkProver prover(hierarchy);
  ExactView view(prover);
  const ConvexPolygon floor = ShapeOf(scene, 0), lamp = ShapeOf(scene, 1);
  const ExactView::Source source{CornersOf(lamp), {0, 0, -1}, 1};
  view.SetLeaf(7, floor, {0, 0, 1}, 0);
  ViewFromLeaf known;
  const auto share = [&](double x) { return view.ShareSeen({x, 0.5, 0}, source, &known); };
  EXPECT_NEAR(share(0.5).value(), 0.5, 1e-12);
  EXPECT_EQ(share(0.8).value(), 1);  // past the sheet's edge to the lamp's
  EXPECT_EQ(share(0.2).value(), 0);
  EXPECT_NEAR(share(0.4).value() + share(0.6).value(), 1, 1e-12);
  // Known of one leaf, it is not taken for that of another.
  const ConvexPolygon dark{4, {{{0, 0, 0}, {0.2, 0, 0}, {0.2, 1, 0}, {0, 1, 0}}}};
  view.SetLeaf(8, dark, {0, 0, 1}, 0);
  EXPECT_EQ(share(0.1).value(), 0);
  view.SetLeaf(7, floor, {0, 0, 1}, 0);
  EXPECT_NEAR(share(0.5).value(), 0.5, 1e-12);
}

TEST(ExactView, AgreesWithRays) {
  const Scene scene = testing::CornellBox(true);
  const Hierarchy hierarchy(scene);
  const RayScene rays(hierarchy);
  const Tree tree(hierarchy);
  const LinkProver prover(hierarchy);
  ExactView view(prover);
  constexpr uint64_t kSeed = 11;
  Random random(kSeed);
  const auto surfaces = static_cast<uint32_t>(hierarchy.surfaces().size());
  int looked_at = 0, answered = 0, partly = 0;
  for (int pair = 0; pair < 4000; ++pair) {
    const uint32_t p = tree.SurfaceIndex(random.Bits() % surfaces);
    const uint32_t q = tree.SurfaceIndex(random.Bits() % surfaces);
    const ConvexPolygon inside = DrawnIn(tree.polygon(p), rays.coordinate_noise_m());
    const double u = random.Unit();
    const Vec3 point = SamplePolygon(inside, u, random.Unit());
    const Vec3 n = tree.normal(p), m = tree.normal(q);
    const auto front = CornersOf(tree.polygon(q));
    const bool before = std::all_of(front.begin(), front.end(), [&](const Vec3& corner) {
      return glm::dot(n, corner - point) >= 0;
    });
    if (p == q || !before || glm::dot(m, point - front[0]) <= 1e-3) continue;
    view.SetLeaf(p, tree.polygon(p), n, tree.surface_of(p).polygon);
    ViewFromLeaf known;
    const auto seen = view.ShareSeen(point, {front, m, tree.surface_of(q).polygon}, &known);
    ++looked_at;
    if (!seen) continue;  // more obstacles than it takes
    ++answered;
    double total = 0, passed = 0, squares = 0;
    for (int ray = 0; ray < 1000; ++ray) {
      const double v = random.Unit();
      const Vec3 to =
          SamplePolygon(DrawnIn(tree.polygon(q), rays.coordinate_noise_m()), v, random.Unit());
      const Vec3 d = to - point;
      const double distance2 = glm::dot(d, d);
      const double weight =
          std::max(0.0, glm::dot(n, d) * -glm::dot(m, d)) / (distance2 * distance2);
      total += weight;
      squares += weight * weight;
      const Segment segment{point, to, tree.surface_of(p).polygon, tree.surface_of(q).polygon};
      if (rays.Visible(segment)) passed += weight;
    }
    const double deviation = std::sqrt(0.25 * squares) / total;
    EXPECT_NEAR(*seen, passed / total, 4 * deviation) << "pair " << pair;
    partly += *seen > 0.01 && *seen < 0.99 ? 1 : 0;
  }
  EXPECT_GT(answered, 0.95 * looked_at);
  EXPECT_GT(partly, 50);
}

}  // namespace
}  // namespace isolux
