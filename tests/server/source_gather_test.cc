#include "server/source_gather.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "common/util/random.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

// Each surface one leaf, with some irradiance.
Snapshot LitSurfaces(const Hierarchy& hierarchy, uint64_t seed) {
  Random random(seed);
  Snapshot snapshot;
  for (uint32_t surface = 0; surface < hierarchy.surfaces().size(); ++surface) {
    LeafRecord leaf;
    leaf.id = {surface, 1};
    for (double& h : leaf.irradiance) h = random.Unit() < 0.1 ? 0 : 1 + 5 * random.Unit();
    snapshot.leaves.push_back(leaf);
  }
  return snapshot;
}

std::array<double, 3> ReflectedPower(const Hierarchy& hierarchy, const Snapshot& snapshot) {
  std::array<double, 3> power{};
  for (const LeafRecord& leaf : snapshot.leaves) {
    const Rgb& reflectance = hierarchy.surfaces()[leaf.id.surface].reflectance;
    for (int c = 0; c < 3; ++c) {
      power[c] += hierarchy.surface_area_m2(leaf.id.surface) * reflectance[c] * leaf.irradiance[c];
    }
  }
  return power;
}

TEST(SourceGather, KeepsReflectedPower) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Hierarchy hierarchy(testing::RandomRoom(seed, 3));
    const Snapshot solution = LitSurfaces(hierarchy, seed);
    Snapshot gathered = solution;
    Random random(100 + seed);
    std::vector<uint32_t> leaves;
    for (uint32_t i = 0; i < gathered.leaves.size(); ++i) {
      if (random.Unit() < 0.2) continue;  // keeps what it has
      leaves.push_back(i);
      for (double& h : gathered.leaves[i].irradiance) h *= 0.85 + 0.2 * random.Unit();
    }
    const Snapshot before = gathered;
    KeepReflectedPower(hierarchy, OutputMeshOptions(), solution, leaves, &gathered);
    const auto wanted = ReflectedPower(hierarchy, solution);
    const auto found = ReflectedPower(hierarchy, gathered);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], 1e-12 * wanted[c]);
    // By one factor a channel, those that were gathered alone.
    for (int c = 0; c < 3; ++c) {
      double factor = 0;
      for (uint32_t i = 0; i < gathered.leaves.size(); ++i) {
        const double was = before.leaves[i].irradiance[c], is = gathered.leaves[i].irradiance[c];
        if (!std::binary_search(leaves.begin(), leaves.end(), i) || was == 0) {
          EXPECT_EQ(is, was);
        } else {
          if (factor == 0) factor = is / was;
          EXPECT_NEAR(is / was, factor, 1e-12);
        }
      }
      EXPECT_NE(factor, 1);
    }
  }
}

TEST(SourceGather, ScalesByAQuarterAtMost) {
  const Hierarchy hierarchy(testing::RandomRoom(1, 3));
  const Snapshot solution = LitSurfaces(hierarchy, 1);
  std::vector<uint32_t> leaves(solution.leaves.size());
  std::iota(leaves.begin(), leaves.end(), 0U);
  for (const double share : {0.01, 0.0, 100.0}) {
    Snapshot gathered = solution;
    for (LeafRecord& leaf : gathered.leaves) {
      for (double& h : leaf.irradiance) h *= share;
    }
    KeepReflectedPower(hierarchy, OutputMeshOptions(), solution, leaves, &gathered);
    const double factor = share > 1 ? 1 / 1.25 : 1.25;
    for (size_t i = 0; i < leaves.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_DOUBLE_EQ(gathered.leaves[i].irradiance[c],
                         solution.leaves[i].irradiance[c] * share * factor);
      }
    }
  }
}

// Each surface in 64 leaves, all of some irradiance.
Snapshot LitLeaves(const Hierarchy& hierarchy) {
  Snapshot snapshot;
  for (uint32_t surface = 0; surface < hierarchy.surfaces().size(); ++surface) {
    for (uint64_t path = 64; path < 128; ++path) {
      LeafRecord leaf;
      leaf.id = {surface, path};
      leaf.irradiance = {1, 2, 3};
      snapshot.leaves.push_back(leaf);
    }
  }
  return snapshot;
}

struct Clustered {
  Scene scene = testing::RandomRoom(1, 7);
  Hierarchy hierarchy{scene};
  Snapshot solution = LitLeaves(hierarchy);
  std::vector<uint32_t> leaves;
  uint32_t first = hierarchy.cluster_of(0);

  Clustered() : leaves(solution.leaves.size()) { std::iota(leaves.begin(), leaves.end(), 0U); }

  // Of the reflected power, what surfaces of this cluster have.
  double ShareOf(uint32_t cluster) const {
    double all_w = 0, own_w = 0;
    for (const LeafRecord& leaf : solution.leaves) {
      const double w = hierarchy.surface_area_m2(leaf.id.surface) *
                       glm::dot(hierarchy.surfaces()[leaf.id.surface].reflectance, Rgb(1, 2, 3));
      all_w += w;
      if (hierarchy.cluster_of(leaf.id.surface) == cluster) own_w += w;
    }
    return own_w / all_w;
  }
  bool IsInFirst(uint32_t file_polygon) const {
    for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
      const Polygon& polygon = scene.polygons[hierarchy.surfaces()[s].polygon];
      if (polygon.file_polygon == file_polygon) return hierarchy.cluster_of(s) == first;
    }
    return false;
  }
  UnseenLight Find(const Snapshot& gathered) const {
    return FindUnseenLight(hierarchy, OutputMeshOptions(), solution, leaves, gathered);
  }
};

TEST(UnseenLight, IsWhatWholeRegionsAreOff) {
  const Clustered scene;
  ASSERT_GT(scene.hierarchy.clusters().size(), 2u);
  ASSERT_LT(scene.ShareOf(scene.first), 0.9);
  for (const double off : {0.1, -0.1}) {
    Snapshot gathered = scene.solution;
    for (LeafRecord& leaf : gathered.leaves) {
      if (scene.hierarchy.cluster_of(leaf.id.surface) != scene.first) continue;
      for (double& h : leaf.irradiance) h *= 1 + off;
    }
    const UnseenLight unseen = scene.Find(gathered);
    // Twice what is off; of it, what chance may make of so many leaves is taken off.
    const double whole = 2 * std::abs(off) * scene.ShareOf(scene.first);
    EXPECT_LE(unseen.error, whole * (1 + 1e-12));
    EXPECT_GE(unseen.error, 0.95 * whole);
    EXPECT_TRUE(scene.IsInFirst(unseen.polygon));
  }
}

TEST(UnseenLight, IsNotWhatChanceMakes) {
  const Clustered scene;
  Random random(5);
  Snapshot gathered = scene.solution;
  double off_w = 0, all_w = 0;
  for (LeafRecord& leaf : gathered.leaves) {
    const double off = random.Unit() - 0.5;
    for (double& h : leaf.irradiance) h *= 1 + off;
    off_w += std::abs(off);
    ++all_w;
  }
  EXPECT_LT(scene.Find(gathered).error, 0.15 * off_w / all_w);
  EXPECT_EQ(scene.Find(scene.solution).error, 0);
}

}  // namespace
}  // namespace isolux
