// Whole solves whose solution is known exactly: a cube with a shining floor, discs by their
// integral equation, concentric spheres, an isothermal box, an overcast sky, a point light, and a
// medium between plates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "client/import/prepare.h"
#include "tests/support/dense_transport.h"
#include "tests/support/factor_scenes.h"
#include "tests/support/scenes.h"
#include "tests/support/shapes.h"
#include "tests/support/solve_scene.h"
#include "worker/radiosity/error_estimate.h"
#include "worker/radiosity/solver.h"

namespace isolux::testing {
namespace {

using std::numbers::pi;

struct Means {
  double radiosity = 0,
         corner_radiosity = 0;  // Σ A B / Σ A, of the faces' values and of their corners'
};

// Over the faces that `takes` takes.
template <typename Takes>
Means MeansOf(const PatchFile& patch, const Takes& takes) {
  Means sums;
  double area = 0;
  for (const PatchFace& face : patch.faces) {
    if (!takes(face)) continue;
    const size_t count = face.vertices.size();
    const auto corner = [&](size_t i) { return patch.vertices[face.vertices[i]]; };
    Vec3 normal(0.0);
    double mean = 0;
    for (size_t i = 0; i < count; ++i) {
      const Vec3 a = corner(i).position - corner(0).position;
      normal += 0.5 * glm::cross(a, corner((i + 1) % count).position - corner(0).position);
      mean += static_cast<double>(corner(i).radiosity[0]) / static_cast<double>(count);
    }
    const double weight = glm::length(normal);
    sums.radiosity += weight * face.radiosity[0];
    sums.corner_radiosity += weight * mean;
    area += weight;
  }
  return {sums.radiosity / area, sums.corner_radiosity / area};
}

template <typename Takes>
double MeanRadiosity(const PatchFile& patch, const Takes& takes) {
  return MeansOf(patch, takes).radiosity;
}

TEST(ExactSolves, ACubeOfSixElements) {
  GridBox box = MakeGridBox({1, 1, 1}, {1, 1, 1});
  box.leaves.reflectance.assign(6, Lanes{0.5, 0.5, 0.5, 0});
  box.leaves.exitance.assign(6, Lanes{});
  box.leaves.exitance[4] = Lanes{1, 1, 1, 0};
  DenseTransport transport(box.coupling_m2, box.leaves);
  NullExchange exchange;
  SolverOptions options;
  options.accuracy = 1e-13;
  const auto solved = Solve(SolverMethod::kConjugateGradients, transport, box.leaves,
                            std::vector<Lanes>(6), options, exchange);
  ASSERT_TRUE(solved.has_value());
  const double wall = 0.181836268946129;
  const double exact[] = {wall, wall, wall, wall, 1.09090909810770, 0.181745826107788};
  for (size_t i = 0; i < 6; ++i) {
    const double b = box.leaves.exitance[i][0] + 0.5 * solved->irradiance[i][0];
    EXPECT_NEAR(b, exact[i], 1e-12) << i;
  }
}

// The limit of refinement, to eight digits by Galerkin's method on grids up to 40 × 40 a side.
TEST(ExactSolves, ACubeWithAShiningFloor) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.5));
  faces.exitance[4] = Rgb(1);
  const Scene scene = BoxRoom(Vec3(1.0), faces);
  for (const double accuracy : {0.02, 0.005}) {
    const SolveResult result = SolveScene(scene, accuracy);
    double of_faces = 0, of_corners = 0, total = 0;  // in irradiance
    for (uint32_t face = 0; face < 6; ++face) {
      const double exitance = face == 4 ? 1 : 0;
      const double exact = face == 4 ? 1.10436162 : face == 5 ? 0.17121604 : 0.18110558;
      const Means found =
          MeansOf(result.patch, [&](const PatchFace& f) { return f.polygon == face; });
      of_faces += std::abs(found.radiosity - exact) / 0.5;
      of_corners += std::abs(found.corner_radiosity - exact) / 0.5;
      total += (exact - exitance) / 0.5;
    }
    std::printf("accuracy %g: means of faces %.2g off, of corners %.2g\n", accuracy,
                of_faces / total, of_corners / total);
    EXPECT_LT(of_faces / total, accuracy);
    EXPECT_LT(of_corners / total, 0.5 * accuracy);
  }
}

