// An absorbing medium: what it leaves between two polygons against fine sums and the law of two
// plates, and through whole solves against sums at every vertex, walks of photons, and the mean
// chord of convex rooms.
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
#include "worker/radiosity/transmission.h"

namespace isolux::testing {
namespace {

using std::numbers::pi;

SolveResult Solve(const Scene& scene, double accuracy, const std::string& effects = "",
                  int workers = 1) {
  return SolveScene(scene, accuracy, effects, workers);
}

const RoundSummary& LastRound(const SolveResult& result) { return result.summary.rounds.back(); }

ConvexPolygon Quad(const Vec3& corner, const Vec3& u, const Vec3& v) {
  ConvexPolygon polygon;
  polygon.count = 4;
  polygon.v = {corner, corner + u, corner + u + v, corner + v};
  return polygon;
}

// What of the light of `lamp`, of radiosity 1, arrives at a point: midpoints of n by n cells.
Rgb ArrivingAt(const Medium& medium, const Vec3& point, const Vec3& normal,
               const ConvexPolygon& lamp, int n) {
  const Vec3 u = lamp.v[1] - lamp.v[0], v = lamp.v[3] - lamp.v[0], towards = lamp.Normal();
  Rgb sum(0.0);
  for (int i = 0; i < n * n; ++i) {
    const int column = i % n, row = i / n;
    const Vec3 d = lamp.v[0] + (column + 0.5) / n * u + (row + 0.5) / n * v - point;
    const double r2 = glm::dot(d, d);
    const double cosines =
        std::max(0.0, glm::dot(normal, d)) * std::max(0.0, -glm::dot(towards, d));
    sum += cosines / (pi * r2 * r2) * medium.Along(std::sqrt(r2));
  }
  return lamp.Area() / (n * n) * sum;
}

TEST(Medium, ExponentialsAreRight) {
  for (double x = 0; x < 690; x = x * 1.37 + 0.001) {
    EXPECT_NEAR(ExpOfMinus(x) / std::exp(-x), 1, 1e-14) << x;
  }
  EXPECT_EQ(ExpOfMinus(0), 1);
  EXPECT_EQ(ExpOfMinus(1e9), 0);
}

// Pairs that touch, lie close, or far apart; thin media and thick ones.
TEST(Medium, MeansOverPairsAreThoseOfFineSums) {
  const ConvexPolygon floor = Quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const std::array<ConvexPolygon, 5> others = {
      Quad({0, 0, 0}, {0, 1, 0}, {0, 0, 1}),           // shares a side
      Quad({0, 0, 0.1}, {0, 1, 0}, {1, 0, 0}),         // close above
      Quad({-0.3, 0.2, 1}, {0, 1, 0}, {1, 0, 0}),      // a size away
      Quad({1, 2, 6}, {0, 1, 0}, {1, 0, 0}),           // far
      Quad({0, -0.6, 0.1}, {0, 0, 0.3}, {0.3, 0, 0}),  // beside, smaller
  };
  for (size_t k = 0; k < others.size(); ++k) {
    const ConvexPolygon& other = others[k];
    const Medium medium{{0.05, 0.5, 3}};
    Rgb with(0.0), without(0.0);
    constexpr int kCells = 20;
    for (int i = 0; i < kCells * kCells; ++i) {
      const int column = i % kCells, row = i / kCells;
      const Vec3 x((column + 0.5) / kCells, (row + 0.5) / kCells, 0);
      with += ArrivingAt(medium, x, {0, 0, 1}, other, 40);
      without += ArrivingAt({}, x, {0, 0, 1}, other, 40);
    }
    const Rgb mean = MeanTransmission(medium, floor, other);
    for (int c = 0; c < 3; ++c) {
      const double taken = 1 - with[c] / without[c];
      EXPECT_NEAR((1 - mean[c]) / taken, 1, 0.006) << k << " " << c;
    }
    const Rgb reverse = MeanTransmission(medium, other, floor);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(reverse[c], mean[c], 1e-4);
  }
}

// ∫ e^(−x/µ) µ dµ over 0 … 1.
double E3(double x) {
  double sum = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = (i + 0.5) / kSteps;
    sum += std::exp(-x / mu) * mu / kSteps;
  }
  return sum;
}

// Between plates without end, a distance d apart, the medium takes 1 − 2 E3(κ d).
TEST(Medium, TwoPlatesFollowTheExponentialIntegral) {
  const Medium medium{{3, 3.5, 4}};
  const Rgb middle =
      ArrivingAt(medium, {0, 0, 0}, {0, 0, 1}, Quad({-4, -4, 1}, {0, 8, 0}, {8, 0, 0}), 400);
  BoxFaces faces;
  faces.exitance[5] = Rgb(1);
  Scene scene = BoxRoom({4, 4, 1}, faces);
  scene.medium = medium;
  SolveOptions options;
  options.accuracy = 0.1;
  options.epsilons = {0.5};  // W, of 16
  const auto result = SolveInProcess(scene, options, 1, 2);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  int points = 0;
  for (int c = 0; c < 3; ++c) {
    const double left = 2 * E3(medium.extinction_per_m[c]);
    EXPECT_NEAR(middle[c], left, 1e-4);  // the sum that other tests rely on
    for (const PatchVertex& vertex : result->patch.vertices) {
      const Vec3& x = vertex.position;
      if (x.z > 1e-6 || glm::length(Vec3(x.x - 2, x.y - 2, 0)) > 0.6) continue;
      EXPECT_NEAR(vertex.irradiance[c] / left, 1, 0.01) << c;
      ++points;
    }
  }
  EXPECT_GT(points, 2);
}

// Mean error over the mean of the floor's irradiance; `expected` at a point of it.
template <typename Expected>
double ErrorOnFloor(const SolveResult& result, const Expected& expected) {
  double error = 0, total = 0;
  for (const PatchVertex& vertex : result.patch.vertices) {
    const Vec3& x = vertex.position;
    if (x.z > 1e-6 || std::min({x.x, x.y, 1 - x.x, 2 - x.y}) < 1e-3) continue;
    const Rgb right = expected(x);
    for (int c = 0; c < 3; ++c) {
      error += std::abs(vertex.irradiance[c] - right[c]);
      total += right[c];
    }
  }
  EXPECT_GT(total, 0);
  return error / total;
}

TEST(Medium, ALampIsDimmedAtEveryPoint) {
  for (const Rgb& extinction : {Rgb(0.7), Rgb(0.1, 0.5, 2)}) {
    BoxFaces faces;
    faces.exitance[5] = Rgb(1);
    Scene scene = BoxRoom({1, 2, 1.5}, faces);
    scene.medium = {extinction};
    const SolveResult result = Solve(scene, 0.05);
    const ConvexPolygon lamp = Quad({0, 0, 1.5}, {0, 2, 0}, {1, 0, 0});
    EXPECT_LT(ErrorOnFloor(result,
                           [&](const Vec3& x) {
                             return ArrivingAt(scene.medium, x, {0, 0, 1}, lamp, 32);
                           }),
              0.005);
    EXPECT_LT(LastRound(result).energy_imbalance, 5e-3);
  }
}

TEST(Medium, LightsAndSkyAreDimmed) {
  BoxFaces faces;
  Scene open = BoxRoom({1, 2, 1.5}, faces);
  open.polygons.pop_back();
  open.medium = {{0.2, 0.5, 1}};
  Scene lit = open;
  Light light;
  light.position_m = {0.3, 0.8, 1};
  light.intensity = {3, 2, 1};
  lit.lights = {light};
  EXPECT_LT(ErrorOnFloor(Solve(lit, 0.05),
                         [&](const Vec3& x) {
                           const Vec3 d = light.position_m - x;
                           const double r = glm::length(d);
                           return d.z / (r * r * r) * light.intensity * lit.medium.Along(r);
                         }),
            5e-5);  // points lie a hundred-thousandth inside their elements
  // From where it enters the box of the scene.
  light.kind = LightKind::kDirectional;
  light.direction = {0, 0, -1};
  lit.lights = {light};
  EXPECT_LT(ErrorOnFloor(Solve(lit, 0.05),
                         [&](const Vec3&) { return light.intensity * lit.medium.Along(1.5); }),
            1e-6);
  Scene sky = open;
  sky.sky.columns = sky.sky.rows = 1;
  sky.sky.texels = {1, 1, 1};
  const ConvexPolygon opening = Quad({0, 0, 1.5}, {0, 2, 0}, {1, 0, 0});
  EXPECT_LT(ErrorOnFloor(Solve(sky, 0.2),
                         [&](const Vec3& x) {
                           return pi * ArrivingAt(sky.medium, x, {0, 0, 1}, opening, 32);
                         }),
            0.01);
}

// A room that is grey all over, one wall of which shines.
Scene Room() {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.6, 0.5, 0.7));
  faces.exitance[0] = Rgb(1);
  Scene scene = BoxRoom({1, 2, 1.5}, faces);
  scene.medium = {{0.1, 0.4, 0.8}};
  return scene;
}

