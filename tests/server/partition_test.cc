#include "server/partition.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/util/random.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

// Surfaces below a node of the cut, as fractions: 1 for a whole one.
void AddCover(const Hierarchy& hierarchy, const NodeId& node, std::map<uint32_t, double>* cover) {
  if (!node.is_cluster()) {
    (*cover)[node.surface] += std::ldexp(1.0, -node.level());
    return;
  }
  const Cluster& cluster = hierarchy.clusters()[node.path];
  for (uint32_t i = 0; i < cluster.surface_count; ++i) {
    (*cover)[hierarchy.surface_order()[cluster.first_surface + i]] += 1.0;
  }
}

// Every surface covered exactly once: an antichain, and complete.
void ExpectCovers(const Hierarchy& hierarchy, const std::vector<NodeId>& cut) {
  EXPECT_TRUE(std::is_sorted(cut.begin(), cut.end()));
  std::map<uint32_t, double> cover;
  for (const NodeId& node : cut) AddCover(hierarchy, node, &cover);
  EXPECT_EQ(cover.size(), hierarchy.surfaces().size());
  for (const auto& [surface, share] : cover) EXPECT_EQ(share, 1.0) << "surface " << surface;
}

Snapshot RandomSnapshot(const Hierarchy& hierarchy, Random& random) {
  Snapshot snapshot;
  const std::function<void(NodeId)> add = [&](const NodeId& id) {
    if (id.level() < 6 && random.Bits() % 3 != 0) {
      add(id.Child(0));
      add(id.Child(1));
    } else {
      LeafRecord leaf;
      leaf.id = id;
      snapshot.leaves.push_back(leaf);
    }
  };
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) add({s, 1});
  return snapshot;
}

TEST(PartitionTest, CutsCoverEverySurfaceOnce) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = testing::RandomRoom(seed, static_cast<int>(1 + seed * 3));
    const Hierarchy hierarchy(scene);
    for (const uint32_t target : {1u, 8u, 64u, 100'000u}) {
      const std::vector<NodeId> cut = MakeCut(hierarchy, target);
      ExpectCovers(hierarchy, cut);
      EXPECT_GE(cut.size(), std::min<size_t>(target, hierarchy.surfaces().size()))
          << "seed " << seed;
    }
  }
}

TEST(PartitionTest, EveryDistributionGivesEveryWorkerSomething) {
  const Scene scene = testing::RandomRoom(3, 12);
  const Hierarchy hierarchy(scene);
  for (const Distribution distribution : {Distribution::kOctree, Distribution::kRandom,
                                          Distribution::kInput, Distribution::kBalanced}) {
    for (const uint32_t workers : {1u, 2u, 3u, 7u}) {
      SolveOptions options;
      options.distribution = distribution;
      options.cut_size = 16;
      const Assignment assignment = Partition(hierarchy, options, workers);
      ASSERT_EQ(assignment.home.size(), assignment.cut.size());
      EXPECT_EQ(assignment.worker_count, workers);
      EXPECT_GE(assignment.cut.size(), std::max(16u, 8 * workers));
      const std::set<uint32_t> homes(assignment.home.begin(), assignment.home.end());
      EXPECT_EQ(homes.size(), workers) << static_cast<int>(distribution);
      EXPECT_LT(*homes.rbegin(), workers);
      EXPECT_EQ(assignment, Partition(hierarchy, options, workers));  // and always the same
    }
  }
}

TEST(PartitionTest, MoreWorkersThanNodesLeavesSomeWithout) {
  const Scene scene = testing::FurnaceCube(0.5, 1.0);
  const Hierarchy hierarchy(scene);
  const Assignment assignment = Partition(hierarchy, {}, 10);
  EXPECT_EQ(assignment.cut.size(), 6u);
  for (const uint32_t home : assignment.home) EXPECT_LT(home, 10u);
}

TEST(PartitionTest, TheSeedShufflesRandomHomesOnly) {
  const Scene scene = testing::RandomRoom(5, 10);
  const Hierarchy hierarchy(scene);
  SolveOptions one, other;
  other.seed = 2;
  EXPECT_EQ(Partition(hierarchy, one, 4), Partition(hierarchy, other, 4));
  one.distribution = other.distribution = Distribution::kRandom;
  EXPECT_NE(Partition(hierarchy, one, 4), Partition(hierarchy, other, 4));
}

TEST(PartitionTest, SplittingKeepsTheCover) {
  const Scene scene = testing::RandomRoom(2, 4);
  const Hierarchy hierarchy(scene);
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    const Snapshot snapshot = RandomSnapshot(hierarchy, random);
    std::vector<NodeId> cut = MakeCut(hierarchy, 8);
    for (int step = 0; step < 200; ++step) {
      const size_t at = random.Bits() % cut.size();
      const NodeId node = cut[at];
      const std::vector<NodeId> children = ChildrenOf(hierarchy, &snapshot, node);
      if (children.empty()) {
        EXPECT_EQ(CountLeaves(hierarchy, snapshot, node), 1u);
        continue;
      }
      uint64_t below = 0;
      double area = 0;
      for (const NodeId& child : children) {
        below += CountLeaves(hierarchy, snapshot, child);
        area += AreaOf(hierarchy, child);
      }
      EXPECT_EQ(below, CountLeaves(hierarchy, snapshot, node));
      EXPECT_NEAR(area, AreaOf(hierarchy, node), 1e-9 * area);
      cut.erase(cut.begin() + static_cast<std::ptrdiff_t>(at));
      cut.insert(cut.end(), children.begin(), children.end());
      std::sort(cut.begin(), cut.end());
    }
    ExpectCovers(hierarchy, cut);
  }
}

TEST(PartitionTest, ALeafHasNoChildren) {
  const Scene scene = testing::FurnaceCube(0.5, 1.0);
  const Hierarchy hierarchy(scene);
  Snapshot snapshot;
  for (uint32_t s = 0; s < 6; ++s) {
    LeafRecord leaf;
    leaf.id = {s, 1};
    snapshot.leaves.push_back(leaf);
  }
  EXPECT_TRUE(ChildrenOf(hierarchy, &snapshot, {2, 1}).empty());
  EXPECT_TRUE(ChildrenOf(hierarchy, nullptr, {2, 1}).empty());
}

}  // namespace
}  // namespace isolux
