// Error of the gathered irradiance against the number of links, in a unit cube whose floor emits:
// no shadows, so what is left is transport and gather alone.
#include <gtest/gtest.h>

#include <cmath>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "tests/support/dense_transport.h"
#include "tests/support/output_gather.h"
#include "tests/support/scenes.h"
#include "worker/coupling/point_factor.h"
#include "worker/radiosity/solver.h"
#include "worker/shard.h"

namespace isolux {
namespace {

constexpr double kReflectance = 0.5;
constexpr int kFloor = 4;  // of the faces of a box
// Mean irradiances of the limit of mesh refinement; floor, ceiling, each wall.
constexpr double kFloorMean = 0.20872324, kCeilingMean = 0.34243208, kWallMean = 0.36221116;

// Square cells of the faces, seen from inside, with what each radiates.
class Cells {
 public:
  explicit Cells(int n) : n_(n) {
    for (int face = 0; face < 6; ++face) {
      for (int i = 0; i < n; ++i) {
        for (int k = 0; k < n; ++k) Add(face, i, k);
      }
    }
  }

  size_t size() const { return quads_.size(); }
  int FaceOf(size_t cell) const { return static_cast<int>(cell) / (n_ * n_); }
  // 2 × 2, of equal weights.
  std::array<Vec3, 4> GaussPointsOf(size_t cell) const {
    constexpr double kRoot = 0.57735026918962576451;  // √(1/3)
    const Vec3 centre = 0.5 * (quads_[cell][0] + quads_[cell][2]);
    std::array<Vec3, 4> points;
    for (int k = 0; k < 4; ++k) points[k] = centre + kRoot * (quads_[cell][k] - centre);
    return points;
  }

  // Irradiance at four points of one face.
  Lanes IrradianceAt(const std::array<Vec3, 4>& points, int face) const {
    Vec3 normal(0.0);
    normal[face / 2] = face % 2 == 0 ? 1 : -1;
    const Vec3x4 lanes(points);
    Lanes sum{};
    for (size_t i = 0; i < size(); ++i) {
      if (FaceOf(i) != face) sum += radiosity[i] * PointFormFactors(lanes, normal, quads_[i]);
    }
    return sum;
  }

  std::vector<double> radiosity;

 private:
  void Add(int face, int i, int k) {
    const int axis = face / 2, s = (axis + 1) % 3, t = (axis + 2) % 3;
    const auto corner = [&](int u, int v) {
      Vec3 p(0.0);
      p[axis] = face % 2;
      p[s] = static_cast<double>(u) / n_;
      p[t] = static_cast<double>(v) / n_;
      return p;
    };
    std::array<Vec3, 4> quad = {corner(i, k), corner(i + 1, k), corner(i + 1, k + 1),
                                corner(i, k + 1)};
    if (face % 2 == 1) std::reverse(quad.begin(), quad.end());
    quads_.push_back(quad);
    radiosity.push_back(0);
  }