TEST(ExactSolves, AnIsothermalBox) {
  const double rho[] = {0.1, 0.3, 0.5, 0.7, 0.9, 0.99};
  BoxFaces faces;
  for (int k = 0; k < 6; ++k) {
    faces.reflectance[k] = Rgb(rho[k]);
    faces.exitance[k] = Rgb(1 - rho[k]);
  }
  const SolveResult result = SolveScene(BoxRoom({1, 2, 3}, faces), 0.02);
  double worst = 0;
  for (const PatchFace& face : result.patch.faces) {
    worst = std::max(worst, std::abs(static_cast<double>(face.radiosity[0]) - 1));
  }
  std::printf("B of %zu faces within %.2g of 1\n", result.patch.faces.size(), worst);
  EXPECT_LT(worst, 0.01);
}

// ---- discs

// Two coaxial discs of radius 1 at distance h that both emit 1: B(r) by B = 1 + ρ ∫ k(r, s) B(s)
// ds, k = 2 h² q s / (q² − 4 r² s²)^1.5, q = r² + s² + h², the integral over angles done; Gauss's
// rule.
class DiscRadiosity {
 public:
  DiscRadiosity(double reflectance, double h) : rho_(reflectance), h_(h) {
    MakeRule();
    b_.assign(kPoints, 1);
    for (int pass = 0; pass < 400; ++pass) {
      std::vector<double> next(kPoints);
      for (int i = 0; i < kPoints; ++i) next[i] = At(at_[i]);
      b_ = std::move(next);
    }
  }
  double At(double r) const {
    double sum = 0;
    for (int k = 0; k < kPoints; ++k) {
      const double s = at_[k], q = r * r + s * s + h_ * h_;
      sum += weight_[k] * 2 * h_ * h_ * q * s / std::pow(q * q - 4 * r * r * s * s, 1.5) * b_[k];
    }
    return 1 + rho_ * sum;
  }
  double Mean() const {
    double sum = 0;
    for (int k = 0; k < kPoints; ++k) sum += weight_[k] * 2 * at_[k] * b_[k];
    return sum;
  }

 private:
  static constexpr int kPoints = 40;
  // Of Gauss and Legendre over [0, 1].
  void MakeRule() {
    for (int k = 0; k < kPoints; ++k) {
      double x = std::cos(pi * (k + 0.75) / (kPoints + 0.5)), slope = 0;
      for (int step = 0; step < 20; ++step) {
        double before = 1, now = x;
        for (int n = 2; n <= kPoints; ++n) {
          before = std::exchange(now, ((2 * n - 1) * x * now - (n - 1) * before) / n);
        }
        slope = kPoints * (x * now - before) / (x * x - 1);
        x -= now / slope;
      }
      at_.push_back(0.5 + 0.5 * x);
      weight_.push_back(1 / ((1 - x * x) * slope * slope));
    }
  }

  double rho_, h_;
  std::vector<double> at_, weight_, b_;
};

Scene TwoDiscs(double reflectance, double h) {
  constexpr int kCorners = 48, kRings = 2;
  const double radius = RadiusOfEqualArea(kCorners);
  std::vector<ConvexPolygon> polygons = Disc(radius, 0, kCorners, kRings, true);
  for (const ConvexPolygon& part : Disc(radius, h, kCorners, kRings, false)) {
    polygons.push_back(part);
  }
  Scene scene = MakeScene(polygons);
  scene.materials = {{"disc", Rgb(reflectance), Rgb(1.0)}};
  for (Polygon& polygon : scene.polygons) polygon.sides |= kFrontEmits;
  return scene;
}

