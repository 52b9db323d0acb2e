// Translucent sheets through whole solves: against rooms without any that are their symmetric and
// antisymmetric parts, furnaces, a skylight, path tracing; energy, the bound, and the same bits on
// any number of workers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/output/comparison.h"
#include "common/hierarchy/effects/plan.h"
#include "common/hierarchy/element.h"
#include "common/hierarchy/translucent_sheets.h"
#include "common/scene/translucency.h"
#include "common/util/random.h"
#include "tests/support/local_cluster.h"
#include "tests/support/path_tracer.h"
#include "tests/support/same_bits.h"
#include "tests/support/scenes.h"
#include "tests/support/sheet.h"
#include "tests/support/solve_scene.h"

namespace isolux::testing {
namespace {

SolveResult Solve(const Scene& scene, double accuracy, const std::string& effects = "",
                  int workers = 1) {
  return SolveScene(scene, accuracy, effects, workers);
}

const RoundSummary& LastRound(const SolveResult& result) { return result.summary.rounds.back(); }

constexpr double kWall = 0.4;
const Vec3 kRoom(2, 1, 1.5);

// A room that a sheet divides at x = 1, with a lamp for the wall at x = 0: its two halves.
Scene Divided(const Rgb& reflectance, const Rgb& transmittance) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(kWall));
  faces.exitance[0] = Rgb(1);
  Scene scene = BoxRoom({1, 1, 1.5}, faces);
  faces.exitance[0] = Rgb(0.0);
  const Scene second = BoxRoom({1, 1, 1.5}, faces);
  // The halves meet in the sheet: neither has a wall of its own there.
  scene.polygons.erase(scene.polygons.begin() + 1);
  for (uint32_t p = 1; p < 6; ++p) {
    Polygon polygon = second.polygons[p];
    for (uint32_t& v : polygon.vertices) v += static_cast<uint32_t>(scene.vertices.size());
    polygon.material += static_cast<uint32_t>(scene.materials.size());
    polygon.file_polygon += 6;
    scene.polygons.push_back(polygon);
  }
  for (Vec3 v : second.vertices) scene.vertices.push_back(v + Vec3(1, 0, 0));
  scene.materials.insert(scene.materials.end(), second.materials.begin(), second.materials.end());
  scene.file_polygon_count = 12;
  AddSheet(scene, {{1, 0, 0}, {1, 1, 0}, {1, 1, 1.5}, {1, 0, 1.5}}, reflectance, transmittance);
  return scene;
}

// Half of it with such a wall in the place of the sheet, and the lamp.
Scene Half(double reflectance) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(kWall));
  faces.reflectance[1] = Rgb(reflectance);
  faces.exitance[0] = Rgb(1);
  return BoxRoom({1, 1, 1.5}, faces);
}

struct Means {
  double irradiance = 0, radiosity = 0;
};

// Of one side of a polygon of the file, in a channel; 0 where it is left out as dark.
Means MeansOn(const SolveResult& result, uint32_t polygon, int side = 0, int channel = 0) {
  Means sum;
  double area = 0;
  for (const PatchFace& face : result.patch.faces) {
    if (face.polygon != polygon || face.side != side) continue;
    Vec3 twice(0.0);
    const Vec3& first = result.patch.vertices[face.vertices[0]].position;
    for (size_t i = 1; i + 1 < face.vertices.size(); ++i) {
      twice += glm::cross(result.patch.vertices[face.vertices[i]].position - first,
                          result.patch.vertices[face.vertices[i + 1]].position - first);
    }
    const double part = 0.5 * glm::length(twice);
    area += part;
    sum.irradiance += part * face.irradiance[channel];
    sum.radiosity += part * face.radiosity[channel];
  }
  return area > 0 ? Means{sum.irradiance / area, sum.radiosity / area} : Means{};
}

