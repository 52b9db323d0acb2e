// Hard cases of what light passes and what it does not: openings, sheets, floors of many pieces.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/hard_cases/hard_case.h"
#include "tests/support/dense_transport.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "worker/radiosity/solver.h"

namespace isolux::testing {
namespace {

SolveOptions ToAccuracy(double accuracy) {
  SolveOptions options;
  options.accuracy = accuracy;
  return options;
}

SolveResult SolveScene(const Scene& scene, const SolveOptions& options) {
  EXPECT_TRUE(Validate(scene).ok()) << Validate(scene).message();
  Result<SolveResult> result = SolveInProcess(scene, options, 1, 2);
  EXPECT_TRUE(result.has_value()) << result.error().message();
  return result ? std::move(*result) : SolveResult{};
}

const RoundSummary& Last(const SolveResult& result) { return result.summary.rounds.back(); }

// Power that arrives at faces of polygons from `first` on, W, in the first channel.
double ArrivingAt(const PatchFile& patch, uint32_t first) {
  double sum = 0;
  for (const PatchFace& face : patch.faces) {
    if (face.polygon < first) continue;
    Vec3 area(0.0);
    for (size_t i = 0; i < face.vertices.size(); ++i) {
      area +=
          0.5 * glm::cross(patch.vertices[face.vertices[i]].position,
                           patch.vertices[face.vertices[(i + 1) % face.vertices.size()]].position);
    }
    sum += glm::length(area) * face.irradiance[0];
  }
  return sum;
}

// ---- what no light reaches

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
  HardCase dark("43a", "a room divided by one sheet, light on one side",
                "largest irradiance on the other", 0);
  const SolveResult result = SolveScene(DividedRoom(0.1), ToAccuracy(0.05));
  dark.Measure(0);  // dark surfaces are left out of the file
  for (const PatchFace& face : result.patch.faces)
    if (OnTheDarkSide(face))
      dark.Measure(face.irradiance[0], fmt::format("polygon {}", face.polygon));
}

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

TEST(HardRooms, TiledWall) {
  HardCase conserved("41b", "a floor of many triangles in one plane",
                     "energy imbalance over the error estimate", 1);
  for (const int n : {4, 10, 20, 40}) {
    const SolveResult result = SolveScene(TiledFloor(n), ToAccuracy(0.1));
    conserved.Measure(Last(result).energy_imbalance / Last(result).error_estimate,
                      fmt::format("{} triangles", 2 * n * n));
  }
}

}  // namespace
}  // namespace isolux::testing
