// Panes of clear glass through whole solves, against exact angles, fine sums, walks of photons and
// traced paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/import/prepare.h"
#include "client/output/comparison.h"
#include "common/hierarchy/effects/plan.h"
#include "common/hierarchy/panes.h"
#include "common/util/random.h"
#include "tests/support/glass.h"
#include "tests/support/local_cluster.h"
#include "tests/support/path_tracer.h"
#include "tests/support/same_bits.h"
#include "tests/support/scenes.h"
#include "tests/support/solve_scene.h"

namespace isolux::testing {
namespace {

using std::numbers::pi;

const RoundSummary& LastRound(const SolveResult& result) { return result.summary.rounds.back(); }

ConvexPolygon Quad(const Vec3& corner, const Vec3& u, const Vec3& v) {
  ConvexPolygon polygon;
  polygon.count = 4;
  polygon.v = {corner, corner + u, corner + u + v, corner + v};
  return polygon;
}

TEST(Glass, PanesAreCrossedOnceWhereTheyMeet) {
  Scene scene;
  const Glass glass = GlassOf(Rgb(0.5), 1);
  AddPane(scene, Quad({0, 0, 1}, {1, 0, 0}, {0, 1, 0}), glass);
  AddPane(scene, Quad({1, 0, 1}, {1, 0, 0}, {0, 1, 0}), glass);
  AddPane(scene, Quad({0, 0, 2}, {0, 1, 0}, {2, 0, 0}), glass);
  const Panes panes(scene.glazing, 5, false);
  const auto along = [&](const Vec3& a, const Vec3& b) { return panes.Along(a, b).x; };
  EXPECT_NEAR(along({0.5, 0.5, 0}, {0.5, 0.5, 1.5}), 0.5, 1e-15);
  EXPECT_NEAR(along({1, 0.5, 0}, {1, 0.5, 1.5}), 0.5, 1e-15);
  EXPECT_NEAR(along({1, 0, 0}, {1, 0, 3}), 0.25, 1e-15);
  for (const double index : {1.0, 1.5, 2.4}) {
    Scene one;
    const Glass tinted = GlassOf({1, 0.5, 0.05}, index);
    AddPane(one, Quad({-99, -99, 1}, {999, 0, 0}, {0, 999, 0}), tinted);
    const Panes pane(one.glazing, 5, false);
    for (double cosine = 0.013; cosine < 1; cosine += 0.0371) {
      const Vec3 d(std::sqrt(1 - cosine * cosine), 0, cosine);
      const Rgb off = pane.Along({0, 0, 0}, d * (2 / cosine)) - tinted.Transmittance(cosine);
      EXPECT_LT(glm::length(off), 2e-5) << cosine;
    }
  }
  EXPECT_EQ(along({0.5, 0.5, 0}, {0.5, 0.5, 1}), 1);  // ends on it
  EXPECT_EQ(along({-1, 0.5, 0}, {-1, 0.5, 3}), 1);
  EXPECT_EQ(along({0, 0.5, 1}, {2, 0.5, 1}), 1);  // lies in it
  const auto between = [&](const ConvexPolygon& a, const ConvexPolygon& b) {
    return panes.Between(std::span(a.v.data(), 4), std::span(b.v.data(), 4));
  };
  const ConvexPolygon below = Quad({0.2, 0.2, 0}, {0.5, 0, 0}, {0, 0.5, 0});
  EXPECT_EQ(between(below, Quad({0.2, 0.2, 1.5}, {0, 0.5, 0}, {0.5, 0, 0})), Crossing::kAll);
  EXPECT_EQ(between(below, Quad({0.2, 0.2, 0.5}, {0, 0.5, 0}, {0.5, 0, 0})), Crossing::kNone);
  EXPECT_EQ(between(below, Quad({-0.5, 0.2, 1.5}, {0, 0.5, 0}, {1, 0, 0})), Crossing::kSome);
  EXPECT_EQ(between(below, Quad({-9, 0.2, 1.5}, {0, 0.5, 0}, {1, 0, 0})), Crossing::kNone);
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

Scene OpenBox() {
  Scene open = BoxRoom({1, 2, 1.5}, {});
  open.polygons.pop_back();
  return open;
}

TEST(Glass, PointsAndSunsAreDimmedByTheirAngle) {
  Scene scene = OpenBox();
  const Glass glass = GlassOf({0.9, 0.6, 0.3}, 1.5);
  AddPane(scene, Quad({-1, -1, 0.5}, {4, 0, 0}, {0, 5, 0}), glass);
  Scene lit = scene;
  Light light;
  light.position_m = {0.3, 0.8, 1};
  light.intensity = {3, 2, 1};
  lit.lights = {light};
  const auto from_point = [&](const Vec3& x) {
    const Vec3 d = light.position_m - x;
    const double r = glm::length(d);
    return d.z / (r * r * r) * light.intensity * glass.Transmittance(d.z / r);
  };
  EXPECT_LT(ErrorOnFloor(SolveScene(lit, 0.05), from_point), 5e-5);
  // A second pane, aslant: the product.
  const ConvexPolygon aslant = Quad({-1, -1, 0.6}, {4, 0, 0.3}, {0, 5, 0});
  const Glass green = GlassOf({0.5, 0.9, 0.5}, 1.6);
  AddPane(lit, aslant, green);
  EXPECT_LT(ErrorOnFloor(SolveScene(lit, 0.05),
                         [&](const Vec3& x) {
                           const Vec3 d = glm::normalize(light.position_m - x);
                           return from_point(x) *
                                  green.Transmittance(std::abs(glm::dot(aslant.Normal(), d)));
                         }),
            5e-5);
  // Straight down and aslant, without a disc and with one.
  for (const Vec3& direction : {Vec3(0, 0, -1), glm::normalize(Vec3(0.1, 0.9, -1.5))}) {
    for (const double radius : {0.0, 0.0047}) {
      Scene sunny = scene;
      sunny.polygons = {scene.polygons.back()};  // the floor alone
      light.kind = LightKind::kDirectional;
      light.direction = direction;
      light.disc_radius = radius;
      sunny.lights = {light};
      EXPECT_LT(ErrorOnFloor(SolveScene(sunny, 0.05),
                             [&](const Vec3&) {
                               return -direction.z * light.intensity *
                                      glass.Transmittance(-direction.z);
                             }),
                1e-4);
    }
  }
}

// What of the light of `lamp`, of radiosity 1, arrives at a point of the floor: midpoints of n by n
// cells, each by `left(point of the lamp)`.
template <typename Left>
Rgb ArrivingAt(const Vec3& point, const ConvexPolygon& lamp, int n, const Left& left) {
  const Vec3 u = lamp.v[1] - lamp.v[0], v = lamp.v[3] - lamp.v[0], towards = lamp.Normal();
  Rgb sum(0.0);
  for (int i = 0; i < n * n; ++i) {
    const int column = i % n, row = i / n;
    const Vec3 y = lamp.v[0] + (column + 0.5) / n * u + (row + 0.5) / n * v;
    const Vec3 d = y - point;
    const double r2 = glm::dot(d, d);
    const double cosines = std::max(0.0, d.z) * std::max(0.0, -glm::dot(towards, d));
    sum += cosines / (pi * r2 * r2) * left(y);
  }
  return lamp.Area() / (n * n) * sum;
}

const ConvexPolygon kCeiling = Quad({0, 0, 1.5}, {0, 2, 0}, {1, 0, 0});

// Panes that reach from wall to wall, or end in the middle of the room; clear, and in colour.
TEST(Glass, ALampIsDimmedAtEveryPoint) {
  for (const double width : {1.0, 0.4}) {
    for (const Glass& glass : {GlassOf(Rgb(0.8), 1.5), GlassOf({0.2, 0.5, 0.9}, 1.5)}) {
      BoxFaces faces;
      faces.exitance[5] = Rgb(1);
      Scene scene = BoxRoom({1, 2, 1.5}, faces);
      AddPane(scene, Quad({0, 0, 0.7}, {width, 0, 0}, {0, 2, 0}), glass);
      const SolveResult result = SolveScene(scene, 0.06);
      const double error = ErrorOnFloor(result, [&](const Vec3& x) {
        return ArrivingAt(x, kCeiling, 32, [&](const Vec3& y) {
          const double crossed = x.x + 0.7 / 1.5 * (y.x - x.x);
          if (crossed > width) return Rgb(1.0);
          return glass.Transmittance((y.z - x.z) / glm::length(y - x));
        });
      });
      EXPECT_LT(error, width == 1 ? 0.003 : 0.02) << width;
      EXPECT_LT(LastRound(result).energy_imbalance, 5e-3);
      EXPECT_GT(LastRound(result).glass_w[0], 0.02);
    }
  }
}

// Under a wide pane an even sky arrives as its mean over the hemisphere.
TEST(Glass, SkyComesThroughWindows) {
  const Glass glass = GlassOf({1, 0.8, 0.5}, 1.5);
  Scene wide = OpenBox();
  wide.polygons = {wide.polygons.back()};
  wide.sky.columns = wide.sky.rows = 1;
  wide.sky.texels = {1, 1, 1};
  Scene window = OpenBox();
  window.sky = wide.sky;
  AddPane(wide, Quad({-500, -500, 0.5}, {1000, 0, 0}, {0, 1000, 0}), glass);
  EXPECT_LT(ErrorOnFloor(SolveScene(wide, 0.05),
                         [&](const Vec3&) { return pi * glass.MeanTransmittance(); }),
            0.01);
  // In the opening of a room, from wall to wall: no light beside it, no dark edge.
  AddPane(window, Quad({0, 0, 1.5}, {1, 0, 0}, {0, 2, 0}), glass);
  EXPECT_LT(ErrorOnFloor(SolveScene(window, 0.2),
                         [&](const Vec3& x) {
                           return pi * ArrivingAt(x, kCeiling, 32, [&](const Vec3& y) {
                                    return glass.Transmittance((y.z - x.z) / glm::length(y - x));
                                  });
                         }),
            0.01);
}

// A room split by a pane from wall to wall, one end of which shines.
Scene SplitRoom(const Glass& glass) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.6, 0.5, 0.7));
  faces.exitance[0] = Rgb(1);
  Scene scene = BoxRoom({1, 2, 1.5}, faces);
  AddPane(scene, Quad({0.55, 0, 0}, {0, 2, 0}, {0, 0, 1.5}), glass);
  RepairLog log;  // walls are cut where panes touch them
  PrepareForTransport(&scene, &log, [](uint32_t) { return std::string(); });
  return scene;
}