// Both sides of an element are the same piece, whatever sides are equally long.
TEST(Sheets, BothSidesAreDividedAlike) {
  std::vector<ConvexPolygon> shapes = {
      {4, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)}},
      {4, {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(2, 1, 0), Vec3(0, 1, 0)}},
      {3, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}},
      {3, {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}}};
  Random random(3);
  for (int k = 0; k < 20; ++k) {
    shapes.push_back({3, {}});
    for (int i = 0; i < 3; ++i) shapes.back().v[i] = {random.Unit(), random.Unit(), random.Unit()};
  }
  for (const ConvexPolygon& front : shapes) {
    const ConvexPolygon back = FromBehind(front);
    EXPECT_LT(glm::dot(front.AreaVector(), back.AreaVector()), 0);
    for (uint64_t path = 1; path < 64; ++path) {
      const ConvexPolygon a = ElementGeometry(front, path), b = ElementGeometry(back, path);
      for (int k = 0; k < front.count; ++k) EXPECT_EQ(a.v[k], b.v[CornerBehind(front.count, k)]);
      // The cut of a first part lies between its second and third corner.
      const ConvexPolygon first = ElementGeometry(back, 2 * path);
      const Vec3 across = glm::cross(back.AreaVector(), first.v[2] - first.v[1]);
      for (const int child : {0, 1}) {
        const Vec3 centre = ElementGeometry(back, 2 * path + child).Centroid();
        EXPECT_EQ(glm::dot(across, centre - first.v[1]) > 0, child == 0);
      }
    }
  }
}

// Lit alike from both halves a sheet reflects ρ + τ, lit in opposition ρ − τ: half the sum and half
// the difference of two rooms without any sheet are the two halves.
TEST(Sheets, AreTheSumOfTwoRoomsWithout) {
  constexpr double kReflects = 0.45, kPasses = 0.35;
  const SolveResult result = Solve(Divided(Rgb(kReflects), Rgb(kPasses)), 0.012);
  const SolveResult even = Solve(Half(kReflects + kPasses), 0.012),
                    odd = Solve(Half(kReflects - kPasses), 0.012);
  EXPECT_LT(LastRound(result).energy_imbalance, 2e-3);
  // The wall beyond the sheet that mirrors a wall of the first half: fronts face inwards.
  const std::array<uint32_t, 6> beyond = {7, 12, 8, 9, 10, 11};
  for (uint32_t p = 0; p < 6; ++p) {
    const double s = MeansOn(even, p).irradiance, d = MeansOn(odd, p).irradiance;
    if (p == 1) {
      // The front of the sheet looks to x = 2.
      const Means front = MeansOn(result, 12, 0), back = MeansOn(result, 12, 1);
      EXPECT_NEAR(back.irradiance, 0.5 * (s + d), 0.01 * s);
      EXPECT_NEAR(front.irradiance, 0.5 * (s - d), 0.01 * s);
      EXPECT_NEAR(front.radiosity, kReflects * front.irradiance + kPasses * back.irradiance, 1e-6);
      EXPECT_NEAR(back.radiosity, kReflects * back.irradiance + kPasses * front.irradiance, 1e-6);
      continue;
    }
    EXPECT_NEAR(MeansOn(result, p).irradiance, 0.5 * (s + d), 0.01 * s) << p;
    EXPECT_NEAR(MeansOn(result, beyond[p]).irradiance, 0.5 * (s - d), 0.01 * s) << p;
  }
}

