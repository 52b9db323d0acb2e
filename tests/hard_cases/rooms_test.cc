// Hard cases of geometry, solved whole: behind a sheet, beyond pinholes and openings, in thousands
// of pieces. Built twice: small for every day, large (ISOLUX_LARGE_CASES) for nights.
#include <gtest/gtest.h>

#include <cmath>

#include "client/output/comparison.h"
#include "common/util/random.h"
#include "tests/hard_cases/hard_case.h"
#include "tests/support/dense_transport.h"
#include "tests/support/exact_factors.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"
#include "worker/radiosity/escape.h"
#include "worker/radiosity/solver.h"

namespace isolux::testing {
namespace {

constexpr bool kLarge = ISOLUX_LARGE_CASES != 0;

// What a case is called in its size: "a floor of {} triangles", with a thousand a comma.
std::string Of(const char* situation, int small, int large) {
  const int count = kLarge ? large : small;
  return fmt::format(fmt::runtime(situation),
                     count < 1000 ? fmt::format("{}", count)
                                  : fmt::format("{},{:03}", count / 1000, count % 1000));
}

const RoundSummary& Last(const SolveResult& result) { return result.summary.rounds.back(); }

double L1(const PatchFile& a, const PatchFile& b) {
  return Compare(a, b, {.samples = 1 << 14}).value().l1_relative;
}

// A room divided by one sheet (polygon 10), lit on one side; the other (polygons 5 to 9) is painted
// with `dark_reflectance`.
Scene DividedRoom(double dark_reflectance) {
  SceneSketch sketch;
  const uint32_t bright = sketch.Material("bright", 0.6), lamp = sketch.Material("lamp", 0.2, 10),
                 sheet = sketch.Material("sheet", 0.8),
                 other = sketch.Material("other", dark_reflectance);
  for (const bool lit_half : {true, false}) {
    const double a = lit_half ? 0 : 1, b = lit_half ? 1 : 2;
    const uint32_t wall = lit_half ? bright : other;
    sketch.Rectangle(0, lit_half ? 0 : 2, {0, 0}, {1, 1}, lit_half, wall, kFrontTakesPart);
    for (const bool upper : {false, true}) {
      sketch.Rectangle(1, upper ? 1 : 0, {0, a}, {1, b}, !upper, wall, kFrontTakesPart);
      sketch.Rectangle(2, upper ? 1 : 0, {a, 0}, {b, 1}, !upper, lit_half && upper ? lamp : wall,
                       kFrontTakesPart | (lit_half && upper ? kFrontEmits : 0));
    }
  }
  sketch.Rectangle(0, 1, {0, 0}, {1, 1}, true, sheet, kBothTakePart);
  return sketch.Take();
}

bool OnTheDarkSide(const PatchFace& face) {
  return (face.polygon >= 5 && face.polygon < 10) || (face.polygon == 10 && face.side == 0);
}

TEST(HardRooms, PaperThinSheet) {
  HardCase independent("43", "a room divided by one sheet, lit on one side; what is dark repainted",
                       "difference of the lit side's irradiance", 1e-6);
  std::array<PatchFile, 2> lit;
  for (int k = 0; k < 2; ++k) {
    SolveOptions options = ToAccuracy(0.05);
    options.epsilons = {0.1, 0.02, 0.004};
    lit[k] = SolveScene(DividedRoom(k == 0 ? 0.1 : 0.9), options).patch;
    std::erase_if(lit[k].faces, [](const PatchFace& face) { return OnTheDarkSide(face); });
    EXPECT_GT(lit[k].faces.size(), 50u);
  }
  independent.Measure(L1(lit[0], lit[1]));
  HardCase dark("43a", "the same", "largest irradiance of the dark side", 0);
  dark.Measure(0);  // dark surfaces are left out of the file
  for (const PatchFace& face : SolveScene(DividedRoom(0.1), ToAccuracy(0.05)).patch.faces) {
    if (OnTheDarkSide(face))
      dark.Measure(face.irradiance[0], fmt::format("polygon {}", face.polygon));
  }
}

// ---- through holes

// A unit box of reflectance .8, x low lit, with a square hole in its upper wall.
Scene OpenBox(double hole_size) {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.8), lamp = sketch.Material("lamp", 0.8, 1);
  for (int face = 0; face < 5; ++face) {
    sketch.Rectangle(face / 2, face % 2, {0, 0}, {1, 1}, face % 2 == 0, face == 0 ? lamp : wall,
                     kFrontTakesPart | (face == 0 ? kFrontEmits : 0));
  }
  if (hole_size < 1)
    sketch.WallWithHole(2, 1, {0, 0}, {1, 1}, {0.45, 0.45}, hole_size, wall, kBackTakesPart);
  return sketch.Take();
}

TEST(HardRooms, OpeningsAreNotClosed) {
  HardCase told("32", "a box without a wall, or with holes of 1 to 1e-3 of a wall, rho .8",
                "surfaces taken for those of a closed room", 0);
  ThreadPool pool(2);
  for (const double hole : {1.0, 0.1, 0.03}) {
    const Scene scene = OpenBox(hole);
    const Hierarchy hierarchy(scene);
    const Scout scout =
        ScoutEscapes(hierarchy, RayScene(hierarchy), Mirrors(), TranslucentSheets(), 0.02, 1, pool);
    for (const uint8_t closed : scout.closed) told.Measure(closed, fmt::format("hole {}", hole));
  }
}

TEST(HardRooms, OpeningsLoseWhatTheyShould) {
  HardCase means("32c", "a box with a hole of 1e-2 of a wall, or without a wall, rho .8",
                 "|mean H of a wall / exact - 1| over the error estimate", 1);
  for (const bool whole_wall : {false, true}) {
    // An opening is a black wall.
    constexpr int kCells = 10;
    GridBox box = MakeGridBox({1, 1, 1}, {kCells, kCells, kCells});
    const size_t n = box.leaves.size();
    size_t of_face = 0;
    for (size_t i = 0; i < n; ++i) {
      of_face = i > 0 && box.face[i] == box.face[i - 1] ? of_face + 1 : 0;
      const bool open = box.face[i] == 5 && (whole_wall || of_face == 4 * kCells + 4);
      const double rho = open ? 0 : 0.8, exitance = box.face[i] == 0 ? 1 : 0;
      box.leaves.reflectance[i] = Lanes{rho, rho, rho, 0};
      box.leaves.exitance[i] = Lanes{exitance, exitance, exitance, 0};
    }
    DenseTransport transport(box.coupling_m2, box.leaves);
    NullExchange exchange;
    SolverOptions solver;
    solver.accuracy = 1e-6;
    const auto exact = Solve(SolverMethod::kConjugateGradients, transport, box.leaves,
                             std::vector<Lanes>(n, Lanes{}), solver, exchange);
    ASSERT_TRUE(exact.has_value());
    std::array<double, 6> mean{};
    double escaped = 0;  // not of a wall
    for (size_t i = 0; i < n; ++i) {
      const double arriving = box.leaves.area_m2[i] * exact->irradiance[i][0];
      (box.leaves.reflectance[i][0] > 0 ? mean[box.face[i]] : escaped) += arriving;
    }

    const SolveResult result =
        SolveScene(OpenBox(whole_wall ? 1.0 : 1.0 / kCells), ToAccuracy(0.05));
    const double estimate = Last(result).error_estimate;
    const std::string where = whole_wall ? "no wall" : "hole";
    double difference = 0, total = 0;
    for (uint32_t face = 0; face < 5; ++face) {
      const double found = ArrivingAt(result.patch, face) - ArrivingAt(result.patch, face + 1);
      difference += std::abs(found - mean[face]);
      total += mean[face];
    }
    means.Measure(difference / total / estimate, where);
  }
}

TEST(HardRooms, TwoSuccessivePinholes) {
  // Black rooms: what passes is what one pinhole radiates to the other, since all that is seen
  // through the first is lamp.
  HardCase passes("65", "a lamp seen only through two successive pinholes of .2 m, black walls",
                  "|power in the third room, mean of the seeds / exact - 1|", 0.03);
  SceneSketch sketch;
  const uint32_t black = sketch.Material("black", 0), lamp = sketch.Material("lamp", 0, 1000);
  constexpr double kHole = 0.2;
  sketch.Rectangle(0, 0, {0, 0}, {1, 1}, true, lamp, kFrontTakesPart | kFrontEmits);
  sketch.WallWithHole(0, 1, {0, 0}, {1, 1}, {0.5, 0.5}, kHole, black, kBothTakePart);
  sketch.WallWithHole(0, 2, {0, 0}, {1, 1}, {0.5, 0.5}, kHole, black, kBothTakePart);
  for (const bool upper : {false, true}) {
    sketch.Rectangle(1, upper ? 1 : 0, {0, 0}, {1, 1}, !upper, black, kFrontTakesPart);
    sketch.Rectangle(2, upper ? 1 : 0, {0, 0}, {1, 1}, !upper, black, kFrontTakesPart);
    sketch.Rectangle(1, upper ? 1 : 0, {0, 1}, {1, 2}, !upper, black, kFrontTakesPart);
    sketch.Rectangle(2, upper ? 1 : 0, {1, 0}, {2, 1}, !upper, black, kFrontTakesPart);
  }
  const uint32_t third_room = 17;
  for (const bool upper : {false, true}) {
    sketch.Rectangle(1, upper ? 1 : 0, {0, 2}, {1, 3}, !upper, black, kFrontTakesPart);
    sketch.Rectangle(2, upper ? 1 : 0, {2, 0}, {3, 1}, !upper, black, kFrontTakesPart);
  }
  sketch.Rectangle(0, 3, {0, 0}, {1, 1}, false, black, kFrontTakesPart);
  const Scene scene = sketch.Take();
  // So little of the light passes that rays by chance may be wrong by a tenth: what is asked is
  // that they are right on average. At 2 %, since the few faces of the third room at 5 % show the
  // pool of light there 2.4 % too large (mean of 96 seeds, deviation of one 0.05).
  constexpr int kSeeds = 16;
  double found = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SolveOptions options = ToAccuracy(0.02);
    options.seed = static_cast<uint64_t>(seed);
    found += ArrivingAt(SolveScene(scene, options).patch, third_room) / kSeeds;
  }
  const double exact = 1000 * OpposedRectangles(kHole, kHole, 1);
  passes.Measure(std::abs(found / exact - 1), fmt::format("{} of {} W", found, exact));
}