// What the pane at x = `at` takes, W, and what the far end receives, by photons that go from wall
// to wall of the box.
struct Walked {
  Rgb taken{0.0}, far_end{0.0};
};
Walked Walk(const Vec3& size, double at_x, const Glass& glass, const Rgb& reflectance,
            int photons) {
  Random random(7);
  Walked walked;
  for (int i = 0; i < photons; ++i) {
    Vec3 at(0, random.Unit() * size.y, random.Unit() * size.z);
    Rgb power(size.y * size.z / photons);
    int axis = 0;
    bool high = false;
    while (Sum(power) > 1e-3 * size.y * size.z / photons) {
      const double r2 = random.Unit(), turn = 2 * pi * random.Unit();
      Vec3 d(0.0);
      d[axis] = (high ? -1 : 1) * std::sqrt(1 - r2);
      d[(axis + 1) % 3] = std::sqrt(r2) * std::cos(turn);
      d[(axis + 2) % 3] = std::sqrt(r2) * std::sin(turn);
      const Vec3 from = at;
      double way = std::numeric_limits<double>::infinity();
      for (int k = 0; k < 3; ++k) {
        const double to = d[k] == 0 ? way : ((d[k] > 0 ? size[k] : 0) - from[k]) / d[k];
        if (!(to < way) || to <= 1e-12) continue;
        way = to;
        axis = k;
        high = d[k] > 0;
      }
      at += way * d;
      at[axis] = high ? size[axis] : 0;
      if ((from.x < at_x) != (at.x < at_x)) {
        const Rgb left = glass.Transmittance(std::abs(d.x));
        walked.taken += power * (Rgb(1.0) - left);
        power *= left;
      }
      if (axis == 0 && high) walked.far_end += power;
      power *= reflectance;
    }
  }
  return walked;
}

