// Mirrors through whole solves: rooms against the same rooms unfolded, exact irradiance of lamps in
// mirrors with edges, energy, and that a scene without mirrors is solved as if there were no such
// thing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/hierarchy/effects/plan.h"
#include "common/hierarchy/mirrors.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "worker/coupling/point_factor.h"

namespace isolux::testing {
namespace {

SolveResult Solve(const Scene& scene, double accuracy, const std::string& effects = "",
                  int workers = 1) {
  SolveOptions options;
  options.accuracy = accuracy;
  options.effects = effects;
  auto result = SolveInProcess(scene, options, workers, 2);
  EXPECT_TRUE(result.has_value()) << result.error().message();
  return result.has_value() ? std::move(*result) : SolveResult{};
}

// Irradiance over all of one polygon of the file, W.
double PowerOn(const SolveResult& result, uint32_t polygon) {
  double power = 0;
  for (const PatchFace& face : result.patch.faces) {
    if (face.polygon != polygon) continue;
    Vec3 area(0.0);
    for (size_t i = 0; i < face.vertices.size(); ++i) {
      area += 0.5 * glm::cross(
                        result.patch.vertices[face.vertices[i]].position,
                        result.patch.vertices[face.vertices[(i + 1) % face.vertices.size()]].position);
    }
    power += glm::length(area) * face.irradiance[0];
  }
  return power;
}

void MakeMirror(Scene& scene, uint32_t polygon, double share) {
  Material mirror = scene.materials[scene.polygons[polygon].material];
  mirror.specular = share;
  mirror.reflectance *= 1 - share;
  scene.polygons[polygon].material = static_cast<uint32_t>(scene.materials.size());
  scene.materials.push_back(mirror);
}

// A room from x = 0 to `length`, one wall of which shines.
Scene Room(double length, std::initializer_list<int> lamps) {
  BoxFaces faces;
  faces.reflectance = {Rgb(.3), Rgb(.3), Rgb(.5), Rgb(.2), Rgb(.6), Rgb(.4)};
  for (const int lamp : lamps) faces.exitance[lamp] = Rgb(1);
  return BoxRoom({length, 1, 1.5}, faces);
}

double Last(const SolveResult& result) {
  return result.summary.rounds.back().energy_imbalance;
}

TEST(Mirrors, APerfectMirrorDoublesTheRoom) {
  Scene half = Room(1, {1, 4}), whole = Room(2, {0, 1, 4});
  MakeMirror(half, 0, 1);
  half.materials[half.polygons[0].material].reflectance = Rgb(0.0);
  const SolveResult mirrored = Solve(half, 0.01), unfolded = Solve(whole, 0.01);
  EXPECT_LT(Last(mirrored), 1e-3);
  for (uint32_t p = 1; p < 6; ++p) {
    const double expected = PowerOn(unfolded, p) * (p == 1 ? 1 : 0.5);
    EXPECT_NEAR(PowerOn(mirrored, p) / expected, 1, 0.004) << p;
  }
}

}  // namespace
}  // namespace isolux::testing