// ---- in many pieces

// A lamp of n × n squares `gap` below the ceiling of a room of 4 × 4 × 3.
Scene TiledLamp(int n, double gap) {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.6), lamp = sketch.Material("lamp", 0.3, 100);
  sketch.Box({0, 0, 0}, {4, 4, 3}, true, wall, kFrontTakesPart);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      sketch.Rectangle(2, 3 - gap, {1.5 + 1.0 * i / n, 1.5 + 1.0 * k / n},
                       {1.5 + 1.0 * (i + 1) / n, 1.5 + 1.0 * (k + 1) / n}, false, lamp,
                       kBothTakePart | kFrontEmits);
    }
  }
  return sketch.Take();
}

// A room whose floor is n × n × 2 triangles.
Scene TiledFloor(int n) {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.6), lamp = sketch.Material("lamp", 0.3, 100);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const Vec3 a(4.0 * i / n, 4.0 * k / n, 0), b(4.0 * (i + 1) / n, 4.0 * k / n, 0),
          c(4.0 * (i + 1) / n, 4.0 * (k + 1) / n, 0), d(4.0 * i / n, 4.0 * (k + 1) / n, 0);
      sketch.Polygon({a, b, c}, wall, kFrontTakesPart);
      sketch.Polygon({a, c, d}, wall, kFrontTakesPart);
    }
  }
  for (const bool upper : {false, true}) {
    sketch.Rectangle(0, upper ? 4 : 0, {0, 0}, {4, 3}, !upper, wall, kFrontTakesPart);
    sketch.Rectangle(1, upper ? 4 : 0, {0, 0}, {3, 4}, !upper, wall, kFrontTakesPart);
  }
  sketch.Rectangle(2, 3, {0, 0}, {4, 4}, false, lamp, kFrontTakesPart | kFrontEmits);
  return sketch.Take();
}