// What the medium takes, W, by photons that go from wall to wall of a box.
Rgb AbsorbedByWalks(const Vec3& size, const Scene& scene, int photons) {
  Random random(7);
  Rgb absorbed(0.0);
  const Rgb& reflectance = scene.materials[scene.polygons[1].material].reflectance;
  for (int i = 0; i < photons; ++i) {
    Vec3 at(0, random.Unit() * size.y, random.Unit() * size.z);
    Rgb power(size.y * size.z / photons);
    int wall = 0;  // axis and side
    while (Sum(power) > 1e-4 * size.y * size.z / photons) {
      const double r2 = random.Unit(), turn = 2 * pi * random.Unit();
      const int axis = wall / 2;
      Vec3 d(0.0);
      d[axis] = (wall % 2 == 0 ? 1 : -1) * std::sqrt(1 - r2);
      d[(axis + 1) % 3] = std::sqrt(r2) * std::cos(turn);
      d[(axis + 2) % 3] = std::sqrt(r2) * std::sin(turn);
      double way = std::numeric_limits<double>::infinity();
      for (int k = 0; k < 3; ++k) {
        if (d[k] == 0 || (k == axis)) continue;
        const double to = ((d[k] > 0 ? size[k] : 0) - at[k]) / d[k];
        if (to < way) {
          way = to;
          wall = 2 * k + (d[k] > 0 ? 1 : 0);
        }
      }
      if (const double across = size[axis] / std::abs(d[axis]); across < way) {
        way = across;
        wall = 2 * axis + (d[axis] > 0 ? 1 : 0);
      }
      at += way * d;
      const Rgb left = scene.medium.Along(way);
      absorbed += power * (Rgb(1.0) - left);
      power *= left * reflectance;
    }
  }
  return absorbed;
}