// Plates without end, a lamp below and a reflector above, with a sheet halfway between: with b and
// c what its lower and upper side radiate, b = ρ(E + ρ1 b) + τ ρ2 c and c = ρ ρ2 c + τ(E + ρ1 b).
// Squares four thousand times as wide as they are apart lose a thousandth by their edges.
TEST(Sheets, BetweenTwoPlatesWithoutEnd) {
  const double exitance = 2, rho_1 = 0.5, rho_2 = 0.8, rho = 0.3, tau = 0.45, side = 4000;
  Scene scene;
  scene.materials = {{"lamp", Rgb(rho_1), Rgb(exitance)}, {"plate", Rgb(rho_2), Rgb(0.0)}};
  scene.vertices = {{0, 0, 0}, {side, 0, 0}, {side, side, 0}, {0, side, 0},
                    {0, 0, 2}, {0, side, 2}, {side, side, 2}, {side, 0, 2}};
  scene.polygons = {
      {.vertices = {0, 1, 2, 3}, .sides = kFrontTakesPart | kFrontEmits},
      {.vertices = {4, 5, 6, 7}, .material = 1, .file_polygon = 1, .sides = kFrontTakesPart}};
  scene.file_polygon_count = 2;
  AddSheet(scene, {{0, 0, 1}, {side, 0, 1}, {side, side, 1}, {0, side, 1}}, Rgb(rho), Rgb(tau));
  const double determinant = (1 - rho * rho_1) * (1 - rho * rho_2) - tau * tau * rho_1 * rho_2;
  const double lower = exitance * (rho * (1 - rho * rho_2) + tau * tau * rho_2) / determinant;
  const double upper = exitance * tau / determinant;
  const SolveResult result = Solve(scene, 0.2);
  EXPECT_NEAR(MeansOn(result, 0).radiosity / (exitance + rho_1 * lower), 1, 0.005);
  EXPECT_NEAR(MeansOn(result, 1).radiosity / (rho_2 * upper), 1, 0.005);
  EXPECT_NEAR(MeansOn(result, 2, 0).radiosity / upper, 1, 0.005);
  EXPECT_NEAR(MeansOn(result, 2, 1).radiosity / lower, 1, 0.005);
}

// What corners of the output radiate, on both sides of the sheet, where the light bends.
TEST(Sheets, CornersRadiateWhatBothSidesReceive) {
  constexpr double kReflects = 0.1, kPasses = 0.8;
  const PatchFile patch = Solve(Divided(Rgb(kReflects), Rgb(kPasses)), 0.05).patch;
  std::vector<const PatchVertex*> front, back;
  for (const PatchFace& face : patch.faces) {
    if (face.polygon != 12) continue;
    for (const uint32_t v : face.vertices) {
      (face.side == 0 ? front : back).push_back(&patch.vertices[v]);
    }
  }
  ASSERT_EQ(front.size(), back.size());  // divided alike
  int compared = 0;
  for (const PatchVertex* a : front) {
    for (const PatchVertex* b : back) {
      if (a->position != b->position) continue;
      EXPECT_NEAR(a->radiosity[0], kReflects * a->irradiance[0] + kPasses * b->irradiance[0], 1e-5);
      EXPECT_NEAR(b->radiosity[0], kReflects * b->irradiance[0] + kPasses * a->irradiance[0], 1e-5);
      ++compared;
      break;
    }
  }
  EXPECT_GE(compared, static_cast<int>(front.size()));
}

// Where all radiate alike all receive that: with next to nothing absorbed in the sheet, or all.
TEST(Sheets, FurnacesStayEven) {
  for (const auto& [reflects, passes] : {std::pair(0.05, 0.93), {0.6, 0.38}, {0.0, 0.3}}) {
    Scene scene = Divided(Rgb(reflects), Rgb(passes));
    for (Material& material : scene.materials) {
      material.exitance = Rgb(1.0) - material.reflectance - material.transmittance;
    }
    for (Polygon& polygon : scene.polygons) polygon.sides |= kFrontEmits;
    scene.polygons.back().sides |= kBackEmits;
    const SolveResult result = Solve(scene, 0.02);
    const RoundSummary& last = LastRound(result);
    EXPECT_LT(last.energy_imbalance, 3e-3) << passes;
    EXPECT_NEAR(last.absorbed_w[0] / last.emitted_w[0], 1, 3e-3);
    for (const PatchFace& face : result.patch.faces) {
      EXPECT_NEAR(face.irradiance[0], 1, 0.004) << face.polygon;
      EXPECT_NEAR(face.radiosity[0], 1, 0.004) << face.polygon;
    }
  }
}