// n boxes of six quads each, scattered in a cube of 1e-3, in a room of 1.
Scene DustInARoom(int n) {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.6), dust = sketch.Material("dust", 0.4),
                 lamp = sketch.Material("lamp", 0.3, 100);
  sketch.Box({0, 0, 0}, {1, 1, 1}, true, wall, kFrontTakesPart);
  sketch.Rectangle(2, 0.9, {0.3, 0.3}, {0.7, 0.7}, false, lamp, kBothTakePart | kFrontEmits);
  Random random(42);
  const int side = static_cast<int>(std::ceil(std::cbrt(n)));
  for (int i = 0; i < n; ++i) {
    const double cell = 1e-3 / side;
    const Vec3 place(i % side, i / side % side, i / side / side);
    const Vec3 low = Vec3(0.5, 0.5, 0.4) + cell * (place + 0.3 * random.Unit());
    sketch.Box(low, low + Vec3(cell * (0.2 + 0.4 * random.Unit())), false, dust, kFrontTakesPart);
  }
  return sketch.Take();
}

// A row of n slats, each tilted, below a lamp.
Scene Louvres(int n) {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.6), slat = sketch.Material("slat", 0.5),
                 lamp = sketch.Material("lamp", 0.3, 100);
  sketch.Box({0, 0, 0}, {2, 2, 2}, true, wall, kFrontTakesPart);
  sketch.Rectangle(2, 1.9, {0.5, 0.5}, {1.5, 1.5}, false, lamp, kBothTakePart | kFrontEmits);
  for (int i = 0; i < n; ++i) {
    const double x = 0.1 + 1.8 * i / n, width = 1.8 / n;
    sketch.Polygon({{x, 0.1, 1.5},
                    {x + 0.8 * width, 0.1, 1.5 + width},
                    {x + 0.8 * width, 1.9, 1.5 + width},
                    {x, 1.9, 1.5}},
                   slat, kBothTakePart);
  }
  return sketch.Take();
}

