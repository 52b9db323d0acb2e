// Lights that are no polygons, through whole solves: exact irradiance at every vertex, shadows,
// energy, and that a scene without lights is solved as if there were no such thing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/hierarchy/effects/plan.h"
#include "common/util/random.h"
#include "tests/support/local_cluster.h"
#include "tests/support/same_bits.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"
#include "worker/coupling/point_factor.h"

namespace isolux::testing {
namespace {

using std::numbers::pi;

Light PointLight(const Vec3& position, const Rgb& intensity) {
  Light light;
  light.position_m = position;
  light.intensity = intensity;
  return light;
}

Light SpotLight(const Vec3& position, const Vec3& direction, const Rgb& intensity, double full,
                double none) {
  Light light = PointLight(position, intensity);
  light.kind = LightKind::kSpot;
  light.direction = glm::normalize(direction);
  light.cosine_full = std::cos(full);
  light.cosine_none = std::cos(none);
  return light;
}

Light DirectionalLight(const Vec3& direction, const Rgb& irradiance) {
  Light light;
  light.kind = LightKind::kDirectional;
  light.direction = glm::normalize(direction);
  light.intensity = irradiance;
  return light;
}

// A square of side 4 m about the origin at height 0, seen from above.
Scene Floor(double reflectance) {
  Scene scene;
  scene.materials = {{"floor", Rgb(reflectance), Rgb(0.0)}};
  scene.vertices = {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}};
  scene.polygons = {{.vertices = {0, 1, 2, 3}, .sides = kFrontTakesPart}};
  scene.file_polygon_count = 1;
  return scene;
}

SolveResult Solve(const Scene& scene, double accuracy = 0.05, const std::string& effects = "",
                  int workers = 1) {
  return SolveScene(scene, accuracy, effects, workers);
}

TEST(Lights, InverseSquareWithCosineAtEveryVertex) {
  const Vec3 at(0.3, -0.2, 0.9);
  Scene scene = Floor(0.5);
  scene.lights = {PointLight(at, {3, 2, 1})};
  const SolveResult result = Solve(scene);
  ASSERT_GT(result.patch.vertices.size(), 100U);
  for (const PatchVertex& vertex : result.patch.vertices) {
    const Vec3 d = at - vertex.position;
    const double expected = d.z / std::pow(glm::dot(d, d), 1.5);
    // Output points lie 1e-5 of their element inside of it.
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(vertex.irradiance[c], (3 - c) * expected, 2e-4 * expected);
      EXPECT_NEAR(vertex.radiosity[c], 0.5 * vertex.irradiance[c], 1e-6 * expected);
    }
  }
  // The flux is the intensity times the solid angle of the square: exact in the balance.
  const auto corner = [&](double x, double y) {  // of a rectangle from the foot to (x, y)
    return std::atan2(x * y, at.z * std::sqrt(x * x + y * y + at.z * at.z));
  };
  const double omega = corner(2 - at.x, 2 - at.y) + corner(2 + at.x, 2 - at.y) +
                       corner(2 - at.x, 2 + at.y) + corner(2 + at.x, 2 + at.y);
  EXPECT_NEAR(result.summary.rounds.back().emitted_w[0], 3 * omega, 1e-9);
  EXPECT_NEAR(result.summary.rounds.back().absorbed_w[2], 0.5 * omega, 1e-9);
}

TEST(Lights, ASpotEndsAtItsCone) {
  const Vec3 at(0.1, 0.2, 1);
  const double full = 0.3, none = 0.5;
  Scene scene = Floor(0.2);
  scene.lights = {SpotLight(at, {0.2, -0.1, -1}, Rgb(5.0), full, none)};
  const SolveResult result = Solve(scene, 0.02);
  int inside = 0, border = 0, outside = 0;
  for (const PatchVertex& vertex : result.patch.vertices) {
    const Vec3 d = at - vertex.position;
    const double angle = std::acos(glm::dot(-glm::normalize(d), scene.lights[0].direction));
    const double whole = 5 * d.z / std::pow(glm::dot(d, d), 1.5);
    if (angle < full - 1e-4) {
      EXPECT_NEAR(vertex.irradiance[0], whole, 1e-4 * whole);
      ++inside;
    } else if (angle > none + 1e-4) {
      EXPECT_EQ(vertex.irradiance[0], 0);
      ++outside;
    } else {
      const double share = (std::cos(angle) - std::cos(none)) / (std::cos(full) - std::cos(none));
      EXPECT_NEAR(vertex.irradiance[0], share * share * whole, 2e-3 * whole);
      ++border;
    }
  }
  EXPECT_GT(inside, 20);
  EXPECT_GT(border, 20);
  EXPECT_GT(outside, 20);
  // All of the cone lands on the square.
  const double power = PowerOf(scene.lights[0], {})[0];
  EXPECT_NEAR(result.summary.rounds.back().emitted_w[0], power, 0.02 * power);
}

