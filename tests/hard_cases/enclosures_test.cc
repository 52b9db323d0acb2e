// Hard cases of closed and nearly closed rooms: what must stay dark, what passes a pinhole, rows
// in rooms that are not convex.
#include <gtest/gtest.h>

#include <cmath>

#include "client/output/patch_locator.h"
#include "common/util/random.h"
#include "tests/hard_cases/hard_case.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/link_bench.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"
#include "worker/radiosity/closure.h"
#include "worker/radiosity/leaks.h"

namespace isolux::testing {
namespace {

// Many small boxes in [low, high], so that there are clusters.
void Scatter(SceneSketch& sketch, const Vec3& low, const Vec3& high, int n, uint32_t material) {
  const double cell = 1.0 / n;
  for (int i = 0; i < n * n * n; ++i) {
    const Vec3 at(i % n, i / n % n, i / n / n);
    sketch.Box(low + (high - low) * (cell * (at + 0.3)), low + (high - low) * (cell * (at + 0.6)),
               false, material, kFrontTakesPart);
  }
}

// ---- furnaces

// Whole solves, from the first round to the faces of the patch file.
TEST(HardEnclosures, FurnacesThatReflectNearlyAll) {
  HardCase even("22c", "white furnace, rho .5 to .99999, solved to 5 %",
                "|B(1-rho)/E - 1| of every face", 0.01);
  HardCase kept("22d", "the same", "imbalance of energy", 1e-3);
  HardCase few("22e", "the same", "thousands of links", 5);
  for (const double rho : {0.5, 0.9, 0.99, 0.999, 0.99999}) {
    const SolveResult result = SolveScene(FurnaceCube(rho, 3.0), 0.05);
    const std::string where = fmt::format("rho {}", rho);
    for (const PatchFace& face : result.patch.faces) {
      even.Measure(std::abs(face.radiosity[0] * (1 - rho) / 3.0 - 1), where);
    }
    kept.Measure(result.summary.rounds.back().energy_imbalance, where);
    few.Measure(1e-3 * static_cast<double>(result.summary.rounds.back().links), where);
  }
}

TEST(HardEnclosures, AFurnishedRoomThatReflectsNearlyAll) {
  HardCase kept("23e", "closed room with boxes under its lamp, rho .9 to .9999, solved to 10 %",
                "imbalance of energy", 1e-3);
  HardCase told("23f", "the same", "|power absorbed by the faces over power - 1| over the estimate",
                1);
  for (const double rho : {0.9, 0.99, 0.999, 0.9999}) {
    Scene scene = FurnishedRoom();
    for (Material& material : scene.materials) material.reflectance = Rgb(rho);
    const SolveResult result = SolveScene(scene, 0.1);
    const RoundSummary& last = result.summary.rounds.back();
    double absorbed_w = 0;
    for (const PatchFace& face : result.patch.faces) {
      const double area_m2 = glm::length(AreaVector(CornersOf(result.patch, face)));
      absorbed_w += area_m2 * (1 - rho) * face.irradiance[0];
    }
    kept.Measure(last.energy_imbalance, fmt::format("rho {}", rho));
    told.Measure(
        std::abs(absorbed_w / last.emitted_w[0] - 1) / last.error_estimate,
        fmt::format("rho {}: stated {:.2g}, {} links", rho, last.error_estimate, last.links));
  }
}

// ---- what stays dark

TEST(HardEnclosures, LightInAClosedBox) {
  HardCase dark("49", "a light in a closed box of thin walls among furniture in a closed room",
                "largest irradiance outside the box", 0);
  HardCase lit("49a", "the same", "faces inside the box without light", 0);
  for (const double accuracy : {0.3, 0.1}) {
    SceneSketch sketch;
    const uint32_t wall = sketch.Material("wall", 0.7), lamp = sketch.Material("lamp", 0.3, 100);
    // Not along the cells of the octree.
    sketch.Box({1.1, 0.9, 0.4}, {1.7, 1.6, 1.1}, true, wall, kBothTakePart);
    sketch.Rectangle(2, 1.05, {1.3, 1.1}, {1.5, 1.3}, false, lamp, kBothTakePart | kFrontEmits);
    Scatter(sketch, {1.15, 0.95, 0.45}, {1.65, 1.55, 1.0}, 2, wall);
    constexpr uint32_t kOutside = 7 + 8 * 6;
    sketch.Box({0, 0, 0}, {3, 3, 2}, true, wall, kFrontTakesPart);
    Scatter(sketch, {0, 0, 1.2}, {3, 3, 2}, 3, wall);
    Scatter(sketch, {0, 0, 0}, {1, 3, 1.2}, 2, wall);
    bool any_inside = false;
    for (const PatchFace& face : SolveScene(sketch.Take(), accuracy).patch.faces) {
      const bool outside = face.polygon >= kOutside || (face.polygon < 6 && face.side == 1);
      if (outside) {
        dark.Measure(face.irradiance[0], fmt::format("polygon {}, {}", face.polygon, accuracy));
      } else {
        any_inside = true;
        lit.Measure(face.irradiance[0] > 0 ? 0 : 1);
      }
    }
    EXPECT_TRUE(any_inside);
    dark.Measure(0);  // what is dark is left out of the file
  }
}

// Two halves of a closed room with furniture in both and a partition between them; light in one.
// The lit half is x < 1.1.
Scene Partitioned(int strips, bool triangles) {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.7), lamp = sketch.Material("lamp", 0.3, 100);
  sketch.Rectangle(2, 0.9, {0.2, 0.2}, {0.6, 0.8}, false, lamp, kBothTakePart | kFrontEmits);
  for (const bool lit : {true, false}) {
    const double a = lit ? 0 : 1.1, b = lit ? 1.1 : 2;
    sketch.Rectangle(0, lit ? 0 : 2, {0, 0}, {1, 1}, lit, wall, kFrontTakesPart);
    for (const bool upper : {false, true}) {
      sketch.Rectangle(1, upper ? 1 : 0, {0, a}, {1, b}, !upper, wall, kFrontTakesPart);
      sketch.Rectangle(2, upper ? 1 : 0, {a, 0}, {b, 1}, !upper, wall, kFrontTakesPart);
    }
    Scatter(sketch, {a, 0, 0}, {b, 1, 0.8}, 2, wall);
  }
  for (int i = 0; i < strips; ++i) {
    const double y0 = static_cast<double>(i) / strips, y1 = static_cast<double>(i + 1) / strips;
    const Vec3 a(1.1, y0, 0), b(1.1, y1, 0), c(1.1, y1, 1), d(1.1, y0, 1);
    if (triangles) {
      sketch.Polygon({a, b, c}, wall, kBothTakePart);
      sketch.Polygon({a, c, d}, wall, kBothTakePart);
    } else {
      sketch.Polygon({a, b, c, d}, wall, kBothTakePart);
    }
  }
  return sketch.Take();
}

// Largest irradiance of what lies beyond the partition, over that before it.
double LightBeyond(const PatchFile& patch) {
  double before = 0, beyond = 0;
  for (const PatchFace& face : patch.faces) {
    Vec3 middle(0.0);
    for (const uint32_t v : face.vertices)
      middle += patch.vertices[v].position / static_cast<double>(face.vertices.size());
    const bool partition = std::abs(middle.x - 1.1) < 1e-9;  // its front looks into the dark half
    const bool dark = partition ? face.side == 0 : middle.x > 1.1;
    (dark ? beyond : before) = std::max<double>(dark ? beyond : before, face.irradiance[0]);
  }
  return before > 0 ? beyond / before : INFINITY;
}

TEST(HardEnclosures, Partitions) {
  HardCase full("15", "closed furnished room with a full partition of 1 to 4 panels, whole solves",
                "light beyond over that before it", 0);
  HardCase pieces("16", "partition of 2 triangles, of 1000 slivers, whole solves",
                  "light beyond over that before it", 1e-4);
  for (const int strips : {1, 2, 3, 4})
    full.Measure(LightBeyond(SolveScene(Partitioned(strips, false), 0.2).patch),
                 fmt::format("{} panels", strips));
  for (const int strips : {1, 500})
    pieces.Measure(LightBeyond(SolveScene(Partitioned(strips, true), 0.2).patch),
                   fmt::format("{} triangles", 2 * strips));
}

// ---- what passes

// A hole between a room whose walls all radiate 1, whatever they reflect, and a black one. The hole
// takes too little of the light to be seen in it: by (1 - rho)/rho of its share of the room's area.
Scene HotAndBlackRoom(double hole) {
  SceneSketch sketch;
  const uint32_t hot = sketch.Material("hot", 0.05, 0.95), black = sketch.Material("black", 0);
  sketch.WallWithHole(0, 1, {0, 0}, {1, 1}, {0.5, 0.5}, hole, hot, kBackTakesPart | kBackEmits);
  for (const bool first : {true, false}) {
    const double a = first ? 0 : 1, b = first ? 1 : 2;
    const uint32_t material = first ? hot : black;
    const uint8_t sides = first ? kFrontTakesPart | kFrontEmits : kFrontTakesPart;
    sketch.Rectangle(0, first ? 0 : 2, {0, 0}, {1, 1}, first, material, sides);
    for (const bool upper : {false, true}) {
      sketch.Rectangle(1, upper ? 1 : 0, {0, a}, {1, b}, !upper, material, sides);
      sketch.Rectangle(2, upper ? 1 : 0, {a, 0}, {b, 1}, !upper, material, sides);
    }
  }
  return sketch.Take();
}

// Power that passes, over the area of the hole: in a whole solve, and by links alone.
double PassesThrough(double hole, double accuracy) {
  // The hot room comes first but for its end and sides: 4 + 5 polygons.
  return ArrivingAt(SolveScene(HotAndBlackRoom(hole), accuracy).patch, 4 + 5) / (hole * hole);
}

double PassesByLinks(double hole, double share, uint64_t seed) {
  LinkBench bench(HotAndBlackRoom(hole), share, 2, false, seed);
  const size_t n = bench.system.size();
  const auto black = [&](size_t i) { return bench.system.reflectance[i][0] == 0; };
  std::vector<Lanes> radiosity(n);
  for (size_t i = 0; i < n; ++i) radiosity[i] = Splat(black(i) ? 0 : 1);
  const std::vector<Lanes> irradiance = bench.Irradiance(radiosity);
  double power = 0;
  for (size_t i = 0; i < n; ++i) {
    if (black(i)) power += irradiance[i][0] * bench.system.area_m2[i];
  }
  return power / (hole * hole);
}

TEST(HardEnclosures, PinholesBetweenTwoRooms) {
  HardCase passes("19", "a furnace and a black room joined by a hole of 0.1, accuracy 1 %",
                  "|power that passes / exact - 1|", 0.05);
  passes.Measure(std::abs(PassesThrough(0.1, 0.01) - 1));
  HardCase some("19a", "the same with a pinhole of 1e-2", "-log10(power that passes / exact)", 0.1);
  some.Measure(std::abs(std::log10(PassesThrough(0.01, 0.01))));
  // Links are kept by what their rays see: were that their value too, half would be lost.
  HardCase links("19b", "the links alone, 12,000 of them, mean of 50 seeds",
                 "|power that passes / exact - 1|", 0.05);
  double found = 0;
  for (uint64_t seed = 1; seed <= 50; ++seed) found += PassesByLinks(0.1, 1e-4, seed) / 50;
  links.Measure(std::abs(found - 1));
}

// ---- rows

TEST(HardEnclosures, ConcaveClosedScenes) {
  HardCase sums("33", "closed rooms that are not convex: an L, one with a column",
                "|row sum - 1| of a surface before closure", 0.02);
  HardCase closure("33a", "the same, closed", "|d^2 - 1|", 0.1);
  for (const bool column : {false, true}) {
    LinkBench bench(column ? ColumnRoom() : LRoom(), 1e-4);
    const size_t n = bench.system.size();
    const auto rows = bench.Irradiance(std::vector<Lanes>(n, Lanes{1, 1, 1, 0}));
    std::vector<double> sum(bench.hierarchy.surfaces().size(), 0);
    for (size_t i = 0; i < n; ++i)
      sum[bench.tree.node(bench.nodes.leaves[i]).id.surface] +=
          bench.system.area_m2[i] * rows[i][0];
    const char* room = column ? "column" : "L";
    for (uint32_t s = 0; s < sum.size(); ++s) {
      sums.Measure(std::abs(sum[s] / bench.hierarchy.surface_area_m2(s) - 1),
                   fmt::format("{}, surface {}", room, s));
    }
    const auto closing = bench.CloseRows(1e-3);
    ASSERT_TRUE(closing.has_value());
    for (size_t i = 0; i < n; ++i) {
      const double d = bench.system.closure[i];
      closure.Measure(std::abs(d * d - 1), fmt::format("{}, leaf {}", room, i));
    }
  }
}

TEST(HardEnclosures, RowsOfRandomRooms) {
  HardCase most("70d", "random closed rooms, links closed to a thousandth",
                "how far a row is above 1", 1e-12);
  HardCase least("70e", "the same", "how far a row is below 1", 1e-12);
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    LinkBench bench(RandomClosedRoom(seed), 1e-3, 2, false);
    const size_t n = bench.system.size();
    ASSERT_TRUE(bench.CloseRows(1e-3).has_value());
    LinkTransport transport(*bench.product, bench.system);
    std::vector<Lanes> rows(n);
    ASSERT_TRUE(
        transport.Irradiance(std::vector<Lanes>(n, Lanes{1, 1, 1, 0}), Splat(1), rows).ok());
    for (const Lanes& row : rows) {
      most.Measure(std::max(0.0, row[0] - 1), fmt::format("seed {}", seed));
      least.Measure(std::max(0.0, 1 - row[0]), fmt::format("seed {}", seed));
    }
  }
}