// A room whose ceiling is a sheet under an even sky: the sheet is a lamp of exitance τ π L.
TEST(Sheets, ASkylightIsALamp) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(kWall));
  faces.reflectance[5] = Rgb(0.3);
  Scene lamp = BoxRoom(kRoom, faces), skylight = lamp;
  lamp.materials[lamp.polygons[5].material].exitance = Rgb(0.6 * std::numbers::pi);
  lamp.polygons[5].sides |= kFrontEmits;
  skylight.materials[skylight.polygons[5].material].transmittance = Rgb(0.6);
  skylight.polygons[5].sides |= kBackTakesPart;
  skylight.sky.columns = skylight.sky.rows = 1;
  skylight.sky.texels = {1, 1, 1};
  const SolveResult under_sky = Solve(skylight, 0.02), under_lamp = Solve(lamp, 0.02);
  for (uint32_t p = 0; p < 6; ++p) {
    EXPECT_NEAR(MeansOn(under_sky, p).irradiance / MeansOn(under_lamp, p).irradiance, 1, 0.01) << p;
  }
  EXPECT_NEAR(MeansOn(under_sky, 5, 1).irradiance, std::numbers::pi, 1e-3);
  const RoundSummary& last = LastRound(under_sky);
  EXPECT_LT(last.energy_imbalance, 5e-3);
  EXPECT_GT(last.escaped_w[0], 0.3 * 2 * std::numbers::pi);  // what the sheet reflects to the sky
}

// A screen between lamp and floor in a room, coloured, that passes on more than it reflects; and
// one of a triangle. Against paths that go through by chance.
Scene Screened() {
  BoxFaces faces;
  faces.reflectance = {Rgb(.6, .5, .4), Rgb(.3), Rgb(.5), Rgb(.2, .4, .6), Rgb(.6), Rgb(.4)};
  Scene scene = BoxRoom(kRoom, faces);
  const auto lamp = static_cast<uint32_t>(scene.materials.size());
  scene.materials.push_back({"lamp", Rgb(0.0), Rgb(10, 9, 8)});
  AddSheet(scene, {{.3, .2, 1.3}, {.3, .6, 1.3}, {.7, .6, 1.3}, {.7, .2, 1.3}}, Rgb(0.0), Rgb(0.0));
  scene.polygons.back().material = lamp;
  scene.polygons.back().sides = kFrontTakesPart | kFrontEmits | kBackTakesPart;
  AddSheet(scene, {{.2, .1, .9}, {1.4, .1, .8}, {1.4, .9, .8}, {.2, .9, .9}}, Rgb(.2, .2, .3),
           Rgb(.7, .6, .4));
  AddSheet(scene, {{1.5, .1, .1}, {1.6, .9, .2}, {1.7, .4, 1.2}}, Rgb(.5), Rgb(.3, .3, .4));
  return scene;
}

TEST(Sheets, PathsThatGoThroughAgree) {
  const Scene scene = Screened();
  const SolveResult result = Solve(scene, 0.03);
  EXPECT_LT(LastRound(result).energy_imbalance, 5e-3);
  ThreadPool pool(2);
  const std::vector<ReferencePoint> points =
      TracePaths(scene, {.points = 32, .error = 0.08, .seconds = 30}, pool);
  const Comparison off = Compare(result.patch, points).value();
  EXPECT_LT(off.l1_relative, 0.03 + NoiseOf(points));
  EXPECT_EQ(off.unmatched, 0U);
  EXPECT_GT(Compare(Solve(scene, 0.2, "-sheets").patch, points).value().l1_relative, 0.2);
}