TEST(ExactSolves, TwoDiscs) {
  struct Known {
    double rho, h, mean, centre, rim;
    double within;  // of the mean, at 1 %: more than is stated where discs are bright and close
  };
  for (const Known& known :
       {Known{0.5, 1, 1.23773882592787, 1.31356864777925, 1.17094457188345, 0.002},
        Known{0.9, 0.5, 2.29722273517053, 2.85453781168328, 1.74826298719400, 0.025}}) {
    const DiscRadiosity exact(known.rho, known.h);
    EXPECT_NEAR(exact.Mean(), known.mean, 1e-12);
    EXPECT_NEAR(exact.At(0), known.centre, 1e-12);
    EXPECT_NEAR(exact.At(1), known.rim, 1e-12);
    const SolveResult result = SolveScene(TwoDiscs(known.rho, known.h), 0.01);
    const double mean = MeanRadiosity(result.patch, [](const PatchFace&) { return true; });
    double off = 0, most = 0;
    for (const PatchVertex& vertex : result.patch.vertices) {
      const double r = std::hypot(vertex.position.x, vertex.position.y);
      const double error = std::abs(vertex.radiosity[0] - exact.At(std::min(r, 1.0)));
      off += error / static_cast<double>(result.patch.vertices.size());
      most = std::max(most, error);
    }
    std::printf("rho %g: mean %.2g off, points %.2g off, at most %.2g; stated %.2g of irradiance\n",
                known.rho, std::abs(mean / known.mean - 1), off / known.mean, most / known.mean,
                result.summary.rounds.back().error_estimate);
    EXPECT_NEAR(mean, known.mean, 0.5 * known.within * known.mean);
    EXPECT_LT(off, known.within * known.mean);
    EXPECT_LT(most, 4 * known.within * known.mean);
  }
}

// Of few large polygons the solution comes from below, all of it in step, which no link sees of
// itself: how far the mean moves from round to round tells.
TEST(ExactSolves, TwoDiscsOfMergedPolygonsStateWhatIsToCome) {
  const DiscRadiosity exact(0.9, 0.5);
  Scene scene = TwoDiscs(0.9, 0.5);
  RepairLog log;
  PrepareForTransport(&scene, &log, [](uint32_t p) { return std::to_string(p); });
  for (const double accuracy : {0.01, 0.005}) {
    const SolveResult result = SolveScene(scene, accuracy);
    const double mean = MeanRadiosity(result.patch, [](const PatchFace&) { return true; });
    const double off = std::abs(mean - exact.Mean()) / (exact.Mean() - 1);  // of irradiance
    const double stated = result.summary.rounds.back().error_estimate;
    std::printf("%zu polygons, accuracy %g: mean irradiance %.2g off, stated %.2g\n",
                scene.polygons.size(), accuracy, off, stated);
    EXPECT_LT(off, stated);
    EXPECT_LT(stated, accuracy);
  }
}

TEST(ExactSolves, DriftToCome) {
  // Errors that go with the power 0.3 of the threshold: what is left over what has gone.
  for (const double coarser : {4.0, 16.0, 100.0}) {
    const double before = std::pow(coarser, 0.3), left = 1;
    EXPECT_NEAR(DriftToCome(coarser), left / (before - left), 1e-12) << coarser;
  }
  EXPECT_EQ(DriftToCome(1.1), 2);
  EXPECT_EQ(DriftToCome(1), 2);
  EXPECT_EQ(DriftToCome(0.5), 2);  // a threshold that rose
}

// ---- spheres

// B1 = E + ρ1 B2, B2 = ρ2 (F B1 + (1 − F) B2), F the ratio of the areas.
TEST(ExactSolves, ConcentricSpheres) {
  constexpr double kInner = 0.3, kOuter = 0.8;
  std::vector<ConvexPolygon> polygons = Sphere(1, 1, true);
  const auto inner = static_cast<uint32_t>(polygons.size());
  for (const ConvexPolygon& part : Sphere(2, 1, false)) polygons.push_back(part);
  Scene scene = MakeScene(polygons);
  scene.materials = {{"inner", Rgb(kInner), Rgb(1.0)}, {"outer", Rgb(kOuter), Rgb(0.0)}};
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    scene.polygons[p].material = p < inner ? 0 : 1;
    if (p < inner) scene.polygons[p].sides |= kFrontEmits;
  }
  const double f = 0.25;  // as of the spheres: both are the same shape
  // Of spheres: 1.17647058823529 and 0.588235294117647.
  const double share = kOuter * f / (1 - kOuter * (1 - f));
  const double exact_inner = 1 / (1 - kInner * share), exact_outer = share * exact_inner;
  EXPECT_NEAR(exact_inner, 1.17647058823529, 1e-12);
  EXPECT_NEAR(exact_outer, 0.588235294117647, 1e-12);
  const SolveResult result = SolveScene(scene, 0.02);
  const double b_inner =
      MeanRadiosity(result.patch, [&](const PatchFace& face) { return face.polygon < inner; });
  const double b_outer =
      MeanRadiosity(result.patch, [&](const PatchFace& face) { return face.polygon >= inner; });
  std::printf("inner %.5f, exact %.5f; outer %.5f, exact %.5f\n", b_inner, exact_inner, b_outer,
              exact_outer);
  EXPECT_NEAR(b_inner, exact_inner, 0.01 * exact_inner);
  EXPECT_NEAR(b_outer, exact_outer, 0.01 * exact_outer);
}