// ---- rooms that hardly touch

// Two unit cubes side by side, a hole between them or none, the floor of the first a lamp.
Scene TwoCubes(double reflectance, double hole) {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", reflectance),
                 lamp = sketch.Material("lamp", reflectance, 1);
  if (hole > 0) {
    sketch.WallWithHole(0, 1, {0, 0}, {1, 1}, {0.5, 0.5}, hole, wall, kBothTakePart);
  } else {
    sketch.Rectangle(0, 1, {0, 0}, {1, 1}, true, wall, kBothTakePart);
  }
  for (const bool first : {true, false}) {
    const double a = first ? 0 : 1, b = first ? 1 : 2;
    sketch.Rectangle(0, first ? 0 : 2, {0, 0}, {1, 1}, first, wall, kFrontTakesPart);
    for (const bool upper : {false, true}) {
      const bool lit = first && !upper;
      sketch.Rectangle(1, upper ? 1 : 0, {0, a}, {1, b}, !upper, wall, kFrontTakesPart);
      sketch.Rectangle(2, upper ? 1 : 0, {a, 0}, {b, 1}, !upper, lit ? lamp : wall,
                       kFrontTakesPart | (lit ? kFrontEmits : 0));
    }
  }
  return sketch.Take();
}

// Σ A H of the faces of each of the two cubes.
std::array<double, 2> ArrivingInCubes(const PatchFile& patch) {
  std::array<double, 2> arriving{};
  for (const PatchFace& face : patch.faces) {
    const std::vector<Vec3> corners = CornersOf(patch, face);
    const Vec3 area = AreaVector(corners),
               inside = corners[0] + 1e-3 * glm::normalize(area) + 1e-3 * (corners[2] - corners[0]);
    arriving[inside.x < 1 ? 0 : 1] += glm::length(area) * face.irradiance[0];
  }
  return arriving;
}

