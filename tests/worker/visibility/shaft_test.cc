// Verdicts of shafts against segments tested one by one, in random scenes: "visible" and "hidden"
// are proofs, so not one segment may contradict them.
#include "worker/visibility/shaft.h"

#include <gtest/gtest.h>

#include "tests/support/polygons.h"
#include "worker/coupling/clip.h"
#include "worker/visibility/occluder_tree.h"

namespace isolux {
namespace {

using testing::AxisRectangle;
using testing::CornersOf;

// Whether the segment crosses the polygon further than `margin` inside its border: written
// independently of the library, by the signs of volumes.
bool Crosses(std::span<const Vec3> polygon, const Vec3& x, const Vec3& y, double margin) {
  Vec3 area(0.0);
  for (size_t i = 2; i < polygon.size(); ++i) {
    area += glm::cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  }
  const Vec3 n = glm::normalize(area);
  const double hx = glm::dot(n, x - polygon[0]), hy = glm::dot(n, y - polygon[0]);
  if (!(hx * hy < 0)) return false;
  const Vec3 c = x + hx / (hx - hy) * (y - x);
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    if (glm::dot(glm::cross(b - a, c - a), n) < margin * glm::length(b - a)) return false;
  }
  return true;
}

struct Pair {
  ConvexPolygon p, q;
  ClippedPolygon p_front, q_front;
};

// Two polygons that can see each other; false where they cannot.
bool MakePair(Random& random, bool lattice, Pair* pair) {
  const auto polygon = [&] {
    if (lattice) return testing::LatticePolygon(random);
    const Vec3 centre = testing::RandomPoint(random, Vec3(0.0), Vec3(1.0));
    const double radius = 0.02 + 0.5 * random.Unit() * random.Unit();
    const int corners = random.Unit() < 0.3 ? 3 : 4;
    return testing::ToPolygon(testing::RandomConvexPolygon(random, centre, radius, corners));
  };
  pair->p = polygon();
  pair->q = polygon();
  pair->p_front = ClipToFront(pair->p, pair->q.v[0], pair->q.Normal(), 1e-12);
  pair->q_front = ClipToFront(pair->q, pair->p.v[0], pair->p.Normal(), 1e-12);
  return pair->p_front.count > 0 && pair->q_front.count > 0;
}

ShaftEnd End(const ClippedPolygon& front, const ConvexPolygon& whole) {
  return {{front.v.data(), static_cast<size_t>(front.count)}, whole.Normal()};
}

TEST(ShaftTest, NoSegmentContradictsAVerdict) {
  uint64_t segments = 0;
  std::array<uint64_t, 3> verdicts{};
  for (uint64_t seed = 1; seed <= 400; ++seed) {
    Random random(Hash(seed, 17));
    const bool lattice = seed % 2 == 0;
    std::vector<std::vector<Vec3>> shapes;
    OccluderSet set(std::sqrt(3.0));
    for (int i = 0; i < 12; ++i) {
      const Vec3 centre = testing::RandomPoint(random, Vec3(0.0), Vec3(1.0));
      const double radius = 0.05 + 0.8 * random.Unit() * random.Unit();
      const int corners = 3 + static_cast<int>(random.Bits() % 14);
      shapes.push_back(testing::RandomConvexPolygon(random, centre, radius, corners));
      if (lattice && i % 3 != 0) {
        const ConvexPolygon shape = testing::LatticePolygon(random);
        shapes.back().assign(shape.v.begin(), shape.v.begin() + shape.count);
      }
      set.Add(shapes.back());
    }
    for (int k = 0; k < 40; ++k) {
      Pair pair;
      if (!MakePair(random, lattice, &pair)) continue;
      const ShaftEnd p = End(pair.p_front, pair.p), q = End(pair.q_front, pair.q);
      const Shaft shaft(p, q, set.tolerance_m());
      for (uint32_t i = 0; i < set.size(); ++i) {
        const Verdict verdict = shaft.Classify(set, set[i]);
        ++verdicts[static_cast<size_t>(verdict)];
        if (verdict == Verdict::kPartial) continue;
        for (int s = 0; s < 48; ++s) {
          const Vec3 x = testing::PointOn(p.corners, random);
          const Vec3 y = testing::PointOn(q.corners, random);
          ++segments;
          const bool outside = verdict == Verdict::kOutside;
          ASSERT_NE(Crosses(shapes[i], x, y, outside ? 1e-10 : -1e-10), outside)
              << "seed " << seed << ", pair " << k << ", occluder " << i;
        }
      }
    }
  }
  std::printf(
      "%llu segments; verdicts: %llu outside, %llu block, %llu partial\n",
      static_cast<unsigned long long>(segments), static_cast<unsigned long long>(verdicts[0]),
      static_cast<unsigned long long>(verdicts[1]), static_cast<unsigned long long>(verdicts[2]));
  EXPECT_GT(segments, 1'000'000U);
  for (const uint64_t count : verdicts) EXPECT_GT(count, 200U);
}

// A verdict of "partial" claims nothing, but most of them should be deserved: the hull is exact.
TEST(ShaftTest, PartialIsRarelySaidInVain) {
  uint64_t partial = 0, vain = 0;
  for (uint64_t seed = 1; seed <= 1000; ++seed) {
    Random random(Hash(seed, 23));
    Pair pair;
    if (!MakePair(random, false, &pair)) continue;
    const ShaftEnd p = End(pair.p_front, pair.p), q = End(pair.q_front, pair.q);
    for (int i = 0; i < 20; ++i) {
      const auto shape = testing::RandomConvexPolygon(
          random, testing::RandomPoint(random, Vec3(0.0), Vec3(1.0)), 0.3 * random.Unit(), 4);
      OccluderSet set(std::sqrt(3.0));
      set.Add(shape);
      if (Shaft(p, q, set.tolerance_m()).Classify(set, set[0]) != Verdict::kPartial) continue;
      int crossed = 0;
      for (int s = 0; s < 2000; ++s) {
        crossed += Crosses(shape, testing::PointOn(p.corners, random),
                           testing::PointOn(q.corners, random), 0)
                       ? 1
                       : 0;
      }
      ++partial;
      if (crossed == 0 || crossed == 2000) ++vain;
    }
  }
  EXPECT_GT(partial, 100U);
  EXPECT_LT(static_cast<double>(vain), 0.3 * static_cast<double>(partial)) << partial;
}

// The two signs of the tolerance: what only touches the shaft does not block.
TEST(ShaftTest, TouchingIsOutside) {
  const ConvexPolygon floor = AxisRectangle(2, 0, 0, 1, 0, 1, true);
  const ConvexPolygon ceiling = AxisRectangle(2, 1, 0, 1, 0, 1, false);
  OccluderSet set(2);
  set.Add(CornersOf(AxisRectangle(0, 1, -1, 2, -1, 2, true)));     // a wall along the side
  set.Add(CornersOf(AxisRectangle(2, 0, -1, 2, -1, 2, true)));     // the floor's own plane
  set.Add(CornersOf(AxisRectangle(0, 0.5, 0, 1, -1, 0, true)));    // a wall below, up to the floor
  set.Add(CornersOf(AxisRectangle(0, 0.999, 0, 1, 0, 1, true)));   // just inside
  set.Add(CornersOf(AxisRectangle(2, 1e-9, -1, 2, -1, 2, true)));  // a cover just over the floor
  const Shaft shaft({CornersOf(floor), floor.Normal()}, {CornersOf(ceiling), ceiling.Normal()},
                    set.tolerance_m());
  EXPECT_EQ(shaft.Classify(set, set[0]), Verdict::kOutside);
  EXPECT_EQ(shaft.Classify(set, set[1]), Verdict::kOutside);
  EXPECT_EQ(shaft.Classify(set, set[2]), Verdict::kOutside);
  EXPECT_EQ(shaft.Classify(set, set[3]), Verdict::kPartial);
  EXPECT_EQ(shaft.Classify(set, set[4]), Verdict::kBlocks);
}

// A partition that closes a box from wall to wall hides all of one half from the other, though the
// ends touch the partition's plane and the segments its border.
TEST(ShaftTest, APartitionFromWallToWallBlocks) {
  OccluderSet set(3);
  set.Add(CornersOf(AxisRectangle(0, 0.5, 0, 1, 0, 1, true)));
  const ConvexPolygon left = AxisRectangle(2, 0, 0, 0.5, 0, 1, true);    // floor up to it
  const ConvexPolygon right = AxisRectangle(1, 1, 0, 1, 0.5, 1, false);  // wall from it on
  const Shaft shaft({CornersOf(left), left.Normal()}, {CornersOf(right), right.Normal()},
                    set.tolerance_m());
  EXPECT_EQ(shaft.Classify(set, set[0]), Verdict::kBlocks);
}

TEST(OccluderTreeTest, FindsWhatAllTestsTogetherFind) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(Hash(seed, 31));
    OccluderSet set(std::sqrt(3.0));
    const int count = static_cast<int>(1 + random.Bits() % 300);
    for (int i = 0; i < count; ++i) {
      set.Add(testing::RandomConvexPolygon(
          random, testing::RandomPoint(random, Vec3(0.0), Vec3(1.0)), 0.2 * random.Unit(), 4));
    }
    const OccluderTree tree(set);
    std::vector<uint32_t> everything(set.size()), found, filtered, direct;
    for (uint32_t i = 0; i < set.size(); ++i) everything[i] = i;
    for (int k = 0; k < 50; ++k) {
      Pair pair;
      if (!MakePair(random, false, &pair)) continue;
      const Shaft shaft(End(pair.p_front, pair.p), End(pair.q_front, pair.q), set.tolerance_m());
      direct.clear();
      const bool blocked = shaft.Filter(set, everything, &direct);
      const Verdict verdict = tree.Settle(shaft, &found);
      ASSERT_EQ(verdict == Verdict::kBlocks, blocked) << "seed " << seed;
      Bounds3 p_box, q_box;
      for (const Vec3& v : CornersOf(pair.p)) p_box.Add(v);
      for (const Vec3& v : CornersOf(pair.q)) q_box.Add(v);
      const std::vector<uint32_t> of_boxes = tree.Candidates(BoxShaft(p_box, q_box));
      const bool filtered_blocked = tree.Settle(shaft, of_boxes, &filtered) == Verdict::kBlocks;
      ASSERT_EQ(filtered_blocked, blocked) << "seed " << seed;
      if (blocked) continue;
      ASSERT_EQ(found, direct) << "seed " << seed;
      // The boxes' planes may tell that a candidate is outside where the ends' own planes do not.
      ASSERT_TRUE(std::includes(direct.begin(), direct.end(), filtered.begin(), filtered.end()));
      for (const uint32_t i : direct) {
        if (std::binary_search(filtered.begin(), filtered.end(), i)) continue;
        for (int s = 0; s < 500; ++s) {
          const Vec3 x = testing::PointOn(CornersOf(pair.p), random);
          const Vec3 y = testing::PointOn(CornersOf(pair.q), random);
          ASSERT_FALSE(Crosses(set.corners(set[i]), x, y, 1e-10)) << "seed " << seed;
        }
      }
    }
    for (int k = 0; k < 200; ++k) {
      const Vec3 x = testing::RandomPoint(random, Vec3(0.0), Vec3(1.0));
      const Vec3 y = testing::RandomPoint(random, Vec3(0.0), Vec3(1.0));
      bool any = false;
      for (uint32_t i = 0; i < set.size(); ++i) any |= set.Blocks(i, x, y);
      ASSERT_EQ(tree.Blocked(x, y), any) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace isolux