  int n_;
  std::vector<std::array<Vec3, 4>> quads_;
};

double Radiosity(int face, double irradiance) {
  return (face == kFloor ? 1 : 0) + kReflectance * irradiance;
}

// The solution on an even grid with exact couplings, gathered over a grid twice as fine, to be
// gathered once more at the points: each step smooths what constants err by.
Cells MakeReference() {
  constexpr int kCoarse = 16, kFine = 32;
  testing::GridBox box = testing::MakeGridBox({1, 1, 1}, {kCoarse, kCoarse, kCoarse});
  for (size_t i = 0; i < box.leaves.size(); ++i) {
    box.leaves.reflectance[i] = Lanes{kReflectance, 0, 0, 0};
    box.leaves.exitance[i] = Lanes{box.face[i] == kFloor ? 1.0 : 0.0, 0, 0, 0};
  }
  testing::DenseTransport transport(box.coupling_m2, box.leaves);
  NullExchange exchange;
  SolverOptions options;
  options.accuracy = 1e-8;
  const auto solved = Solve(SolverMethod::kConjugateGradients, transport, box.leaves,
                            std::vector<Lanes>(box.leaves.size()), options, exchange);
  EXPECT_TRUE(solved.has_value());
  Cells coarse(kCoarse), fine(kFine);
  for (size_t i = 0; i < coarse.size(); ++i)
    coarse.radiosity[i] = Radiosity(coarse.FaceOf(i), solved->irradiance[i][0]);
  // First from the coarse cells, then the fine ones from each other.
  const Cells* from = &coarse;
  for (int step = 0; step < 2; ++step) {
    std::vector<double> next;
    for (size_t i = 0; i < fine.size(); ++i) {
      const Lanes arriving = from->IrradianceAt(fine.GaussPointsOf(i), fine.FaceOf(i));
      const double mean = 0.25 * (arriving[0] + arriving[1] + arriving[2] + arriving[3]);
      next.push_back(Radiosity(fine.FaceOf(i), mean));
    }
    fine.radiosity = std::move(next);
    from = &fine;
  }
  return fine;
}

const Cells& Reference() {
  static const Cells reference = MakeReference();
  return reference;
}

struct Points {
  std::vector<NodeId> elements;  // specks; at their first corners
  std::vector<double> irradiance;
};

// Uniform over the faces.
Points TruePoints(const Hierarchy& hierarchy, const Cells& reference) {
  Points points;
  Random random(11);
  for (uint32_t s = 0; s < 6; ++s) {
    for (int i = 0; i < 100; ++i) points.elements.push_back({s, 1ULL << 40 | random.Bits() >> 24});
  }
  std::sort(points.elements.begin(), points.elements.end());
  for (size_t i = 0; i < points.elements.size(); i += 4) {
    std::array<Vec3, 4> at;
    const uint32_t surface = points.elements[i].surface;
    for (int k = 0; k < 4; ++k)
      at[k] = ElementGeometry(hierarchy.geometry(surface), points.elements[i + k].path).v[0];
    const auto face = static_cast<int>(hierarchy.surfaces()[surface].polygon);
    const Lanes arriving = reference.IrradianceAt(at, face);
    for (int k = 0; k < 4; ++k) points.irradiance.push_back(arriving[k]);
  }
  return points;
}

double ErrorOf(const GatherPart& part, const Points& points) {
  double difference = 0, sum = 0;
  for (size_t i = 0; i < points.elements.size(); ++i) {
    const double h = std::ldexp(static_cast<double>(part.sums[12 * i]), -part.exponent);
    difference += std::abs(h - points.irradiance[i]);
    sum += points.irradiance[i];
  }
  return difference / sum;
}

// What is asked of the error at so many links: the straight line, on logarithmic axes, through
// 2.5 % at 100 and halving with every factor of ten.
double Allowed(double links) { return 0.025 * std::pow(links / 100, -std::log10(2)); }

TEST(CubeConvergence, ReferenceHasTheExactMeans) {
  const Cells& reference = Reference();
  std::array<double, 6> mean{};
  for (size_t i = 0; i < reference.size(); ++i) {
    const int face = reference.FaceOf(i);
    mean[face] += (reference.radiosity[i] - (face == kFloor ? 1 : 0)) / kReflectance;
  }
  for (int face = 0; face < 6; ++face) {
    const double exact = face == kFloor ? kFloorMean : face == 5 ? kCeilingMean : kWallMean;
    EXPECT_NEAR(mean[face] / (static_cast<double>(reference.size()) / 6), exact, 1e-3 * exact);
  }
}

TEST(CubeConvergence, ErrorFallsWithTheLinks) {
  testing::BoxFaces faces;
  faces.reflectance.fill(Rgb(kReflectance));
  faces.exitance[kFloor] = Rgb(1);
  const auto scene = std::make_shared<const Scene>(testing::BoxRoom(Vec3(1.0), faces));
  const Hierarchy hierarchy(*scene);
  const Points points = TruePoints(hierarchy, Reference());
  ThreadPool pool(2);
  Shard shard(scene, &pool);
  SolveOptions options;
  options.accuracy = 0.001;
  ASSERT_TRUE(shard.Start(options, {{{NodeId::kCluster, 0}}, {0}, 1}, 0).ok());
  NullExchange exchange;
  double epsilon = 0.04 * Sum(shard.EmittedPower());
  double first_links = 0, first_error = 0, links = 0, error = 0;
  while (links < 20'000) {
    const auto report = shard.RunRound(epsilon, options.accuracy, exchange);
    ASSERT_TRUE(report.has_value());
    const Snapshot snapshot = shard.TakeSnapshot();
    ASSERT_TRUE(shard.InstallSnapshot(snapshot).ok());
    const auto part =
        testing::GatherOutput(shard, hierarchy, snapshot, points.elements, {}, options.accuracy);
    ASSERT_TRUE(part.has_value());
    links = static_cast<double>(report->links);
    error = ErrorOf(*part, points);
    std::printf("%7.0f links: error %.3f %%, allowed %.3f %%, estimate %.3f %%\n", links,
                100 * error, 100 * Allowed(links), 100 * report->error_estimate);
    if (links >= 100) {
      if (first_links == 0) first_links = links, first_error = error;
      EXPECT_LE(error, Allowed(links)) << links << " links";
      EXPECT_GT(report->error_estimate, 0.5 * error) << links << " links";
      EXPECT_LT(report->error_estimate, 10 * error) << links << " links";
    }
    epsilon /= 2;
  }
  const double exponent = std::log(first_error / error) / std::log(links / first_links);
  std::printf("error falls like links^-%.2f\n", exponent);
  EXPECT_GT(exponent, 0.1);
}

}  // namespace
}  // namespace isolux