TEST(HardEnclosures, TwoRoomsThatHardlyTouch) {
  HardCase few("34b", "two cubes of rho .999 joined by a hole of 1e-4 of the area, whole solves",
               "products of a round", 60);
  HardCase balanced("34c", "the same", "imbalance of energy", 1e-3);
  HardCase shared("34d", "the same, at 5 %", "-log10(light in the dark one / exact)", 0.04);
  HardCase stated("34e", "the same", "error of the shares of light over what is stated", 1);
  HardCase dark("35a", "two cubes, the one without light behind a whole wall, whole solves",
                "largest H in the dark one", 0);
  constexpr double kReflectance = 0.999, kArea = 12;
  const double hole = std::sqrt(1e-4 * kArea);
  // Both are lit nearly evenly: what passes the hole, h (B1 - B2), is what the second absorbs,
  // A (1 - rho) H2.
  const double h = hole * hole, absorbs = (kArea / 2 - h) * (1 - kReflectance) / kReflectance;
  const double exact = h / (h + absorbs);
  for (const uint64_t seed : {1, 2, 3}) {
    SolveOptions options = ToAccuracy(0.05);
    options.seed = seed;
    const SolveResult result = SolveScene(TwoCubes(kReflectance, hole), options);
    const std::string where = fmt::format("seed {}", seed);
    for (const RoundSummary& round : result.summary.rounds) few.Measure(round.iterations, where);
    balanced.Measure(result.summary.rounds.back().energy_imbalance, where);
    const std::array<double, 2> arriving = ArrivingInCubes(result.patch);
    shared.Measure(std::abs(std::log10(arriving[1] / arriving[0] / exact)), where);
    // What one has too much the other lacks.
    const double off =
        2 * std::abs(arriving[1] / (arriving[0] + arriving[1]) - exact / (1 + exact));
    stated.Measure(off / result.summary.rounds.back().error_estimate, where);
  }
  // Which worker holds a link does not matter to the draw of its error.
  const Scene scene = TwoCubes(kReflectance, hole);
  const SolveResult one = SolveScene(scene, ToAccuracy(0.4)),
                    three = SolveScene(scene, ToAccuracy(0.4), 3);
  EXPECT_EQ(one.summary.rounds.back().error_estimate, three.summary.rounds.back().error_estimate);
  for (const double reflectance : {0.5, 0.999}) {
    const SolveResult result = SolveScene(TwoCubes(reflectance, 0), 0.05);
    dark.Measure(ArrivingInCubes(result.patch)[1], fmt::format("rho {}", reflectance));
  }
}