TEST(Medium, WalksOfPhotonsLoseAsMuch) {
  const Scene scene = Room();
  const SolveResult result = Solve(scene, 0.03);
  EXPECT_LT(LastRound(result).energy_imbalance, 5e-3);
  const Rgb expected = AbsorbedByWalks({1, 2, 1.5}, scene, 20000);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(LastRound(result).medium_w[c] / expected[c], 1, 0.015) << c;
  }
}

// Where all walls are alike, a thin medium takes κ times the mean chord 4 V/S of what they radiate.
TEST(Medium, ThinOnesTakeTheMeanChord) {
  Scene scene = FurnaceCube(0.5, 1);
  scene.medium = {Rgb(1e-3)};
  const SolveResult result = Solve(scene, 0.02, "+medium");
  const double mean_chord = 4.0 / 6;
  EXPECT_NEAR(LastRound(result).medium_w[0] / (2 * 6 * 1e-3 * mean_chord), 1, 0.015);
}

// A mirror for a wall shows the other half of a room twice as long.
TEST(Medium, MirrorsAreFarther) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.4));
  faces.exitance[4] = Rgb(1);
  Scene whole = BoxRoom({2, 1, 1.5}, faces);
  Scene half = BoxRoom({1, 1, 1.5}, faces);
  Material mirror;
  mirror.specular = 1;
  half.polygons[1].material = static_cast<uint32_t>(half.materials.size());
  half.materials.push_back(mirror);
  half.medium = whole.medium = {Rgb(0.5)};
  const RoundSummary mirrored = LastRound(Solve(half, 0.04));
  const RoundSummary unfolded = LastRound(Solve(whole, 0.04));
  EXPECT_NEAR(mirrored.medium_w[0] / (0.5 * unfolded.medium_w[0]), 1, 0.004);
  EXPECT_LT(mirrored.energy_imbalance, 0.003);
}

