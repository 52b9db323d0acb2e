// Rooms with maps, solved by a whole cluster: what must hold wherever light falls.
#include <gtest/gtest.h>

#include <algorithm>

#include "client/output/comparison.h"
#include "common/hierarchy/effects/plan.h"
#include "common/util/random.h"
#include "tests/support/link_bench.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"
#include "worker/coupling/point_factor.h"

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
  for (const PatchVertex& vertex : result.patch.vertices)
    EXPECT_NEAR(vertex.radiosity[0], 1, 0.003);
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

// A room of 2 x 2 x 1 m whose floor, or a corner of it of this width, reflects .7 and .1 in strips,
// under a lamp that hangs close above a bright one.
Scene WithStrips(double width_m) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.5));
  Scene scene = BoxRoom({2, 2, 1}, faces);
  const auto add = [&](const std::array<Vec3, 4>& corners, const Material& material) {
    Polygon polygon;
    for (size_t i = 0; i < 4; ++i) {
      polygon.vertices[i] = static_cast<uint32_t>(scene.vertices.size());
      scene.vertices.push_back(corners[i]);
    }
    polygon.sides = kFrontTakesPart | kFrontEmits;
    polygon.file_polygon = scene.file_polygon_count++;
    polygon.material = static_cast<uint32_t>(scene.materials.size());
    scene.polygons.push_back(polygon);
    scene.materials.push_back(material);
  };
  const double w = width_m, z = 0.02;
  add({Vec3(0, 0, z), {w, 0, z}, {w, w, z}, {0, w, z}}, {"strips", Rgb(0.4), Rgb(0.0)});
  scene.materials.back().reflectance_map.texture = 0;
  scene.polygons.back().coordinates = 0;
  add({Vec3(.2, .2, .3), {.2, 1.8, .3}, {.8, 1.8, .3}, {.8, .2, .3}}, {"lamp", Rgb(0.3), Rgb(1.0)});
  double mean = 0;
  scene.textures = {Relative({.7, .1, .7, .1}, 2, &mean)};
  scene.coordinates = {{{1 / w, 0, 0, 0}, {0, 1 / w, 0, 0}}};
  return scene;
}

// Of the irradiance, over its mean.
double CostOfNeglect(const Scene& scene) {
  const SolveResult with = SolveScene(scene, 0.02, "+textures");
  const SolveResult without = SolveScene(scene, 0.02, "-textures");
  return Compare(without.patch, with.patch, {.samples = 1 << 14}).value().l1_relative;
}

TEST(Textures, NeglectCostsNoMoreThanItsBound) {
  const auto row_of = [](const Scene& scene, double accuracy) {
    const EffectsTable table = PlanEffects(Hierarchy(scene), accuracy, {});
    return *std::ranges::find(table.effects, "textures", &Effect::name);
  };
  const Scene large = WithStrips(2);
  Effect row = row_of(large, 0.02);
  ASSERT_TRUE(row.present && row.bound.has_value());
  EXPECT_TRUE(row.on);
  const double cost = CostOfNeglect(large);
  EXPECT_GT(cost, 0.05);  // of which some may be error of either
  EXPECT_LT(cost, *row.bound);
  // A card of 20 cm: by its area and deviation.
  const Scene small = WithStrips(0.2);
  row = row_of(small, 0.02);
  EXPECT_LT(*row.bound, 0.5 * *row_of(large, 0.02).bound);
  EXPECT_LT(CostOfNeglect(small), *row.bound);
  EXPECT_FALSE(row_of(small, 0.999 * 5 * 1.1 * *row.bound).on);
  EXPECT_TRUE(row_of(small, 0.9 * 5 * *row.bound).on);
}

// A black room under a ceiling that shines, chequered or evenly.
Scene UnderCeiling(bool chequered) {
  BoxFaces faces;
  faces.exitance[5] = Rgb(1);
  Scene scene = BoxRoom({1, 1, 0.4}, faces);
  if (!chequered) return scene;
  double mean = 0;
  scene.textures = {Relative({1.9, .1, .1, 1.9}, 2, &mean)};
  scene.coordinates = {{{1, 0, 0, 0}, {0, 1, 0, 0}}};
  scene.materials[scene.polygons[5].material].exitance_map.texture = 0;
  scene.polygons[5].coordinates = 0;
  return scene;
}