Rgb PowerOn(const SolveResult& result, uint32_t polygon) {
  Rgb power(0.0);
  for (const PatchFace& face : result.patch.faces) {
    if (face.polygon != polygon) continue;
    const auto corner = [&](size_t k) {
      return result.patch.vertices[face.vertices[k % face.vertices.size()]].position;
    };
    Vec3 area(0.0);
    for (size_t k = 0; k < face.vertices.size(); ++k) {
      area += 0.5 * glm::cross(corner(k), corner(k + 1));
    }
    for (int c = 0; c < 3; ++c) power[c] += glm::length(area) * face.irradiance[c];
  }
  return power;
}

TEST(Glass, WalksOfPhotonsLoseAsMuch) {
  const Glass glass = GlassOf({0.9, 0.5, 0.2}, 1.5);
  const SolveResult result = SolveScene(SplitRoom(glass), 0.02);
  EXPECT_LT(LastRound(result).energy_imbalance, 5e-3);
  const Walked walked = Walk({1, 2, 1.5}, 0.55, glass, {0.6, 0.5, 0.7}, 30000);
  const Rgb far_end = PowerOn(result, 1);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(LastRound(result).glass_w[c] / walked.taken[c], 1, 0.015) << c;
    EXPECT_NEAR(far_end[c] / walked.far_end[c], 1, 0.015) << c;
  }
}

