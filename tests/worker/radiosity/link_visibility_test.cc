// What the rays of a link see, of links whose ends are clusters: most surfaces of a cluster face
// away from the other end.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/hard_scenes.h"
#include "tests/support/shapes.h"
#include "worker/radiosity/cluster_pair.h"
#include "worker/radiosity/visibility.h"

namespace isolux {
namespace {

// Two balls of 320 triangles, ten radii apart, and perhaps a wall between them.
Scene TwoBalls(bool wall) {
  testing::SceneSketch sketch;
  const uint32_t grey = sketch.Material("grey", 0.5);
  for (const double x : {0.0, 10.0}) {
    for (const ConvexPolygon& triangle : testing::Sphere(1, 2, true)) {
      std::vector<Vec3> corners;
      for (int i = 0; i < 3; ++i) corners.push_back(triangle.v[i] + Vec3(x, 0.2 * x, 0.1 * x));
      sketch.Polygon(corners, grey, kFrontTakesPart);
    }
  }
  if (wall) {
    sketch.Rectangle(0, 5, {-20, -20}, {20, 20}, true, grey, testing::kBothTakePart);
  }
  return sketch.Take();
}

// The clusters that hold nothing but one ball, or a part of it.
std::vector<uint32_t> ClustersOfBall(const Hierarchy& hierarchy, const Vec3& centre) {
  std::vector<uint32_t> clusters;
  for (uint32_t c = 0; c < hierarchy.clusters().size(); ++c) {
    const Bounds3& box = hierarchy.clusters()[c].bounds;
    const double far = std::max(glm::length(box.low - centre), glm::length(box.high - centre));
    if (far < 1.8) clusters.push_back(c);
  }
  return clusters;
}

struct Balls {
  explicit Balls(bool wall)
      : scene(TwoBalls(wall)), hierarchy(scene), rays(hierarchy), tree(hierarchy) {
    first = ClustersOfBall(hierarchy, {0, 0, 0});
    second = ClustersOfBall(hierarchy, {10, 2, 1});
  }
  Scene scene;
  Hierarchy hierarchy;
  RayScene rays;
  Tree tree;
  std::vector<uint32_t> first, second;
};

TEST(LinkVisibility, OfClustersThatSeeEachOtherIsWhole) {
  const Balls balls(false);
  ASSERT_GT(balls.first.size(), 8U);
  ASSERT_GT(balls.second.size(), 8U);
  int links = 0;
  for (const uint32_t p : balls.first) {
    for (const uint32_t q : balls.second) {
      // Of those on the sides that face away not even a corner may be seen.
      if (ClusterCoupling(balls.tree, p, q) < 1e-3) continue;
      ++links;
      for (uint64_t seed = 1; seed <= 8; ++seed) {
        const SampledVisibility seen = SampleVisibility(balls.tree, balls.rays, p, q, seed);
        ASSERT_GT(seen.traced, 0) << p << ' ' << q << " seed " << seed;
        ASSERT_EQ(seen.share, 1) << p << ' ' << q << " seed " << seed;
        ASSERT_EQ(seen.visible, 8) << p << ' ' << q << " seed " << seed;
      }
    }
  }
  EXPECT_GT(links, 16);
}

TEST(LinkVisibility, OfClustersBehindAWallIsNone) {
  const Balls balls(true);
  ASSERT_GT(balls.first.size(), 8U);
  for (const uint32_t p : balls.first) {
    for (const uint32_t q : balls.second) {
      const SampledVisibility seen = SampleVisibility(balls.tree, balls.rays, p, q, 1);
      ASSERT_EQ(seen.share, 0);
      ASSERT_EQ(seen.visible, 0);
    }
  }
}

TEST(LinkVisibility, DrawsSurfacesAsTheyFace) {
  const Balls balls(false);
  const Tree& tree = balls.tree;
  constexpr int kDraws = 20000;
  for (int direction = 0; direction < kDirections; ++direction) {
    std::vector<int> drawn(balls.hierarchy.surfaces().size(), 0);
    for (int i = 0; i < kDraws; ++i) {
      const uint32_t node = SurfaceFacing(tree, 0, direction, (i + 0.5) / kDraws);
      ++drawn[tree.node(node).id.surface];
    }
    const double all_m2 = tree.facing().area_m2(0, direction);
    for (uint32_t s = 0; s < drawn.size(); ++s) {
      const double share =
          balls.hierarchy.surface_area_m2(s) * tree.facing().cosine(s, direction) / all_m2;
      ASSERT_NEAR(drawn[s], share * kDraws, 1.001) << "surface " << s << " direction " << direction;
    }
  }
}

}  // namespace
}  // namespace isolux
