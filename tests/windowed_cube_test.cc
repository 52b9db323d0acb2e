// A unit cube with a square window under an even sky, whose walls emit what the window's radiance
// leaves them short of: every point receives πL, whatever the walls reflect, and every row and what
// of it escapes add up to 1.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/hard_scenes.h"
#include "tests/support/link_bench.h"
#include "tests/support/solve_scene.h"
#include "worker/coupling/point_factor.h"

namespace isolux::testing {
namespace {

using std::numbers::pi;

constexpr double kWindow = 0.5;  // its side, in the middle of the wall x = 1

// Fronts inwards; walls emit E.
Scene WindowedCube(double reflectance, double exitance) {
  SceneSketch sketch;
  const uint8_t sides = kFrontTakesPart | (exitance > 0 ? kFrontEmits : 0);
  const uint32_t wall = sketch.Material("wall", reflectance, exitance);
  sketch.Box({0, 0, 0}, {1, 1, 1}, true, wall, sides);
  Scene scene = sketch.Take();
  scene.polygons.erase(scene.polygons.begin() + 1);  // x high
  sketch = SceneSketch(std::move(scene));
  const size_t first = 5;
  sketch.WallWithHole(0, 1, {0, 0}, {1, 1}, {0.5, 0.5}, kWindow, wall, sides);
  scene = sketch.Take();
  for (size_t p = first; p < scene.polygons.size(); ++p) {  // seen from within
    std::swap(scene.polygons[p].vertices[1], scene.polygons[p].vertices[3]);
  }
  return scene;
}

Sky EvenSky(double radiance) {
  Sky sky;
  sky.columns = sky.rows = 1;
  sky.texels.assign(3, static_cast<float>(radiance));
  return sky;
}

// Of the window, from a point of a wall of this normal.
double WindowFactor(const Vec3& point, const Vec3& normal) {
  const double low = 0.5 * (1 - kWindow), high = 0.5 * (1 + kWindow);
  const std::array<Vec3, 4> window = {Vec3(1, low, low), Vec3(1, low, high), Vec3(1, high, high),
                                      Vec3(1, high, low)};
  return PointFormFactors(Vec3x4(std::array<Vec3, 4>{point, point, point, point}), normal,
                          window)[0];
}

// Its mean over a quad, by midpoints.
double WindowFactor(const ConvexPolygon& quad) {
  constexpr int kSide = 16;
  double sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double u = (i % kSide + 0.5) / kSide, v = (i / kSide + 0.5) / kSide;
    const Vec3 point =
        (1 - v) * ((1 - u) * quad.v[0] + u * quad.v[1]) + v * ((1 - u) * quad.v[3] + u * quad.v[2]);
    sum += WindowFactor(point, quad.Normal());
  }
  return sum / (kSide * kSide);
}

TEST(WindowedCube, EveryPointReceivesPiTimesTheSky) {
  const double rho = 0.8, radiance = 2, even = pi * radiance, window = kWindow * kWindow;
  SolveOptions options = ToAccuracy(0.3);
  options.epsilons = {1};
  Scene scene = WindowedCube(rho, (1 - rho) * even);
  scene.sky = EvenSky(radiance);
  const SolveResult result = SolveScene(scene, options);
  double off = 0;
  for (const PatchVertex& vertex : result.patch.vertices) {
    EXPECT_NEAR(vertex.irradiance[0] / even, 1, 0.02);
    off += std::abs(vertex.irradiance[0] / even - 1);
  }
  EXPECT_LT(off / static_cast<double>(result.patch.vertices.size()), 0.004);
  for (const PatchFace& face : result.patch.faces) {
    EXPECT_NEAR(face.radiosity[1] / even, 1, 0.05);  // one round's
  }
  // As much leaves by the window as comes in.
  const RoundSummary& last = result.summary.rounds.back();
  const double area = 6 - window;
  EXPECT_NEAR(last.emitted_w[2] / even, (1 - rho) * area + window, 0.004);
  EXPECT_NEAR(last.absorbed_w[2] / even, (1 - rho) * area, 0.008);
  EXPECT_NEAR(last.escaped_w[2] / even, window, 0.004);
  EXPECT_LT(last.energy_imbalance, 0.002);
}

// What rays say of each wall against the window's form factor in closed form, and the raw rows of
// the leaves, that no closure has seen, against what it leaves them.
TEST(WindowedCube, RowsAndWhatEscapesAddUpToOne) {
  LinkBench bench(WindowedCube(0.5, 1), 3e-4);
  const Scout scout = ScoutEscapes(bench.hierarchy, bench.rays, Mirrors(), TranslucentSheets(),
                                   0.02, 1, bench.pool);
  for (uint32_t s = 0; s < bench.hierarchy.surfaces().size(); ++s) {
    const Surface& surface = bench.hierarchy.surfaces()[s];
    const double exact = WindowFactor(SideGeometry(bench.scene, surface.polygon, surface.side));
    EXPECT_NEAR(scout.escape[s], exact, 4 * EscapeDeviation(exact, scout.rays[s]) + 1e-6) << s;
  }
  const std::vector<Lanes> rows =
      bench.Irradiance(std::vector<Lanes>(bench.system.size(), Splat(1)));
  double off = 0, rows_m2 = 0, escapes_m2 = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    const double exact = WindowFactor(bench.tree.polygon(bench.nodes.leaves[i]));
    const double area_m2 = bench.system.area_m2[i];
    rows_m2 += area_m2 * rows[i][0];
    escapes_m2 += area_m2 * exact;
    off += area_m2 * std::abs(rows[i][0] + exact - 1);
  }
  const double area_m2 = 6 - kWindow * kWindow;
  EXPECT_NEAR(escapes_m2, kWindow * kWindow, 1e-3);  // by reciprocity: all of the window
  EXPECT_NEAR(rows_m2 + escapes_m2, area_m2, 3e-4 * area_m2);
  EXPECT_LT(off / area_m2, 0.1);  // links of the nodes above spread evenly over their leaves
}

}  // namespace
}  // namespace isolux::testing