TEST(Glass, TracedPathsAgree) {
  Scene scene = RandomRoom(3, 2);
  Bounds3 box;
  for (const Vec3& v : scene.vertices) box.Add(v);
  const Vec3 centre = box.Centre(), size = box.Extent();
  AddPane(scene,
          Quad({centre.x, box.low.y, box.low.z}, {0, size.y, 0}, {0.1 * size.x, 0, 0.6 * size.z}),
          GlassOf({0.8, 0.3, 0.6}, 1.5));
  ThreadPool pool(2);
  PathTracing tracing;
  tracing.points = 30;
  tracing.error = 0.03;
  tracing.seconds = 0.3;
  const std::vector<ReferencePoint> points = TracePaths(scene, tracing, pool);
  const SolveResult result = SolveScene(scene, 0.1);
  const Result<Comparison> compared = Compare(result.patch, points);
  ASSERT_TRUE(compared.has_value()) << compared.error().message();
  EXPECT_LT(compared->l1_relative, 0.1 + NoiseOf(points));
}

TEST(Glass, MovedAndTurnedRoomsAreTheSame) {
  const Scene scene = SplitRoom(GlassOf(Rgb(0.6), 1.5));
  Scene moved = scene;
  const auto move = [](const Vec3& x) {
    const double c = std::cos(0.7), s = std::sin(0.7);
    const Vec3 turned(c * x.x - s * x.y, s * x.x + c * x.y, x.z);
    return Vec3(turned.x + 3, 0.8 * turned.y - 0.6 * turned.z, 0.6 * turned.y + 0.8 * turned.z);
  };
  for (Vec3& v : moved.vertices) v = move(v);
  for (Vec3& v : moved.glazing.panes[0].corners) v = move(v);
  const auto here = LastRound(SolveScene(scene, 0.06)), there = LastRound(SolveScene(moved, 0.06));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(here.glass_w[c] / there.glass_w[c], 1, 0.005);
    EXPECT_NEAR(here.absorbed_w[c] / there.absorbed_w[c], 1, 0.005);
  }
}