// A mirror for a wall shows the other half of a room twice as long, sheet and all; through a
// medium.
TEST(Sheets, MirrorsShowThem) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(kWall));
  faces.exitance[0] = Rgb(1);
  Scene half = BoxRoom({1, 1, 1.5}, faces);
  faces.exitance[1] = Rgb(1);
  Scene whole = BoxRoom({2, 1, 1.5}, faces);
  Material mirror;
  mirror.specular = 1;
  half.polygons[1].material = static_cast<uint32_t>(half.materials.size());
  half.materials.push_back(mirror);
  AddSheet(half, {{.6, .1, .2}, {.6, .9, .2}, {.6, .9, 1.4}, {.6, .1, 1.4}}, Rgb(.2), Rgb(.6));
  AddSheet(whole, {{.6, .1, .2}, {.6, .9, .2}, {.6, .9, 1.4}, {.6, .1, 1.4}}, Rgb(.2), Rgb(.6));
  AddSheet(whole, {{1.4, .1, .2}, {1.4, .9, .2}, {1.4, .9, 1.4}, {1.4, .1, 1.4}}, Rgb(.2), Rgb(.6));
  half.medium = whole.medium = {Rgb(0.2)};
  const SolveResult mirrored = Solve(half, 0.2), unfolded = Solve(whole, 0.2);
  for (const int side : {0, 1}) {
    EXPECT_NEAR(MeansOn(mirrored, 6, side).irradiance / MeansOn(unfolded, 6, side).irradiance, 1,
                0.02);
    EXPECT_NEAR(MeansOn(mirrored, 6, side).radiosity / MeansOn(unfolded, 6, side).radiosity, 1,
                0.02);
  }
  EXPECT_LT(LastRound(mirrored).energy_imbalance, 0.01);
  EXPECT_LT(LastRound(unfolded).energy_imbalance, 0.01);
}

TEST(Sheets, TheSameOnOneAndThreeWorkers) {
  for (const Scene& scene : {Screened(), Divided(Rgb(0.2), Rgb(0.7))}) {
    SolveToSameBits(scene, Rotating(0.1, {0.3, 0.08, 0.03}));
  }
}

TEST(Sheets, NoSheetsNoTrace) {
  const Scene scene = RandomRoom(2, 1);
  const SolveResult on = Solve(scene, 0.1, "+sheets"), off = Solve(scene, 0.1, "-sheets");
  EXPECT_EQ(BytesWithoutComments(on.patch), BytesWithoutComments(off.patch));
  EXPECT_EQ(on.summary.rays, off.summary.rays);
}

TEST(Sheets, NeglectCostsNoMoreThanItsBound) {
  for (const double passes : {0.02, 0.3, 0.55}) {
    const Scene scene = Divided(Rgb(0.4), Rgb(passes));
    const EffectsTable table = PlanEffects(Hierarchy(scene), 0.02, {});
    const auto row = std::ranges::find(table.effects, "sheets", &Effect::name);
    ASSERT_TRUE(row->present && row->bound.has_value());
    EXPECT_TRUE(row->on);
    // 1 − ρ − τ is absorbed, by all sides alike but for the sheet's.
    const auto arriving = [&](const std::string& effects) {
      const SolveResult result = Solve(scene, 0.05, effects);
      const double sum =
          MeansOn(result, 12, 0).irradiance * 1.5 + MeansOn(result, 12, 1).irradiance * 1.5;
      const double absorbed = LastRound(result).absorbed_w[0];
      const double through = effects.empty() ? passes : 0.0;
      return sum + (absorbed - (0.6 - through) * sum) / (1 - kWall);
    };
    const double all = arriving(""), cost = (all - arriving("-sheets")) / all;
    EXPECT_GT(cost, 0.02 * passes);
    EXPECT_LT(cost, *row->bound);
  }
  // A scrap far smaller than the lamp is left out.
  Scene scene = Half(0.4);
  AddSheet(scene, {{.5, .5, 1}, {.503, .5, 1}, {.5, .503, 1}}, Rgb(0.2), Rgb(0.5));
  EXPECT_FALSE(PlanEffects(Hierarchy(scene), 0.05, {}).plan.sheets);
  EXPECT_TRUE(PlanEffects(Hierarchy(scene), 0.05, {EffectsChoice::Base::kAll, {}, {}}).plan.sheets);
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.05, {});
  const double cost = CostOfNeglecting(scene, "sheets", [](const SolveResult& result) {
    double sum = 0;
    for (uint32_t p = 0; p < 6; ++p) sum += (p < 4 ? 1.5 : 1.0) * MeansOn(result, p).irradiance;
    return sum;
  });
  EXPECT_LT(std::abs(cost), *std::ranges::find(table.effects, "sheets", &Effect::name)->bound);
}