// A square of 1 m a metre above the floor, in slanting light.
Scene ShadedFloor() {
  Scene scene = Floor(0.0);
  const auto first = static_cast<uint32_t>(scene.vertices.size());
  scene.vertices.insert(scene.vertices.end(),
                        {{-0.5, -0.5, 1}, {0.5, -0.5, 1}, {0.5, 0.5, 1}, {-0.5, 0.5, 1}});
  scene.polygons.push_back(
      {.vertices = {first, first + 1, first + 2, first + 3}, .sides = kFrontTakesPart});
  scene.lights = {DirectionalLight({0.43, 0.21, -1}, {800, 800, 800})};
  return scene;
}

// How far a point of the floor is inside the square's shadow.
double DepthInShadow(const Vec3& point) {
  return 0.5 - std::max(std::abs(point.x - 0.43), std::abs(point.y - 0.21));
}

TEST(Lights, ADirectionCastsParallelShadows) {
  const Scene scene = ShadedFloor();
  const SolveResult result = Solve(scene, 0.02);
  int dark = 0, bright = 0;
  for (const PatchVertex& vertex : result.patch.vertices) {
    const double depth = vertex.position.z > 0.5 ? -1 : DepthInShadow(vertex.position);
    if (std::abs(depth) < 1e-3) continue;
    const double expected = depth > 0 ? 0.0 : -800 * scene.lights[0].direction.z;
    EXPECT_NEAR(vertex.irradiance[0], expected, 1e-2);
    ++(depth > 0 ? dark : bright);
  }
  EXPECT_GT(dark, 20);
  EXPECT_GT(bright, 100);
}

// ∫|ΔH| dA / ∫H dA of a patch file against the sharp shadow.
double TrueError(const PatchFile& patch, const Scene& scene) {
  double off = 0, arriving = 0;
  Random random(1);
  for (const PatchFace& face : patch.faces) {
    for (size_t k = 1; k + 1 < face.vertices.size(); ++k) {
      const PatchVertex& a = patch.vertices[face.vertices[0]];
      const PatchVertex& b = patch.vertices[face.vertices[k]];
      const PatchVertex& c = patch.vertices[face.vertices[k + 1]];
      const double area =
          0.5 * glm::length(glm::cross(b.position - a.position, c.position - a.position));
      constexpr int kPoints = 64;
      for (int i = 0; i < kPoints; ++i) {
        const double root = std::sqrt(random.Unit()), v = random.Unit();
        const Vec3 w(1 - root, root * (1 - v), root * v);
        const Vec3 point = w.x * a.position + w.y * b.position + w.z * c.position;
        const double h = w.x * a.irradiance[0] + w.y * b.irradiance[0] + w.z * c.irradiance[0];
        const bool dark = point.z < 0.5 && DepthInShadow(point) > 0;
        const double expected = dark ? 0.0 : -800 * scene.lights[0].direction.z;
        off += area / kPoints * std::abs(h - expected);
        arriving += area / kPoints * expected;
      }
    }
  }
  return off / arriving;
}

TEST(Lights, BordersOfShadowsAreInTheEstimate) {
  for (const double accuracy : {0.01, 0.003, 0.001}) {
    const Scene scene = ShadedFloor();
    const SolveResult result = Solve(scene, accuracy);
    const double error = TrueError(result.patch, scene);
    const double estimate = result.summary.rounds.back().error_estimate;
    EXPECT_LT(error, accuracy);
    EXPECT_LT(error, 2 * estimate) << accuracy;
    EXPECT_GT(error, 0.1 * estimate) << accuracy;
  }
}