// A mirror for a wall shows the other half of a room twice as long, with the same pane.
TEST(Glass, MirrorsShowPanes) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.4));
  faces.exitance[4] = Rgb(1);
  Scene whole = BoxRoom({2, 1, 1.5}, faces), half = BoxRoom({1, 1, 1.5}, faces);
  Material mirror;
  mirror.specular = 1;
  half.polygons[1].material = static_cast<uint32_t>(half.materials.size());
  half.materials.push_back(mirror);
  const Glass glass = GlassOf(Rgb(0.6), 1.5);
  AddPane(half, Quad({0.6, 0, 0}, {0, 1, 0}, {0, 0, 1.5}), glass);
  AddPane(whole, Quad({0.6, 0, 0}, {0, 1, 0}, {0, 0, 1.5}), glass);
  AddPane(whole, Quad({1.4, 0, 0}, {0, 1, 0}, {0, 0, 1.5}), glass);
  const SolveResult mirrored = SolveScene(half, 0.08), unfolded = SolveScene(whole, 0.08);
  EXPECT_NEAR(LastRound(mirrored).glass_w[0] / (0.5 * LastRound(unfolded).glass_w[0]), 1, 0.01);
  EXPECT_NEAR(PowerOn(mirrored, 0).x / PowerOn(unfolded, 0).x, 1, 0.01);
  EXPECT_LT(LastRound(mirrored).energy_imbalance, 0.003);
}

TEST(Glass, StandsInMedia) {
  BoxFaces faces;
  faces.exitance[5] = Rgb(1);
  Scene scene = BoxRoom({1, 2, 1.5}, faces);
  scene.medium = {{0.2, 0.4, 0.8}};
  const Glass glass = GlassOf({0.9, 0.6, 0.6}, 1.5);
  AddPane(scene, Quad({0, 0, 0.7}, {1, 0, 0}, {0, 2, 0}), glass);
  const SolveResult result = SolveScene(scene, 0.06);
  EXPECT_LT(ErrorOnFloor(result,
                         [&](const Vec3& x) {
                           return ArrivingAt(x, kCeiling, 24, [&](const Vec3& y) {
                             const double way = glm::length(y - x);
                             return glass.Transmittance((y.z - x.z) / way) *
                                    scene.medium.Along(way);
                           });
                         }),
            0.006);
  const RoundSummary& last = LastRound(result);
  EXPECT_LT(last.energy_imbalance, 5e-3);
  EXPECT_TRUE(last.medium_w[0] > 0.02 && last.glass_w[0] > 0.02);
  // Grey ones of both take as much as either channel alone.
  scene.medium = {Rgb(0.2)};
  scene.glazing.glasses[0] = GlassOf(Rgb(0.9), 1.5);
  const SolveResult grey = SolveScene(scene, 0.06);
  EXPECT_NEAR(LastRound(grey).glass_w[0] / last.glass_w[0], 1, 0.01);
  EXPECT_NEAR(LastRound(grey).medium_w[0] / last.medium_w[0], 1, 0.01);
}

TEST(Glass, NeglectingCostsLessThanTheBound) {
  for (const double height : {1.5, 0.004}) {
    Scene scene = SplitRoom(GlassOf(Rgb(0.9), 1.5));
    for (Vec3& corner : scene.glazing.panes[0].corners) corner.z *= height / 1.5;
    const EffectsTable table = PlanEffects(Hierarchy(scene), 0.2, {});
    const auto row = std::ranges::find(table.effects, "clear-glass", &Effect::name);
    ASSERT_NE(row, table.effects.end());
    ASSERT_TRUE(row->present && row->bound.has_value());
    EXPECT_EQ(row->on, height > 1);
    EXPECT_NE(row->evidence.find("counts as absorbed"), std::string::npos);
    SolveOptions options = ToAccuracy(0.05);
    options.epsilons = {2e-2, 4e-3};
    const auto arriving = [&](const std::string& effects) {
      options.effects = effects;
      const auto absorbed = LastRound(SolveScene(scene, options)).absorbed_w;
      return absorbed[0] / 0.4 + absorbed[1] / 0.5 + absorbed[2] / 0.3;
    };
    const double cost = arriving("-clear-glass") / arriving("+clear-glass") - 1;
    EXPECT_GT(cost, height > 1 ? 0.01 : 0);
    EXPECT_LE(cost, *row->bound);
  }
  // Skies may be any times brighter; glass in colour calls for colours.
  Scene scene = SplitRoom(GlassOf({0.9, 0.5, 0.5}, 1));
  EXPECT_EQ(PlanEffects(Hierarchy(scene), 0.1, {}).plan.channels, 3);
  scene.sky.columns = scene.sky.rows = 1;
  scene.sky.texels = {1, 1, 1};
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.1, {});
  EXPECT_FALSE(std::ranges::find(table.effects, "clear-glass", &Effect::name)->bound.has_value());
}

