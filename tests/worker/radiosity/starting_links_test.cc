// How many links a scene starts with, before a ray has been cast: far fewer than there are pairs of
// polygons, since clusters stand for what is too weak to matter.
#include <gtest/gtest.h>

#include <filesystem>

#include "client/import/import.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/link_bench.h"
#include "tests/support/scenes.h"
#include "tests/support/shared_folder.h"
#include "worker/coupling/coupling.h"

namespace isolux::testing {
namespace {

struct StartingLinks {
  size_t polygons = 0;
  size_t pairs = 0;      // of surfaces that face each other
  size_t links = 0;      // before any ray: as if nothing stood between
  size_t survivors = 0;  // with rays and proofs, those that see something
  uint64_t rays = 0;
};

size_t FacingPairs(const Hierarchy& hierarchy) {
  std::vector<CouplingEnd> ends;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    ends.push_back(MakeCouplingEnd(hierarchy.geometry(s)));
  }
  size_t pairs = 0;
  for (size_t i = 0; i < ends.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      pairs += Couple(ends[i], ends[j], 1e-2 * std::min(ends[i].area_m2, ends[j].area_m2)).regime !=
                       Regime::kZero
                   ? 1
                   : 0;
    }
  }
  return pairs;
}

// At the threshold of a first round, 2 % of what is emitted.
StartingLinks CountStartingLinks(const char* name, const Scene& scene) {
  constexpr double kFirst = 0.02;
  LinkBench bench(scene, kFirst);
  StartingLinks count;
  count.polygons = scene.polygons.size();
  count.pairs = FacingPairs(bench.hierarchy);
  count.rays = bench.counters.rays;
  for (const std::vector<Link>* links : {&bench.links.own, &bench.links.crown}) {
    for (const Link& link : *links) count.survivors += link.coupling_m2() > 0 ? 1 : 0;
  }
  LinkSet open;
  RefineCounters counters;
  EXPECT_TRUE(Refine(bench.epsilon_w, {&bench.rays, 1, false}, bench.tree, *bench.placement,
                     bench.pool, open, counters, nullptr)
                  .ok());
  EXPECT_EQ(counters.rays, 0U);
  count.links = open.own.size() + open.crown.size();
  std::printf(
      "%s: %zu polygons, %zu pairs that face each other, %zu links before any ray, %zu "
      "that see something, %llu rays\n",
      name, count.polygons, count.pairs, count.links, count.survivors,
      static_cast<unsigned long long>(count.rays));
  return count;
}

// Rows of desks with legs, drawers, a screen and a chair under four lamps.
Scene Office() {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.7), wood = sketch.Material("wood", 0.4),
                 metal = sketch.Material("metal", 0.3), lamp = sketch.Material("lamp", 0.5, 100);
  sketch.Box({0, 0, 0}, {8, 6, 3}, true, wall, kFrontTakesPart);
  for (const double x : {1.5, 5.5}) {
    for (const double y : {1.5, 4.0}) {
      sketch.Rectangle(2, 2.9, {x, y}, {x + 1.2, y + 0.3}, false, lamp,
                       kBothTakePart | kFrontEmits);
    }
  }
  const auto box = [&](const Vec3& low, const Vec3& size, uint32_t material) {
    sketch.Box(low, low + size, false, material, kFrontTakesPart);
  };
  for (int row = 0; row < 2; ++row) {
    for (int k = 0; k < 4; ++k) {
      const Vec3 o(0.5 + 1.9 * k, 1 + 2.6 * row, 0);
      box(o + Vec3(0, 0, 0.7), {1.4, 0.7, 0.03}, wood);
      for (const double x : {0.02, 1.34}) {
        for (const double y : {0.02, 0.64}) box(o + Vec3(x, y, 0.01), {0.04, 0.04, 0.68}, metal);
      }
      box(o + Vec3(0.95, 0.1, 0.05), {0.35, 0.5, 0.6}, wood);
      box(o + Vec3(0.4, 0.5, 0.8), {0.5, 0.03, 0.35}, metal);
      box(o + Vec3(0.4, -0.6, 0.42), {0.45, 0.45, 0.05}, metal);
      sketch.Rectangle(1, o.y - 0.6, {0.48, o.x + 0.4}, {0.9, o.x + 0.85}, true, metal,
                       kBothTakePart);
    }
  }
  return sketch.Take();
}

TEST(StartingLinks, OfPlainRoomsAreFewerThanPairs) {
  for (const auto& [name, scene] : {std::pair("furnished room", FurnishedRoom()),
                                    {"Cornell box", ClosedCornellBox()},
                                    {"room of blocks", RandomRoom(3, 6)}}) {
    const StartingLinks count = CountStartingLinks(name, scene);
    // So few polygons are divided at once.
    EXPECT_LT(count.links, 40 * count.polygons) << name;
    EXPECT_LE(count.survivors, count.links) << name;
    EXPECT_GT(count.survivors, count.polygons) << name;
  }
}

TEST(StartingLinks, OfFurnitureAreFarFewerThanPairs) {
  const StartingLinks count = CountStartingLinks("office", Office());
  EXPECT_GT(count.polygons, 380U);
  EXPECT_GT(count.pairs, 15'000U);
  EXPECT_LT(count.links, count.pairs / 6);
  EXPECT_LT(count.links, count.polygons * count.polygons / 50);
  EXPECT_LT(count.survivors, count.links);
}

TEST(StartingLinks, OfAPublishedOffice) {
  const std::string path = SharedFolder() + "/scenes/simple_office/simple_office.obj";
  if (!std::filesystem::exists(path)) {
    GTEST_SKIP() << "no collection of scenes; name its folder in ISOLUX_SHARED";
  }
  ImportOptions options;
  options.emit_both = true;
  const auto scene = ImportScene(path, options);
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  const StartingLinks count = CountStartingLinks("simple_office", *scene);
  EXPECT_LT(count.links, 104'000U / 20);
  EXPECT_LT(count.survivors, count.links);
}

}  // namespace
}  // namespace isolux::testing