TEST(Medium, NeglectingCostsLessThanTheBound) {
  for (const double extinction : {1e-4, 0.1}) {
    Scene scene = Room();
    scene.medium = {Rgb(extinction)};
    const EffectsTable table = PlanEffects(Hierarchy(scene), 0.1, {});
    const auto row = std::ranges::find(table.effects, "medium", &Effect::name);
    ASSERT_NE(row, table.effects.end());
    ASSERT_TRUE(row->present && row->bound.has_value());
    EXPECT_EQ(row->on, extinction > 0.01);
    const auto arriving = [&](const std::string& effects) {
      const auto absorbed = LastRound(Solve(scene, 0.05, effects)).absorbed_w;
      return absorbed[0] / 0.4 + absorbed[1] / 0.5 + absorbed[2] / 0.3;
    };
    const double cost = arriving("-medium") / arriving("+medium") - 1;
    EXPECT_GT(cost, 0);
    EXPECT_LE(cost, *row->bound);
  }
  // Coloured media call for colours.
  const EffectsTable table = PlanEffects(Hierarchy(Room()), 0.1, {});
  EXPECT_EQ(table.plan.channels, 3);
}

TEST(Medium, SameBitsForAnyNumberOfWorkers) {
  for (const Rgb& extinction : {Rgb(0.5), Rgb(0.1, 0.3, 0.2)}) {
    Scene scene = RandomRoom(3, 1);
    scene.medium = {extinction};
    SolveOptions options;
    options.accuracy = 0.1;
    options.epsilons = {20, 8};
    options.cut_size = 64;
    EXPECT_LT(LastRound(SolveToSameBits(scene, options)).energy_imbalance, 0.006);
  }
}

TEST(Medium, SwitchedOffItLeavesNoTrace) {
  const Scene plain = RandomRoom(3, 1);
  Scene filled = plain;
  filled.medium = {Rgb(0.5)};
  const SolveResult without = Solve(plain, 0.3, "+colour");
  EXPECT_EQ(BytesWithoutComments(Solve(filled, 0.3, "-medium,+colour").patch),
            BytesWithoutComments(without.patch));
  EXPECT_EQ(BytesWithoutComments(Solve(plain, 0.3, "+medium,+colour").patch),
            BytesWithoutComments(without.patch));
  EXPECT_EQ(LastRound(without).medium_w, (std::array<double, 3>{}));
}

TEST(Medium, SolversThatKnowOfNoneSaySo) {
  SolveOptions options;
  options.solver = SolverMethod::kGaussSeidel;
  const auto result = SolveInProcess(Room(), options, 1, 1);
  ASSERT_FALSE(result.has_value());
  EXPECT_NE(result.error().message().find("--effects=-medium"), std::string::npos);
}

TEST(Medium, FollowsTheSceneAsBytes) {
  const Scene scene = Room();
  const std::string bytes = Encode(scene);
  const auto back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(back->medium.extinction_per_m, scene.medium.extinction_per_m);
  Scene clear = scene;
  clear.medium = {};
  EXPECT_EQ(Encode(clear), bytes.substr(0, bytes.size() - 32));
  for (size_t size = bytes.size() - 31; size < bytes.size(); ++size) {
    EXPECT_FALSE(Decode(bytes.substr(0, size)).has_value()) << size;
  }
  for (const double wrong : {-1.0, 1e7, std::nan("")}) {
    clear.medium.extinction_per_m.y = wrong;
    EXPECT_FALSE(Validate(clear).ok()) << wrong;
  }
}

}  // namespace
}  // namespace isolux::testing