TEST(Lights, APointInAClosedBoxIsAFurnace) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.5));
  Scene scene = BoxRoom({1, 1, 1}, faces);
  scene.lights = {PointLight({0.5, 0.5, 0.5}, Rgb(1.0))};
  const SolveResult result = Solve(scene, 0.02);
  const RoundSummary& last = result.summary.rounds.back();
  EXPECT_NEAR(last.emitted_w[0], 4 * pi, 1e-9);
  EXPECT_NEAR(last.absorbed_w[0], 4 * pi, 0.002 * 4 * pi);
  EXPECT_LT(last.energy_imbalance, 0.002);
  EXPECT_EQ(result.summary.rays, 0U);  // one convex room with the light inside
}

// A luminaire that sends I0 cos of the angle from its axis below, tabled by degrees, and a quarter
// of that above, twice as much ahead and behind as to the sides: all of its light arrives in a box.
TEST(Lights, APhotometricLightBringsItsFlux) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.3));
  Scene scene = BoxRoom({2, 2, 2}, faces);
  Photometry table;
  table.around = {0, 90};
  for (int degrees = 0; degrees <= 180; degrees += 2) {
    table.from_axis.push_back(static_cast<float>(degrees));
  }
  for (const double side : {2.0, 1.0}) {
    for (const float degrees : table.from_axis) {
      const double cosine = std::cos(degrees * pi / 180);
      table.intensity.push_back(static_cast<float>(side * (cosine > 0 ? cosine : -0.25 * cosine)));
    }
  }
  EXPECT_NEAR(table.Power(), 1.5 * 1.25 * pi, 2e-3);
  EXPECT_NEAR(table.Towards({0.6, 0, -0.8}, {0, 0, -1}, {1, 0, 0}), 1.6, 1e-3);
  EXPECT_NEAR(table.Towards({-0.6, 0, -0.8}, {0, 0, -1}, {1, 0, 0}), 1.6, 1e-3);
  EXPECT_NEAR(table.Towards({0, 0.6, -0.8}, {0, 0, -1}, {1, 0, 0}), 0.8, 1e-3);
  EXPECT_NEAR(table.Towards({0, -0.6, 0.8}, {0, 0, -1}, {1, 0, 0}), 0.2, 1e-3);
  scene.photometries = {table};
  scene.lights = {PointLight({1, 1.2, 1.1}, {10, 5, 1})};
  scene.lights[0].kind = LightKind::kPhotometric;
  ASSERT_TRUE(Validate(scene).ok());
  const SolveResult result = Solve(scene, 0.02);
  for (int c = 0; c < 3; ++c) {
    const double power = table.Power() * scene.lights[0].intensity[c];
    EXPECT_NEAR(result.summary.rounds.back().emitted_w[c], power, 0.01 * power);
  }
  for (const PatchVertex& vertex : result.patch.vertices) {
    if (vertex.position.z > 0) continue;
    const Vec3 d = vertex.position - scene.lights[0].position_m;
    if (std::min({vertex.position.x, vertex.position.y, 2 - vertex.position.x,
                  2 - vertex.position.y}) < 1e-6) {
      continue;  // shared with no one, but the normal is the floor's alone inside
    }
    const double direct = 10 * table.Towards(glm::normalize(d), {0, 0, -1}, {1, 0, 0}) * -d.z /
                          std::pow(glm::dot(d, d), 1.5);
    EXPECT_GT(vertex.irradiance[0], 0.999 * direct);
  }
}

TEST(Lights, NoLightComesThroughWalls) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.5));
  faces.exitance[5] = Rgb(1.0);
  const Scene dark = BoxRoom({2, 1, 3}, faces);
  Scene scene = dark;
  scene.lights = {DirectionalLight({0.2, 0.3, -1}, Rgb(1000.0)),
                  PointLight({1, 0.5, 4}, Rgb(100.0))};
  const SolveResult with = Solve(scene, 0.1, "+occlusion"), without = Solve(dark, 0.1);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(with.summary.rounds.back().emitted_w[c], without.summary.rounds.back().emitted_w[c]);
    // The lamp inside is not lost beside what shines outside.
    EXPECT_NEAR(with.summary.rounds.back().absorbed_w[c], 2, 0.02);
  }
}

