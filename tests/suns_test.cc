// Suns whose disc shows: the irradiance of points in a penumbra against its closed form, at the
// accuracy asked for, and what it takes in rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/same_bits.h"
#include "tests/support/solve_scene.h"

namespace isolux::testing {
namespace {

using std::numbers::pi;

// A floor of 4 m by 4 m, 1 m above its left half and far beyond a card that ends over x = 0, and a
// sun of 10° or so.
Scene HalfPlane(const Vec3& direction, double radius) {
  Scene scene;
  scene.materials = {{"black", Rgb(0.0), Rgb(0.0)}};
  scene.vertices = {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0},
                    {-8, -9, 1}, {0, -9, 1}, {0, 9, 1}, {-8, 9, 1}};
  scene.polygons = {{.vertices = {0, 1, 2, 3}, .sides = kFrontTakesPart},
                    {.vertices = {4, 5, 6, 7}, .sides = kFrontTakesPart}};
  scene.file_polygon_count = 2;
  Light sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = glm::normalize(direction);
  sun.intensity = Rgb(800.0, 400.0, 200.0);
  sun.disc_radius = std::tan(radius);
  scene.lights = {sun};
  return scene;
}

// Irradiance of a horizontal surface, over that of one across the sun, from the part of an even
// disc that lies beyond the edge: by Lambert's integral along the part's outline, which is an arc
// of the disc's rim and one of the great circle that the edge stands for.
double BeyondEdge(const Vec3& point, const Vec3& axis, double radius) {
  const Vec3 beyond = glm::normalize(Vec3(1 - point.z, 0, point.x));  // across edge and point
  const Vec3 across = beyond - glm::dot(beyond, axis) * axis;
  const double q = glm::length(across), sine = std::sin(radius), cosine = std::cos(radius);
  const double k = -cosine * glm::dot(beyond, axis) / (sine * q);
  if (k <= -1) return axis.z;
  if (k >= 1) return 0;
  const Vec3 s = across / q, t = glm::cross(axis, s);
  const double phi = std::acos(k);
  const auto rim = [&](double angle) {
    return cosine * axis + sine * (std::cos(angle) * s + std::sin(angle) * t);
  };
  const Vec3 chord = glm::cross(rim(phi), rim(-phi));
  const double arc = std::atan2(glm::length(chord), glm::dot(rim(phi), rim(-phi)));
  const Vec3 outline = 2 * phi * sine * sine * axis - 2 * cosine * sine * std::sin(phi) * s +
                       arc / glm::length(chord) * chord;
  return outline.z / (2 * pi * sine * sine);
}

TEST(Suns, TheClosedFormIsThatOfTheDisc) {
  const Vec3 axis = glm::normalize(Vec3(0.9, -0.3, 0.6));
  const double radius = 5 * pi / 180;
  const Vec3 s = glm::normalize(glm::cross(axis, Vec3(0, 0, 1))), t = glm::cross(axis, s);
  for (const double x : {-1.45, -1.5, -1.55, -1.4}) {
    double sum = 0;
    constexpr int kSide = 1000;
    for (int i = 0; i < kSide * kSide; ++i) {
      const double u = 2 * (i % kSide + 0.5) / kSide - 1, v = 2 * (i / kSide + 0.5) / kSide - 1;
      if (u * u + v * v > 1) continue;
      const Vec3 p = std::sin(radius) * (u * s + v * t);
      const Vec3 to = std::sqrt(1 - glm::dot(p, p)) * axis + p;
      if (x + to.x / to.z > 0) sum += to.z / glm::dot(to, axis);
    }
    EXPECT_NEAR(BeyondEdge({x, 0, 0}, axis, radius), sum * 4 / (pi * kSide * kSide), 2e-4) << x;
  }
}

struct Penumbra {
  int points = 0;
  double square = 0, mean = 0, largest = 0;  // what is off, over the unhidden irradiance
};

// Of the floor's output points.
Penumbra OffInPenumbra(const SolveResult& result, const Scene& scene) {
  const Light& sun = scene.lights[0];
  const double open = -sun.direction.z;
  Penumbra sum;
  for (const PatchVertex& vertex : result.patch.vertices) {
    if (vertex.position.z > 0.5) continue;
    const double expected = BeyondEdge(vertex.position, -sun.direction, std::atan(sun.disc_radius));
    const double off = vertex.irradiance[0] / 800 - expected;
    if (expected <= 0 || expected >= open) {
      EXPECT_NEAR(off, 0, 1e-6 * open);
      continue;
    }
    EXPECT_NEAR(vertex.irradiance[2], 0.25 * vertex.irradiance[0], 1e-3);
    ++sum.points;
    sum.mean += off / open;
    sum.square += off * off / (open * open);
    sum.largest = std::max(sum.largest, std::abs(off) / open);
  }
  sum.mean /= sum.points;
  sum.square = std::sqrt(sum.square / sum.points);
  return sum;
}

void ExpectAsAccurateAsAsked(const Scene& scene, double accuracy) {
  SolveOptions options = ToAccuracy(accuracy);
  options.epsilons = {20};
  const SolveResult result = SolveScene(scene, options);
  const Penumbra off = OffInPenumbra(result, scene);
  ASSERT_GT(off.points, 1000);
  EXPECT_LT(off.square, accuracy / 3);
  EXPECT_GT(off.square, accuracy / 10);  // no rays are wasted
  // Three deviations are to be below the accuracy; of thousands of points one is four off.
  EXPECT_LT(off.largest, 4.0 / 3 * accuracy);
  // More than by chance alone at 1 %: 7e-5, of which the cause is not known.
  EXPECT_LT(std::abs(off.mean), accuracy / 50);
}

TEST(Suns, PointsInAPenumbraAreAsAccurateAsAsked) {
  const double radius = 5 * pi / 180;
  for (const double accuracy : {0.1, 0.03, 0.01}) {
    ExpectAsAccurateAsAsked(HalfPlane({0.9, -0.3, -0.6}, radius), accuracy);
  }
  ExpectAsAccurateAsAsked(HalfPlane({0, 0, -1}, radius), 0.02);
}

TEST(Suns, PenumbrasKeepTheBits) {
  Scene scene = HalfPlane({0.9, -0.3, -0.6}, 5 * pi / 180);
  scene.materials[0].reflectance = Rgb(0.5);
  SolveOptions options = ToAccuracy(0.02);
  options.epsilons = {50};
  SolveToSameBits(scene, options);
}

}  // namespace
}  // namespace isolux::testing