TEST(HardRooms, TiledWall) {
  constexpr int kSmall = 40, kMost = 224;  // squares along a side
  const int n = kLarge ? kMost : kSmall;
  const std::string room =
      Of("a floor of {} triangles in one plane", 2 * kSmall * kSmall, 2 * kMost * kMost);
  HardCase few(kLarge ? "41L" : "41", room, "links over polygons", 50);
  HardCase memory(kLarge ? "41La" : "41a", room, "bytes of links and nodes over polygons", 5000);
  const Scene scene = TiledFloor(n);
  const SolveResult result = SolveScene(scene, ToAccuracy(0.1));
  const auto polygons = static_cast<double>(scene.polygons.size());
  const std::string where = fmt::format("{} polygons, {} links", polygons, Last(result).links);
  few.Measure(static_cast<double>(Last(result).links) / polygons, where);
  memory.Measure(static_cast<double>(Last(result).memory_bytes) / polygons, where);
  HardCase conserved(kLarge ? "41Lb" : "41b", room, "energy imbalance over the error estimate", 1);
  conserved.Measure(Last(result).energy_imbalance / Last(result).error_estimate, where);
}

TEST(HardRooms, LampOfManyPolygonsByTheCeiling) {
  constexpr int kSmall = 12, kMost = 100;  // squares along a side
  const std::string room =
      Of("a lamp of {} polygons 1 mm below the ceiling", kSmall * kSmall, kMost * kMost);
  HardCase few(kLarge ? "66L" : "66", room, "links over polygons", 200);
  HardCase conserved(kLarge ? "66La" : "66a", room, "energy imbalance over the error estimate", 1);
  HardCase bounded(kLarge ? "66Lb" : "66b", room, "largest B over E / (1 - largest rho)", 1);
  const Scene scene = TiledLamp(kLarge ? kMost : kSmall, 1e-3);
  const SolveResult result = SolveScene(scene, ToAccuracy(0.1));
  const auto polygons = static_cast<double>(scene.polygons.size());
  const std::string where = fmt::format("{} polygons, {} links", polygons, Last(result).links);
  few.Measure(static_cast<double>(Last(result).links) / polygons, where);
  conserved.Measure(Last(result).energy_imbalance / Last(result).error_estimate, where);
  for (const PatchVertex& vertex : result.patch.vertices)
    bounded.Measure(vertex.radiosity[0] * 0.4 / 100, where);
}