// ---- leaks

// A cube without its upper x wall.
Scene CubeWithoutAWall() {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.5, 1);
  for (int face = 0; face < 6; ++face) {
    if (face == 1) continue;
    sketch.Rectangle(face / 2, face % 2, {0, 0}, {1, 1}, face % 2 == 0, wall,
                     kFrontTakesPart | kFrontEmits);
  }
  return sketch.Take();
}

// Its floor is there so many times, as no importer would leave it.
Scene CubeWithFloors(int floors) {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.5), lamp = sketch.Material("lamp", 0.5, 1);
  sketch.Box({0, 0, 0}, {1, 1, 1}, true, wall, kFrontTakesPart);
  sketch.Rectangle(2, 0.9, {0.3, 0.3}, {0.6, 0.6}, false, lamp, kBothTakePart | kFrontEmits);
  for (int k = 1; k < floors; ++k)
    sketch.Rectangle(2, 0, {0, 0}, {1, 1}, true, wall, kFrontTakesPart);
  return sketch.Take();
}

// Share of the area that is told to leak where every row is taken for that of a closed room.
double LeakAreaTakenForClosed(const Scene& scene) {
  LinkBench bench(scene, 1e-3, 2, false);
  const size_t n = bench.system.size();
  const auto closing = bench.CloseRows(1e-3);
  EXPECT_TRUE(closing.has_value());
  if (!closing.has_value()) return INFINITY;
  const std::vector<Lanes> lit(n, Lanes{1, 1, 1, 0});
  const auto leaks = CountLeaks(bench.system, lit, closing->bend,
                                bench.hierarchy.clusters()[0].area_m2, bench.exchange);
  EXPECT_TRUE(leaks.has_value());
  return leaks ? leaks->area_share : INFINITY;
}

TEST(HardEnclosures, LeaksAreTold) {
  HardCase told("33b", "a wall missing and taken for closed; a floor that is there four times",
                "share of the area that is not told to leak", 0.7);
  HardCase quiet("33c", "closed rooms: L, column, furnished, Cornell box",
                 "share of the area that is told to leak", 0.03);
  told.Measure(1 - LeakAreaTakenForClosed(CubeWithoutAWall()), "missing wall");
  quiet.Measure(LeakAreaTakenForClosed(LRoom()), "L");
  quiet.Measure(LeakAreaTakenForClosed(ColumnRoom()), "column");
  const auto leak_area = [](const Scene& scene) {
    return SolveScene(scene, 0.05).summary.rounds.back().leak_area;
  };
  told.Measure(1 - leak_area(CubeWithFloors(4)), "four floors");
  quiet.Measure(leak_area(CubeWithFloors(1)), "one floor");
  quiet.Measure(leak_area(FurnishedRoom()), "furnished");
  quiet.Measure(leak_area(ClosedCornellBox()), "Cornell box");
}

}  // namespace
}  // namespace isolux::testing