// ---- lights

Scene OneSquare(const std::vector<Vec3>& corners) {
  ConvexPolygon square{4, {corners[0], corners[1], corners[2], corners[3]}};
  Scene scene = MakeScene({square});
  scene.materials = {{"square", Rgb(0.5), Rgb(0.0)}};
  return scene;
}

double MeanIrradiance(const Scene& scene, double accuracy) {
  return MeanRadiosity(SolveScene(scene, accuracy).patch, [](const PatchFace&) { return true; }) /
         0.5;
}

// L = (1 + 2 sin h)/3 of the zenith's: 7π/9 on level ground, π/6 + 4/9 on a wall.
TEST(ExactSolves, AnOvercastSky) {
  Sky sky;
  sky.columns = 1;
  sky.rows = 512;
  sky.up = {0, 0, 1};
  sky.ahead = {1, 0, 0};
  for (uint32_t row = 0; row < sky.rows; ++row) {
    const double sine = 1 - (row + 0.5) * 2 / sky.rows;
    for (int c = 0; c < 3; ++c)
      sky.texels.push_back(static_cast<float>(sine > 0 ? (1 + 2 * sine) / 3 : 0));
  }
  Scene level = OneSquare({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  Scene upright = OneSquare({{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}});
  level.sky = upright.sky = sky;
  EXPECT_NEAR(MeanIrradiance(level, 0.02), 7 * pi / 9, 2e-3);
  EXPECT_NEAR(MeanIrradiance(upright, 0.02), pi / 6 + 4.0 / 9, 2e-3);
}

TEST(ExactSolves, APointOverASquare) {
  Scene scene = OneSquare({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  Light light;
  light.position_m = {0.5, 0.5, 2};
  light.intensity = Rgb(1.0);
  scene.lights = {light};
  const double quarter = std::atan2(0.25, 2 * std::sqrt(0.5 + 4));  // solid angle of a corner
  EXPECT_NEAR(4 * quarter, 0.235430023788325, 1e-12);
  EXPECT_NEAR(MeanIrradiance(scene, 0.01), 4 * quarter, 1e-3 * 4 * quarter);
}

// ---- a medium

// Plates without end are what mirrors all round make of two squares. A thin medium of optical
// thickness τ leaves 2 E3(τ) of what one sends the other: 0.980553128369330 at τ = 0.01.
TEST(ExactSolves, AThinMediumBetweenPlates) {
  BoxFaces faces;
  faces.exitance[4] = Rgb(1);
  Scene scene = BoxRoom({6, 6, 1}, faces);
  scene.materials.push_back({"mirror", Rgb(0.0), Rgb(0.0)});
  scene.materials.back().specular = 1;
  for (uint32_t p = 0; p < 4; ++p) scene.polygons[p].material = 6;
  scene.medium.extinction_per_m = {0.01, 0.01, 0.01};
  const RoundSummary round = SolveScene(scene, 0.02, "+medium").summary.rounds.back();
  const double taken = round.medium_w[0] / round.emitted_w[0];
  std::printf("taken %.5f, absorbed %.5f, imbalance %.2g\n", taken,
              round.absorbed_w[0] / round.emitted_w[0], round.energy_imbalance);
  EXPECT_NEAR(taken, 1 - 0.980553128369330, 0.05 * 0.0194);
}

}  // namespace
}  // namespace isolux::testing
