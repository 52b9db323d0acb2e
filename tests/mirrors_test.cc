// Mirrors through whole solves: rooms against the same rooms unfolded, exact irradiance of lamps in
// mirrors with edges, energy, and that a scene without mirrors is solved as if there were no such
// thing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/output/comparison.h"
#include "common/hierarchy/effects/plan.h"
#include "common/hierarchy/mirrors.h"
#include "tests/support/local_cluster.h"
#include "tests/support/path_tracer.h"
#include "tests/support/same_bits.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"
#include "worker/coupling/point_factor.h"

namespace isolux::testing {
namespace {

SolveResult Solve(const Scene& scene, double accuracy, const std::string& effects = "",
                  int workers = 1) {
  return SolveScene(scene, accuracy, effects, workers);
}

// Irradiance over all of one polygon of the file, W.
double PowerOn(const SolveResult& result, uint32_t polygon) {
  double power = 0;
  for (const PatchFace& face : result.patch.faces) {
    if (face.polygon != polygon) continue;
    Vec3 area(0.0);
    for (size_t i = 0; i < face.vertices.size(); ++i) {
      area +=
          0.5 *
          glm::cross(result.patch.vertices[face.vertices[i]].position,
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

double Imbalance(const SolveResult& result) {
  return result.summary.rounds.back().energy_imbalance;
}

double FactorAt(const Vec3& point, const Vec3& normal, std::span<const Vec3> polygon) {
  const std::array<Vec3, 4> points = {point, point, point, point};
  return PointFormFactors(Vec3x4(points), normal, polygon)[0];
}

// From a point of the screen, of the image of the lamp in the mirror of MirrorsHaveEdges, with half
// sides b and a: what shows on the mirror, a rectangle, less what the back of the lamp hides of it.
double SeenIn(const Vec3& x, double a, double b) {
  std::array<Vec3, 2> low{}, high{};  // seen; of that, hidden
  for (const int c : {1, 2}) {
    low[0][c] = std::max(-a, (x[c] - 2 * b) / 3);
    high[0][c] = std::min(a, (x[c] + 2 * b) / 3);
    low[1][c] = std::max(low[0][c], -2 * b - x[c]);
    high[1][c] = std::min(high[0][c], 2 * b - x[c]);
  }
  const auto factor = [&](int i) {
    if (!(high[i].y > low[i].y && high[i].z > low[i].z)) return 0.0;
    const std::array<Vec3, 4> part = {Vec3(0, low[i].y, low[i].z), Vec3(0, high[i].y, low[i].z),
                                      Vec3(0, high[i].y, high[i].z), Vec3(0, low[i].y, high[i].z)};
    return FactorAt(x, {-1, 0, 0}, part);
  };
  return factor(0) - factor(1);
}

TEST(Mirrors, APerfectMirrorDoublesTheRoom) {
  Scene half = Room(1, {1, 4}), whole = Room(2, {0, 1, 4});
  MakeMirror(half, 0, 1);
  half.materials[half.polygons[0].material].reflectance = Rgb(0.0);
  const SolveResult mirrored = Solve(half, 0.01), unfolded = Solve(whole, 0.01);
  EXPECT_LT(Imbalance(mirrored), 1e-3);
  for (uint32_t p = 1; p < 6; ++p) {
    const double expected = PowerOn(unfolded, p) * (p == 1 ? 1 : 0.5);
    EXPECT_NEAR(PowerOn(mirrored, p) / expected, 1, 0.004) << p;
  }
}

// Two walls at right angles: three images, two of which meet in the edge.
TEST(Mirrors, ACornerOfMirrorsUnfoldsToFourRooms) {
  Scene quarter = Room(1, {1, 4});
  MakeMirror(quarter, 0, 1);
  MakeMirror(quarter, 2, 1);
  for (const uint32_t p : {0, 2}) {
    quarter.materials[quarter.polygons[p].material].reflectance = Rgb(0.0);
  }
  BoxFaces faces;
  faces.reflectance = {Rgb(.3), Rgb(.3), Rgb(.2), Rgb(.2), Rgb(.6), Rgb(.4)};
  faces.exitance[0] = faces.exitance[1] = faces.exitance[4] = Rgb(1);
  const SolveResult mirrored = Solve(quarter, 0.008);
  const SolveResult unfolded = Solve(BoxRoom({2, 2, 1.5}, faces), 0.008);
  EXPECT_LT(Imbalance(mirrored), 1e-3);
  for (const uint32_t p : {1, 3, 4, 5}) {
    const double expected = PowerOn(unfolded, p) * (p < 4 ? 0.5 : 0.25);
    EXPECT_NEAR(PowerOn(mirrored, p) / expected, 1, 0.004) << p;
  }
}

// Between mirrors on all sides everything of the floor that is not lost on the way reaches the
// ceiling: of the irradiance at height h, Σ k^n of the shares that n reflections take.
TEST(Mirrors, FacingMirrorsCarryLightOn) {
  // Floor and ceiling, two walls of black, two of mirrors: the same as a room without end.
  BoxFaces faces;
  faces.exitance[4] = Rgb(1);
  Scene scene = BoxRoom({1, 4, 1}, faces);
  MakeMirror(scene, 0, 0.7);
  MakeMirror(scene, 1, 0.7);
  const SolveResult result = Solve(scene, 0.01);
  double error = 0, total = 0;
  for (const PatchFace& face : result.patch.faces) {
    if (face.polygon != 5) continue;
    for (const uint32_t v : face.vertices) {
      const PatchVertex& vertex = result.patch.vertices[v];
      double expected = 0;
      for (int k = -60; k <= 60; ++k) {
        const std::array<Vec3, 4> lamp = {Vec3(k, 0, 0), Vec3(k + 1, 0, 0), Vec3(k + 1, 4, 0),
                                          Vec3(k, 4, 0)};
        expected += std::pow(0.7, std::abs(k)) * FactorAt(vertex.position, {0, 0, -1}, lamp);
      }
      error += std::abs(vertex.irradiance[0] - expected);
      total += expected;
    }
  }
  EXPECT_LT(error / total, 0.002);
  EXPECT_LT(Imbalance(result), 5e-3);
}

// A mirror in the middle of a black wall, a lamp in the middle of the wall before it: what of the
// lamp's image shows in the mirror is a rectangle on the mirror.
TEST(Mirrors, MirrorsHaveEdges) {
  Scene scene;
  scene.materials = {{"black", Rgb(0.0), Rgb(0.0)}, {"lamp", Rgb(0.0), Rgb(1)}};
  scene.materials.push_back({"mirror", Rgb(0.0), Rgb(0.0)});
  scene.materials.back().specular = 0.8;
  const auto add = [&](const std::array<Vec3, 4>& corners, uint32_t material, uint8_t sides) {
    Polygon polygon;
    for (int i = 0; i < 4; ++i) {
      polygon.vertices[i] = static_cast<uint32_t>(scene.vertices.size());
      scene.vertices.push_back(corners[i]);
    }
    polygon.material = material;
    polygon.sides = sides;
    polygon.file_polygon = scene.file_polygon_count++;
    scene.polygons.push_back(polygon);
  };
  const double a = 0.4, b = 0.3;  // half sides of mirror and lamp
  add({Vec3(0, -a, -a), Vec3(0, a, -a), Vec3(0, a, a), Vec3(0, -a, a)}, 2, kFrontTakesPart);
  add({Vec3(1, -b, -b), Vec3(1, -b, b), Vec3(1, b, b), Vec3(1, b, -b)}, 1,
      kFrontTakesPart | kFrontEmits);
  // The screen, behind the lamp's plane, which hides a part of the mirror.
  add({Vec3(2, -1, -1), Vec3(2, -1, 1), Vec3(2, 1, 1), Vec3(2, 1, -1)}, 0, kFrontTakesPart);
  const SolveResult result = Solve(scene, 0.01);
  double error = 0, total = 0;
  for (const PatchFace& face : result.patch.faces) {
    if (face.polygon != 2) continue;
    for (const uint32_t v : face.vertices) {
      const PatchVertex& vertex = result.patch.vertices[v];
      // By way of x = 0 the image of the lamp is at x = −1, seen from x = 2 through x = 0, past the
      // lamp itself at x = 1.
      const double expected = 0.8 * SeenIn(vertex.position, a, b);
      error += std::abs(vertex.irradiance[0] - expected);
      total += expected;
    }
  }
  EXPECT_GT(total, 0);
  EXPECT_LT(error / total, 0.02);
}

// Points, spots and the sun in a mirror: at every vertex what they bring themselves, and, where
// their images show in the mirror, what these bring.
TEST(Mirrors, ShowLights) {
  Scene scene;
  scene.materials = {{"black", Rgb(0.0), Rgb(0.0)}, {"mirror", Rgb(0.0), Rgb(0.0)}};
  scene.materials[1].specular = 0.8;
  scene.vertices = {{0, -2, 0}, {4, -2, 0}, {4, 2, 0}, {0, 2, 0},
                    {0, -1, 0}, {0, 1, 0},  {0, 1, 1}, {0, -1, 1}};
  scene.polygons = {{.vertices = {0, 1, 2, 3}, .sides = kFrontTakesPart},
                    {.vertices = {4, 5, 6, 7}, .material = 1, .sides = kFrontTakesPart}};
  scene.file_polygon_count = 2;
  Light point, spot, sun;
  point.position_m = {1, 0.5, 1.5};
  point.intensity = Rgb(3);
  spot.kind = LightKind::kSpot;
  spot.position_m = {2, -0.5, 0.5};
  spot.direction = {-1, 0, 0};
  spot.cosine_full = 0.99;
  spot.cosine_none = 0.9;
  spot.intensity = Rgb(10);
  sun.kind = LightKind::kDirectional;
  sun.direction = glm::normalize(Vec3(-1, 0.2, -0.5));
  sun.intensity = Rgb(1);
  scene.lights = {point, spot, sun};
  const SolveResult result = Solve(scene, 0.02);
  // Where the line from x to an image passes x = 0.
  const auto shows = [](const Vec3& at) { return std::abs(at.y) < 1 && at.z > 0 && at.z < 1; };
  const auto edge = [](const Vec3& at) {
    return std::min(std::abs(std::abs(at.y) - 1), std::abs(at.z - 1)) < 0.02;
  };
  double error = 0, total = 0, mirrored = 0;
  for (const PatchVertex& vertex : result.patch.vertices) {
    const Vec3& x = vertex.position;
    if (x.z > 1e-9 || x.x < 0.05) continue;
    double expected = 0;
    bool near_edge = false;
    const auto add = [&](const Vec3& towards, double irradiance, bool image) {
      const Vec3 at = x - x.x / towards.x * towards;
      near_edge = near_edge || (image && edge(at));
      if (image && !shows(at)) return;
      expected += (image ? 0.8 : 1) * irradiance;
      if (image) mirrored += 0.8 * irradiance;
    };
    for (const bool image : {false, true}) {
      const Vec3 flip(image ? -1 : 1, 1, 1);
      for (const Light& light : {point, spot}) {
        const Vec3 d = flip * light.position_m - x;
        const double distance = glm::length(d);
        const Vec3 from = flip * (-d / distance);  // as it leaves the light itself
        const double intensity = IntensityTowards(light, {}, from).x;
        add(d, intensity * d.z / std::pow(distance, 3), image);
      }
      add(-flip * sun.direction, -sun.direction.z, image);
    }
    if (near_edge) continue;
    error += std::abs(vertex.irradiance[0] - expected);
    total += expected;
  }
  EXPECT_GT(mirrored / total, 0.05);
  EXPECT_LT(error / total, 1e-3);
}

// A wall of mirror on the ground under an even sky: before it the mirror takes no more of the sky
// than it absorbs, behind it all that it hides.
TEST(Mirrors, ShowTheSky) {
  Scene scene;
  scene.materials = {{"black", Rgb(0.0), Rgb(0.0)}, {"mirror", Rgb(0.0), Rgb(0.0)}};
  scene.materials[1].specular = 0.75;
  scene.vertices = {{-2, -1, 0}, {2, -1, 0}, {2, 1, 0}, {-2, 1, 0},
                    {0, -1, 0},  {0, 1, 0},  {0, 1, 1}, {0, -1, 1}};
  scene.polygons = {{.vertices = {0, 1, 2, 3}, .sides = kFrontTakesPart},
                    {.vertices = {4, 5, 6, 7}, .material = 1, .sides = kFrontTakesPart}};
  scene.file_polygon_count = 2;
  scene.sky.columns = scene.sky.rows = 1;
  scene.sky.texels = {1, 1, 1};
  const SolveResult result = Solve(scene, 0.05);
  double error = 0, total = 0;
  for (const PatchVertex& vertex : result.patch.vertices) {
    const Vec3& x = vertex.position;
    if (x.z > 1e-9 || std::abs(x.x) < 0.05) continue;
    std::array<Vec3, 4> wall = {Vec3(0, -1, 0), Vec3(0, 1, 0), Vec3(0, 1, 1), Vec3(0, -1, 1)};
    if (x.x < 0) std::ranges::reverse(wall);
    const double hidden = FactorAt(x, {0, 0, 1}, wall);
    const double expected = std::numbers::pi * (1 - (x.x > 0 ? 0.25 : 1) * hidden);
    error += std::abs(vertex.irradiance[0] - expected);
    total += expected;
  }
  EXPECT_GT(total, 0);
  EXPECT_LT(error / total, 0.005);
}

// With lights and half-blind mirrors all that arrives is absorbed once.
TEST(Mirrors, EnergyOfLightsBalances) {
  Scene scene = Room(1, {});
  for (const uint32_t p : {0U, 3U}) MakeMirror(scene, p, 0.6);
  Light light;
  light.position_m = {.4, .3, 1};
  light.intensity = Rgb(1);
  scene.lights = {light};
  const SolveResult result = Solve(scene, 0.02);
  EXPECT_LT(Imbalance(result), 5e-3);
  EXPECT_NEAR(result.summary.rounds.back().emitted_w[0] / (4 * std::numbers::pi), 1, 0.01);
}

// Everything a lamp sends into a room of half-blind mirrors and grey walls is absorbed.
TEST(Mirrors, EnergyBalances) {
  Scene scene = RandomRoom(3, 3);
  for (const uint32_t p : {0U, 2U, 7U}) MakeMirror(scene, p, 0.5);
  const SolveResult result = Solve(scene, 0.1);
  EXPECT_LT(Imbalance(result), 0.01);
  // Mirrors bring light to others, so more arrives than without.
  EXPECT_GT(result.summary.rounds.back().absorbed_w[0], 0);
}

// Against paths followed ray by ray.
TEST(Mirrors, AgreeWithPathTracing) {
  Scene scene = RandomRoom(7, 3);
  for (const uint32_t p : {0U, 1U, 2U, 9U}) MakeMirror(scene, p, 0.8);
  // A ceiling that shines in place of the lamps: few paths find small ones by way of mirrors.
  for (Material& material : scene.materials) material.exitance = Rgb(0.0);
  scene.materials.push_back(scene.materials[scene.polygons[5].material]);
  scene.materials.back().exitance = Rgb(5);
  scene.polygons[5].material = static_cast<uint32_t>(scene.materials.size()) - 1;
  scene.polygons[5].sides |= kFrontEmits;
  const SolveResult result = Solve(scene, 0.02);
  ThreadPool pool(2);
  const std::vector<ReferencePoint> points =
      TracePaths(scene, {.points = 48, .error = 0.2, .seconds = 30}, pool);
  const Comparison off = Compare(result.patch, points).value();
  EXPECT_LT(off.l1_relative, 0.02 + NoiseOf(points));
  EXPECT_EQ(off.unmatched, 0U);
  // Paths that met a mirror bring all that paths without mirrors lack.
  const auto sum_of = [](const std::vector<ReferencePoint>& at) {
    double sum = 0;
    for (const ReferencePoint& point : at) sum += Sum(point.irradiance);
    return sum;
  };
  Scene without = scene;
  for (Material& material : without.materials) material.specular = 0;
  const PathTracing paths{.points = 48, .error = 0.2},
      by_mirrors{.points = 48, .error = 0.2, .by_mirrors_alone = true};
  const double lacking = sum_of(points) - sum_of(TracePaths(without, paths, pool));
  EXPECT_NEAR(sum_of(TracePaths(scene, by_mirrors, pool)) / lacking, 1, 0.02);
  // Without mirrors it would be far off.
  EXPECT_GT(Compare(Solve(scene, 0.2, "-mirrors").patch, points).value().l1_relative, 0.2);
}

// A strip of facets bent to a third of a cylinder, which gathers light: its images meet along the
// edges of the facets, and light goes from facet to facet.
TEST(Mirrors, ABentStripAgreesWithPathTracing) {
  constexpr int kFacets = 8;
  Scene scene = Room(1.5, {5});
  scene.materials.push_back({"bent", Rgb(0.05), Rgb(0.0)});
  scene.materials.back().specular = 0.9;
  const auto at = [](int i, double z) {
    const double angle = std::numbers::pi / 3 * (2.0 * i / kFacets - 1), radius = 0.5;
    return Vec3(0.8 + radius * std::cos(angle), 0.5 + radius * std::sin(angle), z);
  };
  for (int i = 0; i < kFacets; ++i) {
    Polygon facet;
    const Vec3 corners[] = {at(i, 0.1), at(i, 1.3), at(i + 1, 1.3), at(i + 1, 0.1)};
    for (size_t k = 0; k < 4; ++k) {
      facet.vertices[k] = static_cast<uint32_t>(scene.vertices.size());
      scene.vertices.push_back(corners[k]);
    }
    facet.material = static_cast<uint32_t>(scene.materials.size()) - 1;
    facet.file_polygon = scene.file_polygon_count++;
    scene.polygons.push_back(facet);
  }
  EXPECT_EQ(Mirrors(Hierarchy(scene), 0.05).planes().size(), 2U * kFacets);  // both sides
  const SolveResult result = Solve(scene, 0.1);
  EXPECT_LT(Imbalance(result), 0.01);
  ThreadPool pool(2);
  const std::vector<ReferencePoint> points =
      TracePaths(scene, {.points = 48, .error = 0.04, .seconds = 30}, pool);
  const Comparison off = Compare(result.patch, points).value();
  EXPECT_LT(off.l1_relative, 0.1);
  EXPECT_EQ(off.unmatched, 0U);
  EXPECT_GT(Compare(Solve(scene, 0.2, "-mirrors").patch, points).value().l1_relative, 0.2);
}

TEST(Mirrors, TheSameOnOneAndThreeWorkers) {
  Scene scene = RandomRoom(5, 1);
  for (const uint32_t p : {0U, 3U, 8U}) MakeMirror(scene, p, 0.6);
  SolveOptions options;
  options.accuracy = 0.1;
  options.epsilons = {1, 0.3};
  SolveToSameBits(scene, options);
}

TEST(Mirrors, NoMirrorsNoTrace) {
  const Scene scene = RandomRoom(2, 1);
  const SolveResult on = Solve(scene, 0.1, "+mirrors"), off = Solve(scene, 0.1, "-mirrors");
  EXPECT_EQ(BytesWithoutComments(on.patch), BytesWithoutComments(off.patch));
  EXPECT_EQ(on.summary.rays, off.summary.rays);
}

// Switched off, a mirror is what its material says without the specular share.
TEST(Mirrors, SwitchedOffTheyAreDiffuse) {
  Scene scene = Room(1, {4});
  MakeMirror(scene, 0, 0.5);
  Scene diffuse = scene;
  for (Material& material : diffuse.materials) material.specular = 0;
  EXPECT_EQ(BytesWithoutComments(Solve(scene, 0.1, "-mirrors").patch),
            BytesWithoutComments(Solve(diffuse, 0.1).patch));
}

TEST(Mirrors, NeglectCostsNoMoreThanItsBound) {
  for (const double share : {0.02, 0.3, 0.9}) {
    Scene scene = Room(1, {4});
    MakeMirror(scene, 0, share);
    const EffectsTable table = PlanEffects(Hierarchy(scene), 0.02, {});
    const auto row = std::ranges::find(table.effects, "mirrors", &Effect::name);
    ASSERT_TRUE(row->present && row->bound.has_value());
    EXPECT_TRUE(row->on);
    const SolveResult with = Solve(scene, 0.02, "+mirrors"),
                      without = Solve(scene, 0.02, "-mirrors");
    double all = 0, missing = 0;
    for (uint32_t p = 0; p < 6; ++p) {
      all += PowerOn(with, p);
      missing += std::abs(PowerOn(with, p) - PowerOn(without, p));
    }
    EXPECT_GT(missing / all, 0.05 * share);
    EXPECT_LT(missing / all, *row->bound);
  }
  // A mirror far smaller than the lamp is left out.
  Scene scene = Room(1, {4});
  const auto first = static_cast<uint32_t>(scene.vertices.size());
  scene.vertices.insert(scene.vertices.end(), {{.5, .5, 1}, {.505, .5, 1}, {.5, .505, 1}});
  scene.materials.push_back({"mirror", Rgb(0.0), Rgb(0.0)});
  scene.materials.back().specular = 1;
  Polygon tiny;
  tiny.vertices = {first, first + 1, first + 2, kNoVertex};
  tiny.material = static_cast<uint32_t>(scene.materials.size()) - 1;
  tiny.file_polygon = scene.file_polygon_count++;
  scene.polygons.push_back(tiny);
  EXPECT_FALSE(PlanEffects(Hierarchy(scene), 0.05, {}).plan.mirrors);
  EXPECT_TRUE(
      PlanEffects(Hierarchy(scene), 0.05, {EffectsChoice::Base::kAll, {}, {}}).plan.mirrors);
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.05, {});
  const double cost = CostOfNeglecting(scene, "mirrors", [](const SolveResult& result) {
    double sum = 0;
    for (uint32_t p = 0; p < 7; ++p) sum += PowerOn(result, p);
    return sum;
  });
  EXPECT_LT(std::abs(cost), *std::ranges::find(table.effects, "mirrors", &Effect::name)->bound);
}

// Between mirrors all round there are more images than are kept; the table says what is lost, and
// it is no less than what is found missing at the ceiling, which all light reaches in the end.
TEST(Mirrors, WhatImagesLeaveOutIsSaid) {
  BoxFaces faces;
  faces.exitance[4] = Rgb(1);
  Scene scene = BoxRoom({1, 1, 1}, faces);
  for (uint32_t p = 0; p < 4; ++p) MakeMirror(scene, p, 1);
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.02, {});
  const auto row = std::ranges::find(table.effects, "mirrors", &Effect::name);
  const auto at = row->evidence.find("are left out: ");
  ASSERT_NE(at, std::string::npos) << row->evidence;
  const double lost = std::stod(row->evidence.substr(at + 14));
  const double found = 1 - PowerOn(Solve(scene, 0.02), 5);
  EXPECT_GT(found, 0.005);
  EXPECT_GT(lost, found);
  EXPECT_LT(lost, found + 0.05);
}

// Images of a box of mirrors: every one has its reverse, paths fold back to where they came from.
TEST(Mirrors, ImagesAreWhole) {
  Scene scene = Room(1, {4});
  for (const uint32_t p : {0U, 1U, 2U, 5U}) MakeMirror(scene, p, 0.6);
  const Hierarchy hierarchy(scene);
  const Mirrors mirrors(hierarchy, 0.1);
  ASSERT_EQ(mirrors.planes().size(), 4U);
  EXPECT_GT(mirrors.images().size(), 20U);
  EXPECT_LT(mirrors.images().size(), Mirrors::kMostImages);
  EXPECT_EQ(mirrors.missing(), 0);
  for (size_t i = 0; i < mirrors.images().size(); ++i) {
    const MirrorImage& image = mirrors.images()[i];
    const MirrorImage& reverse = mirrors.images()[image.reverse];
    EXPECT_EQ(reverse.reverse, i);
    const Vec3 x(.3, .2, .9);
    EXPECT_NEAR(glm::length(reverse.image.Point(image.image.Point(x)) - x), 0, 1e-12);
    EXPECT_NEAR(image.share, std::pow(0.6, static_cast<double>(image.openings.size())), 1e-12);
  }
}

}  // namespace
}  // namespace isolux::testing