Sky EvenSky(const Rgb& radiance) {
  Sky sky;
  sky.columns = sky.rows = 1;
  for (int c = 0; c < 3; ++c) sky.texels.push_back(static_cast<float>(radiance[c]));
  return sky;
}

TEST(Lights, AnOpenPlaneGetsPiTimesTheSky) {
  Scene scene = Floor(0.5);
  scene.sky = EvenSky({1, 2, 3});
  const SolveResult result = Solve(scene);
  ASSERT_FALSE(result.patch.vertices.empty());
  for (const PatchVertex& vertex : result.patch.vertices) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(vertex.irradiance[c], (c + 1) * pi, 1e-6);
  }
  EXPECT_NEAR(result.summary.rounds.back().emitted_w[1], 2 * pi * 16, 1e-9);
  EXPECT_LT(result.summary.rounds.back().energy_imbalance, 1e-9);
}

// The whole sphere is even, the upper half alone is lit: a plane on edge gets half.
TEST(Lights, TheGroundIsDark) {
  Scene scene = Floor(0.0);
  scene.sky = EvenSky(Rgb(1.0));
  scene.sky.rows = 2;
  scene.sky.texels = {1, 1, 1, 0, 0, 0};
  scene.sky.up = {1, 0, 0};
  for (const PatchVertex& vertex : Solve(scene).patch.vertices) {
    EXPECT_NEAR(vertex.irradiance[0], 0.5 * pi, 0.005 * pi);
  }
}

// A room of which the ceiling is missing.
Scene OpenRoom(double reflectance) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(reflectance));
  Scene scene = BoxRoom({1, 2, 1.5}, faces);
  scene.polygons.pop_back();
  scene.sky = EvenSky(Rgb(1.0));
  return scene;
}

TEST(Lights, AnOpeningShowsItsFormFactorOfTheSky) {
  const Scene scene = OpenRoom(0);
  const double accuracy = 0.05;
  const SolveResult result = Solve(scene, accuracy);
  const std::array<Vec3, 4> opening = {Vec3(0, 0, 1.5), Vec3(0, 2, 1.5), Vec3(1, 2, 1.5),
                                       Vec3(1, 0, 1.5)};
  double off = 0, arriving = 0;
  int points = 0;
  for (const PatchVertex& vertex : result.patch.vertices) {
    const Vec3& x = vertex.position;
    if (x.z > 1e-6 || std::min({x.x, x.y, 1 - x.x, 2 - x.y}) < 1e-3) continue;  // of the floor
    const double factor =
        PointFormFactors(Vec3x4(std::array<Vec3, 4>{x, x, x, x}), Vec3(0, 0, 1), opening)[0];
    off += std::abs(vertex.irradiance[0] - pi * factor);
    arriving += pi * factor;
    ++points;
  }
  EXPECT_GT(points, 20);
  EXPECT_LT(off / arriving, accuracy);
  // The same in power: the floor's form factor of the opening, by row sums.
  EXPECT_NEAR(result.summary.rounds.back().escaped_w[0], 0, 1e-12);
}

// On one, two and three workers; nor may energy be lost. What escapes is known by rays, of the
// leaves that reflect the light of the sun by the most: with 32 a leaf a hundredth was missing.
void ExpectSameBits(const Scene& scene, const SolveOptions& options) {
  const SolveResult result = SolveToSameBits(scene, options, {1, 2, 3});
  EXPECT_LT(result.summary.rounds.back().energy_imbalance, 0.006);
}

TEST(Lights, SunAndSkyKeepTheBits) {
  Scene scene = OpenRoom(0.6);
  scene.lights = {DirectionalLight({0.3, 0.4, -1}, {500, 480, 450})};
  scene.lights[0].disc_radius = 0.00465;
  SolveOptions options;
  options.accuracy = 0.1;
  options.epsilons = {200, 40};
  ExpectSameBits(scene, options);
}