TEST(HardRooms, Dust) {
  constexpr int kSmall = 200, kMost = 1667;  // boxes
  const std::string room =
      Of("{} polygons in a cube of 1e-3 in a room of 1", 6 * kSmall, 6 * kMost);
  HardCase few(kLarge ? "42L" : "42", room, "links over polygons", 50);
  HardCase conserved(kLarge ? "42La" : "42a", room, "energy imbalance over the error estimate", 1);
  const Scene scene = DustInARoom(kLarge ? kMost : kSmall);
  const SolveResult result = SolveScene(scene, ToAccuracy(0.1));
  const auto polygons = static_cast<double>(scene.polygons.size());
  const std::string where = fmt::format("{} polygons, {} links", polygons, Last(result).links);
  few.Measure(static_cast<double>(Last(result).links) / polygons, where);
  conserved.Measure(Last(result).energy_imbalance / Last(result).error_estimate, where);
}

TEST(HardRooms, Slats) {
  constexpr int kSmall = 24, kMost = 100;  // slats
  const std::string room = Of(kLarge ? "{} louvres below a lamp, accuracy .1 against .03"
                                     : "{} louvres below a lamp, accuracy .1 against .05",
                              kSmall, kMost);
  HardCase near(kLarge ? "18L" : "18", room, "difference over the sum of the estimates", 1);
  HardCase conserved(kLarge ? "18La" : "18a", room, "energy imbalance over the error estimate", 1);
  const Scene scene = Louvres(kLarge ? kMost : kSmall);
  const SolveResult coarse = SolveScene(scene, ToAccuracy(0.1));
  const SolveResult fine = SolveScene(scene, ToAccuracy(kLarge ? 0.03 : 0.05));
  near.Measure(L1(coarse.patch, fine.patch) /
               (Last(coarse).error_estimate + Last(fine).error_estimate));
  conserved.Measure(Last(coarse).energy_imbalance / Last(coarse).error_estimate);
  conserved.Measure(Last(fine).energy_imbalance / Last(fine).error_estimate);
}

// ---- what must hold whatever the scene

struct Invariants {
  static constexpr const char* kRooms =
      kLarge ? "random closed rooms at 10 %, to 50,000 links" : "random closed rooms at 50 %";
  HardCase finite{kLarge ? "70L" : "70", kRooms, "numbers that are negative or not finite", 0};
  HardCase emits{kLarge ? "70La" : "70a", kRooms, "(E - B) / E of a face", 1e-6};
  HardCase bounded{kLarge ? "70Lb" : "70b", kRooms, "largest B over max E / (1 - largest rho)", 1};
  HardCase conserved{kLarge ? "70Lc" : "70c", kRooms, "energy imbalance over the error estimate",
                     1};

  void Measure(const Scene& scene, const SolveResult& result, const std::string& where) {
    Rgb rho(0.0), exitance(0.0), brightest(0.0);
    for (const Material& material : scene.materials) {
      rho = glm::max(rho, material.reflectance);
      exitance = glm::max(exitance, material.exitance);
    }
    double wrong = 0, less = -1;
    const auto check = [&](const std::array<float, 3>& values) {
      for (const float v : values) wrong += std::isfinite(v) && v >= 0 ? 0 : 1;
    };
    for (const PatchVertex& vertex : result.patch.vertices) {
      check(vertex.irradiance);
      check(vertex.radiosity);
      for (int c = 0; c < 3; ++c)
        brightest[c] = std::max<double>(brightest[c], vertex.radiosity[c]);
    }
    for (const PatchFace& face : result.patch.faces) {
      check(face.irradiance);
      check(face.radiosity);
      for (int c = 0; c < 3; ++c) {
        if (face.emission[c] > 0)
          less = std::max<double>(less, 1 - face.radiosity[c] / face.emission[c]);
      }
    }
    finite.Measure(wrong, where);
    emits.Measure(less, where);
    for (int c = 0; c < 3; ++c) bounded.Measure(brightest[c] * (1 - rho[c]) / exitance[c], where);
    conserved.Measure(Last(result).energy_imbalance / Last(result).error_estimate, where);
  }
};

TEST(HardRooms, RandomClosedRooms) {
  Invariants invariants;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const Scene scene = RandomClosedRoom(seed);
    ASSERT_TRUE(Validate(scene).ok())
        << "seed " + std::to_string(seed) << Validate(scene).message();
    SolveOptions options = ToAccuracy(kLarge ? 0.1 : 0.5);
    options.max_links = kLarge ? 50'000 : 3'000;
    invariants.Measure(scene, SolveScene(scene, options), "seed " + std::to_string(seed));
  }
}

}  // namespace
}  // namespace isolux::testing
