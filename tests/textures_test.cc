// Rooms with maps, solved by a whole cluster: what must hold wherever light falls.
#include <gtest/gtest.h>

#include "common/util/random.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

SolveOptions ShortSolve() {
  SolveOptions options;
  options.accuracy = 0.05;
  options.epsilons = {0.2, 0.05};
  options.cut_size = 64;
  return options;
}

// Values relative to their mean; the first becomes the mean.
Texture Relative(const std::vector<double>& values, uint32_t side, double* mean) {
  *mean = 0;
  for (const double v : values) *mean += v / static_cast<double>(values.size());
  Texture texture{side, side, Wrap::kRepeat, Wrap::kMirror, {}};
  for (const double v : values) {
    for (int c = 0; c < 3; ++c) texture.texels.push_back(static_cast<float>(v / *mean));
  }
  return texture;
}

// Every polygon of one material reflects ρ by a map of random texels and, in a furnace, emits 1 − ρ
// texel by texel; else it emits as before.
Scene WithMap(Scene scene, bool furnace) {
  constexpr uint32_t kSide = 6;
  Random random(3);
  std::vector<double> reflectance, exitance;
  for (uint32_t i = 0; i < kSide * kSide; ++i) {
    reflectance.push_back(0.1 + 0.8 * random.Unit());
    exitance.push_back(1 - reflectance.back());
  }
  double rho = 0, e = 0;
  scene.textures = {Relative(reflectance, kSide, &rho)};
  if (furnace) scene.textures.push_back(Relative(exitance, kSide, &e));
  for (Material& material : scene.materials) {
    material.reflectance = Rgb(rho);
    material.reflectance_map.texture = 0;
    if (!furnace) continue;
    material.exitance = Rgb(e);
    material.exitance_map.texture = 1;
  }
  scene.coordinates = {{{0.7, 0.4, 0.2, 0.1}, {-0.3, 0.6, 0.5, 0}}};
  for (Polygon& polygon : scene.polygons) {
    polygon.coordinates = 0;
    if (furnace) polygon.sides = kFrontTakesPart | kFrontEmits;
  }
  return scene;
}

SolveResult Solve(const Scene& scene, int workers) {
  LocalCluster cluster(workers, 2);
  Result<SolveResult> result = RunJob(cluster, MakeJobInput(scene, ShortSolve()), {});
  EXPECT_TRUE(result.has_value()) << result.error().message();
  return result.has_value() ? *std::move(result) : SolveResult();
}

// Kirchhoff: where E = 1 − ρ at every point, the radiosity is 1 at every point.
TEST(Textures, FurnaceGlowsEvenly) {
  const SolveResult result = Solve(WithMap(FurnaceCube(0.5, 0.5), true), 2);
  ASSERT_GT(result.patch.faces.size(), 100U);
  const double most = 1e-3;
  double lowest_emission = 1, highest_emission = 0;
  for (const PatchFace& face : result.patch.faces) {
    EXPECT_NEAR(face.radiosity[0], 1, most);
    EXPECT_NEAR(face.irradiance[1], 1, most);
    lowest_emission = std::min<double>(lowest_emission, face.emission[2]);
    highest_emission = std::max<double>(highest_emission, face.emission[2]);
  }
  for (const PatchVertex& vertex : result.patch.vertices) EXPECT_NEAR(vertex.radiosity[0], 1, 0.05);
  EXPECT_LT(lowest_emission, 0.3);  // the faces show the map
  EXPECT_GT(highest_emission, 0.7);
  EXPECT_LT(result.summary.rounds.back().energy_imbalance, 1e-3);
}

TEST(Textures, EnergyIsKeptAndBitsAreTheSame) {
  const Scene scene = WithMap(RandomRoom(3, 1), false);  // closed
  SolveResult one = Solve(scene, 1), three = Solve(scene, 3);
  EXPECT_LT(one.summary.rounds.back().energy_imbalance, 0.005);
  EXPECT_EQ(BytesWithoutComments(std::move(one.patch)),
            BytesWithoutComments(std::move(three.patch)));
}

// A map that is 1 everywhere changes nothing but the bytes of the scene.
TEST(Textures, EvenMapChangesNothing) {
  Scene plain = CornellBox(true), mapped = plain;
  mapped.textures = {Texture{2, 2, Wrap::kClamp, Wrap::kRepeat, std::vector<float>(12, 1.0F)}};
  mapped.coordinates = {{{1, 0, 0, 0}, {0, 1, 0.5, 0}}};
  for (Material& material : mapped.materials) material.reflectance_map.texture = 0;
  for (Polygon& polygon : mapped.polygons) polygon.coordinates = 0;
  const SolveResult a = Solve(plain, 2), b = Solve(mapped, 2);
  ASSERT_EQ(a.patch.faces.size(), b.patch.faces.size());
  for (size_t f = 0; f < a.patch.faces.size(); ++f) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(a.patch.faces[f].radiosity[c], b.patch.faces[f].radiosity[c],
                  1e-5 * a.patch.faces[f].radiosity[c]);
    }
  }
}

}  // namespace
}  // namespace isolux::testing