Scene LitRoom() {
  Scene scene = RandomRoom(3, 3);
  Bounds3 bounds;
  for (const Vec3& v : scene.vertices) bounds.Add(v);
  const Vec3 centre = bounds.Centre();
  scene.lights = {PointLight(centre, {4, 3, 2}),
                  SpotLight(centre + 0.2 * bounds.Extent(), {0, -0.3, -1}, {20, 20, 30}, 0.2, 0.6),
                  DirectionalLight({1, 2, -3}, {50, 50, 50})};
  return scene;
}

TEST(Lights, SameBitsForAnyNumberOfWorkers) {
  const Scene scene = LitRoom();
  SolveOptions options;
  options.accuracy = 0.1;
  options.epsilons = {20, 2, 0.4};
  options.cut_size = 64;
  ExpectSameBits(scene, options);
}

double BoundOf(const Scene& scene, const char* name, double accuracy, bool* on) {
  const EffectsTable table = PlanEffects(Hierarchy(scene), accuracy, {});
  const auto found = std::ranges::find(table.effects, name, &Effect::name);
  EXPECT_NE(found, table.effects.end());
  EXPECT_TRUE(found->bound.has_value()) << name;
  *on = found->on;
  return found->bound.value_or(0);
}

// Beside a lamp, of a hundredth or thousandth of its power: what leaving it out costs is below the
// bound, and not below it by far where all of the light counts; below a fifth of the accuracy it is
// left out.
TEST(Lights, NeglectingCostsLessThanTheBound) {
  for (const double share : {1e-2, 1e-3}) {
    for (const char* name : {"lights", "sun", "sky"}) {
      const std::string which = name;
      Scene scene = OpenRoom(0.5);
      scene.sky = Sky();
      scene.materials.push_back({"lamp", Rgb(0.5), Rgb(10.0)});
      scene.polygons[0].material = static_cast<uint32_t>(scene.materials.size() - 1);
      scene.polygons[0].sides |= kFrontEmits;
      const double power = share * 10 * 3;
      if (which == "lights") scene.lights = {PointLight({0.5, 1, 0.5}, Rgb(power / (4 * pi)))};
      if (which == "sun") {
        scene.lights = {DirectionalLight({0, 0, -1}, Rgb(power / 2))};
        scene.lights[0].disc_radius = 0.01;
      }
      if (which == "sky") scene.sky = EvenSky(Rgb(power / pi / 11));
      bool on = false;
      const double bound = BoundOf(scene, name, 0.1, &on);
      EXPECT_EQ(on, bound >= 0.02) << name;
      const auto arriving = [&](const std::string& sign) {
        const std::string effects = sign + which + ",+occlusion,+colour";
        return Solve(scene, 0.05, effects).summary.rounds.back().absorbed_w[0];
      };
      const double cost = 1 - arriving("-") / arriving("+");
      EXPECT_GT(cost, 0) << name << " " << share;
      EXPECT_LE(cost, bound) << name << " " << share;
      EXPECT_GT(cost, 0.02 * bound) << name << " " << share;
    }
  }
}

TEST(Lights, WithoutLightsNothingChanges) {
  const Scene scene = RandomRoom(3, 2);
  const std::string plain = BytesWithoutComments(Solve(scene, 0.1, "auto").patch);
  EXPECT_EQ(BytesWithoutComments(Solve(scene, 0.1, "+lights,+sun,+sky").patch), plain);
  EXPECT_EQ(BytesWithoutComments(Solve(scene, 0.1, "-lights,-sun,-sky").patch), plain);
  // Those of a scene that are switched off leave no trace either, but in shadows and colours.
  Scene lit = scene;
  lit.lights = LitRoom().lights;
  lit.lights[2].disc_radius = 0.01;
  lit.sky = EvenSky(Rgb(1.0));
  EXPECT_EQ(BytesWithoutComments(Solve(lit, 0.1, "-lights,-sun,-sky,+occlusion,+colour").patch),
            BytesWithoutComments(Solve(scene, 0.1, "+occlusion,+colour").patch));
}

}  // namespace
}  // namespace isolux::testing