// What the chequers bring to a point of the floor.
double FromChequers(const Hierarchy& chequered, const Vec3& point) {
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const int column = i % 2, row = i / 2;
    const double x = 0.5 * column, y = 0.5 * row, z = 0.4;
    const ConvexPolygon square(
        4, {Vec3(x, y, z), {x, y + .5, z}, {x + .5, y + .5, z}, {x + .5, y, z}});
    sum += chequered.maps().Over(chequered.surfaces()[5], square).exitance[0] *
           PointFormFactors(Vec3x4(std::array<Vec3, 4>{point, point, point, point}), {0, 0, 1},
                            square.v)[0];
  }
  return sum;
}

// Links that were refined by these lamps, with the light of the chequers: how far what they bring
// to the floor is off, over its mean.
double ErrorUnderChequers(LinkBench& bench, const Hierarchy& chequered) {
  std::vector<Lanes> radiosity;
  for (const uint32_t leaf : bench.nodes.leaves) {
    const Surface& surface = bench.tree.surface_of(leaf);
    const bool lamp = surface.polygon == 5;
    const auto exitance = chequered.maps().Over(surface, bench.tree.polygon(leaf)).exitance[0];
    radiosity.push_back(Splat(lamp ? exitance : 0));
  }
  const std::vector<Lanes> irradiance = bench.Irradiance(radiosity);
  double off = 0, sum = 0;
  for (size_t i = 0; i < irradiance.size(); ++i) {
    const uint32_t leaf = bench.nodes.leaves[i];
    if (bench.tree.surface_of(leaf).polygon != 4) continue;
    const ConvexPolygon& element = bench.tree.polygon(leaf);
    for (int k = 0; k < 64; ++k) {
      const int column = k % 8, row = k / 8;
      const double u = (column + 0.5) / 8, v = (row + 0.5) / 8;
      const Vec3 point = (1 - v) * ((1 - u) * element.v[0] + u * element.v[1]) +
                         v * ((1 - u) * element.v[3] + u * element.v[2]);
      const double exact = FromChequers(chequered, point);
      off += element.Area() * std::abs(irradiance[i][0] - exact);
      sum += element.Area() * exact;
    }
  }
  return off / sum;
}

// The variance of a map counts where links are judged: at the same threshold there are more of them
// than below an even lamp of the same power, and these bring the light of the chequers better.
TEST(Textures, VarianceFeedsRefinement) {
  LinkBench even(UnderCeiling(false), 2e-3, 2, false), uneven(UnderCeiling(true), 2e-3, 2, false);
  EXPECT_NEAR(even.epsilon_w, uneven.epsilon_w, 1e-9);
  EXPECT_GT(uneven.links.own.size(), 3 * even.links.own.size());
  const double without = ErrorUnderChequers(even, uneven.hierarchy),
               with = ErrorUnderChequers(uneven, uneven.hierarchy);
  EXPECT_LT(with, 0.6 * without);
}

// Off, light meets the mean, and the output shows the map all the same.
TEST(Textures, SwitchedOffTheMeanCarriesTheLight) {
  const Scene scene = WithStrips(2);
  Scene plain = scene;
  plain.materials[plain.materials.size() - 2].reflectance_map.texture = kNoTexture;
  const SolveResult off = SolveScene(scene, 0.05, "-textures"), even = SolveScene(plain, 0.05, "");
  EXPECT_NEAR(off.summary.rounds.back().absorbed_w[0], even.summary.rounds.back().absorbed_w[0],
              1e-6);
  EXPECT_EQ(off.summary.rounds.back().links, even.summary.rounds.back().links);
  double least = 1, most = 0;
  for (const PatchFace& face : off.patch.faces) {
    if (face.polygon != scene.polygons[6].file_polygon || !(face.irradiance[0] > 0)) continue;
    const double reflected = face.radiosity[0] / face.irradiance[0];
    least = std::min(least, reflected);
    most = std::max(most, reflected);
  }
  EXPECT_NEAR(least, 0.1, 1e-3);
  EXPECT_NEAR(most, 0.7, 1e-3);
}

}  // namespace
}  // namespace isolux::testing