// All solvers, also those that go leaf by leaf.
TEST(Sheets, EverySolverPassesOn) {
  const Scene scene = Divided(Rgb(0.1), Rgb(0.6));
  SolveOptions options;
  options.accuracy = 0.02;
  options.epsilons = {0.2, 0.05};
  const double expected = MeansOn(SolveScene(scene, options), 12, 0).irradiance;
  for (const SolverMethod method : {SolverMethod::kJacobi, SolverMethod::kGaussSeidel,
                                    SolverMethod::kChebyshev, SolverMethod::kSouthwell}) {
    options.solver = method;
    const double found = MeansOn(SolveScene(scene, options, 2), 12, 0).irradiance;
    EXPECT_NEAR(found / expected, 1, 3e-3) << static_cast<int>(method);
  }
}

// Rows of walls that are black, or nearly, are of links that carry no light and stay coarse. They
// are not made to add up, and links that do carry light do not pay for it.
TEST(Sheets, InBlackRoomsLightGoesOnlyWhereItIsSent) {
  for (const double wall : {0.0, 0.002, 0.004}) {
    Scene black = Divided(Rgb(0.1), Rgb(0.6));
    for (Material& material : black.materials) material.reflectance = Rgb(wall);
    const SolveResult result = Solve(black, 0.02);
    EXPECT_LT(LastRound(result).error_estimate, 0.02) << wall;
    EXPECT_LT(LastRound(result).links, 1200U) << wall;
    EXPECT_LT(LastRound(result).energy_imbalance, 1e-3) << wall;
    // Form factor F of a wall to the one opposite (Howell, C-11), and from the sheet on 0.6 times
    // the mean of F² over its points: 1.02054 times the square of the mean.
    const double share = MeansOn(result, 12, 1).irradiance;
    EXPECT_NEAR(share, 0.252259, 0.0015 + wall) << wall;
    EXPECT_NEAR(MeansOn(result, 7).irradiance / (0.6 * share * share), 1.02054, 0.015 + 2 * wall);
  }
}

TEST(Sheets, FollowTheSceneAsBytes) {
  Scene scene = Screened();
  scene.medium.extinction_per_m = Rgb(0.1);
  const std::string bytes = Encode(scene);
  const auto back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(back->materials.back().transmittance, scene.materials.back().transmittance);
  Scene opaque = scene;
  for (Material& material : opaque.materials) material.transmittance = Rgb(0.0);
  const std::string without = Encode(opaque);
  EXPECT_EQ(without, bytes.substr(0, without.size()));
  for (size_t size = without.size() + 1; size < bytes.size(); ++size) {
    EXPECT_FALSE(Decode(bytes.substr(0, size)).has_value()) << size;
  }
  for (const double wrong : {-0.1, 0.5, 1.5, std::nan("")}) {
    scene.materials.back().transmittance.y = wrong;
    EXPECT_FALSE(Validate(scene).ok()) << wrong;
  }
}

}  // namespace
}  // namespace isolux::testing