TEST(Glass, SameBitsForAnyNumberOfWorkers) {
  for (const Rgb& inside : {Rgb(0.5), Rgb(0.9, 0.3, 0.6)}) {
    Scene scene = RandomRoom(3, 1);
    Bounds3 box;
    for (const Vec3& v : scene.vertices) box.Add(v);
    AddPane(scene, Quad(box.Centre(), 0.5 * Vec3(0, box.Extent().y, 0), {0, 0, 9}),
            GlassOf(inside, 1.5));
    SolveOptions options;
    options.accuracy = 0.1;
    options.epsilons = {20, 8};
    options.cut_size = 64;
    EXPECT_LT(LastRound(SolveToSameBits(scene, options)).energy_imbalance, 0.006);
  }
}

TEST(Glass, SwitchedOffItLeavesNoTrace) {
  const Scene plain = RandomRoom(3, 1);
  Scene glazed = plain;
  AddPane(glazed, Quad({-9, -9, 0.7}, {30, 0, 0}, {0, 30, 0}), GlassOf({0.5, 0.2, 0.1}, 1.5));
  const SolveResult without = SolveScene(plain, 0.3, "+colour");
  EXPECT_EQ(BytesWithoutComments(SolveScene(glazed, 0.3, "-clear-glass,+colour").patch),
            BytesWithoutComments(without.patch));
  EXPECT_EQ(BytesWithoutComments(SolveScene(plain, 0.3, "+clear-glass,+colour").patch),
            BytesWithoutComments(without.patch));
  EXPECT_EQ(LastRound(without).glass_w, (std::array<double, 3>{}));
}

TEST(Glass, SolversThatKnowOfNoneSaySo) {
  SolveOptions options;
  options.solver = SolverMethod::kGaussSeidel;
  const auto result = SolveInProcess(SplitRoom(GlassOf(Rgb(0.5), 1.5)), options, 1, 1);
  ASSERT_FALSE(result.has_value());
  EXPECT_NE(result.error().message().find("--effects=-clear-glass"), std::string::npos);
}

TEST(Glass, FollowsTheSceneAsBytes) {
  const Scene scene = SplitRoom(GlassOf({0.9, 0.5, 0.2}, 1.5));
  const std::string bytes = Encode(scene);
  const auto back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(Encode(*back), bytes);
  EXPECT_EQ(back->glazing.glasses[0].optical_depth, scene.glazing.glasses[0].optical_depth);
  EXPECT_EQ(back->glazing.panes[0].corners, scene.glazing.panes[0].corners);
  Scene plain = scene;
  plain.glazing = {};
  const std::string rest = Encode(plain);
  EXPECT_EQ(rest, bytes.substr(0, rest.size()));
  for (size_t size = rest.size() + 1; size < bytes.size(); ++size) {
    EXPECT_FALSE(Decode(bytes.substr(0, size)).has_value()) << size;
  }
  for (const double wrong : {-1.0, 1e7, std::nan("")}) {
    Scene bad = scene;
    bad.glazing.glasses[0].optical_depth.y = wrong;
    EXPECT_FALSE(Validate(bad).ok()) << wrong;
    bad = scene;
    bad.glazing.glasses[0].index = wrong;
    EXPECT_FALSE(Validate(bad).ok()) << wrong;
  }
  Scene bad = scene;
  bad.glazing.panes[0].glass = 7;
  EXPECT_FALSE(Validate(bad).ok());
}

}  // namespace
}  // namespace isolux::testing
