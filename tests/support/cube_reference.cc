#include "tests/support/cube_reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "tests/support/dense_transport.h"
#include "tests/support/output_gather.h"
#include "tests/support/scenes.h"
#include "worker/coupling/point_factor.h"
#include "worker/radiosity/solver.h"
#include "worker/shard.h"

namespace isolux::testing {
namespace {

constexpr double kReflectance = 0.5;
constexpr int kFloor = 4;  // of the faces of a box
// Mean irradiances of the limit of mesh refinement; floor, ceiling, each wall.
constexpr double kFloorMean = 0.20872324, kCeilingMean = 0.34243208, kWallMean = 0.36221116;

double Radiosity(int face, double irradiance) {
  return (face == kFloor ? 1 : 0) + kReflectance * irradiance;
}

// 2 × 2, of equal weights.
std::array<Vec3, 4> GaussPoints(const std::array<Vec3, 4>& corners) {
  constexpr double kRoot = 0.57735026918962576451;  // √(1/3)
  const Vec3 centre = 0.5 * (corners[0] + corners[2]);
  std::array<Vec3, 4> points;
  for (int k = 0; k < 4; ++k) points[k] = centre + kRoot * (corners[k] - centre);
  return points;
}

std::vector<double> SolveEvenGrid(int n) {
  GridBox box = MakeGridBox({1, 1, 1}, {n, n, n});
  for (size_t i = 0; i < box.leaves.size(); ++i) {
    box.leaves.reflectance[i] = Lanes{kReflectance, 0, 0, 0};
    box.leaves.exitance[i] = Lanes{box.face[i] == kFloor ? 1.0 : 0.0, 0, 0, 0};
  }
  DenseTransport transport(box.coupling_m2, box.leaves);
  NullExchange exchange;
  SolverOptions options;
  options.accuracy = 1e-8;
  const auto solved = Solve(SolverMethod::kConjugateGradients, transport, box.leaves,
                            std::vector<Lanes>(box.leaves.size()), options, exchange);
  EXPECT_TRUE(solved.has_value());
  std::vector<double> radiosity;
  for (size_t i = 0; i < box.leaves.size(); ++i)
    radiosity.push_back(Radiosity(box.face[i], solved->irradiance[i][0]));
  return radiosity;
}

struct Points {
  std::vector<NodeId> elements;  // specks; at their first corners
  std::vector<double> irradiance;
};

// Uniform over the faces.
Points TruePoints(const Hierarchy& hierarchy, const CubeReference& reference) {
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

double ErrorAt(const GatherPart& part, const Points& points) {
  double difference = 0, sum = 0;
  for (size_t i = 0; i < points.elements.size(); ++i) {
    const double h = std::ldexp(static_cast<double>(part.sums[12 * i]), -part.exponent);
    difference += std::abs(h - points.irradiance[i]);
    sum += points.irradiance[i];
  }
  return difference / sum;
}

}  // namespace

CubeReference::CubeReference(const Grid& grid, ThreadPool& pool) {
  cells_ = MakeCells(grid.coarse, false);
  const std::vector<double> even = SolveEvenGrid(grid.coarse);
  for (size_t i = 0; i < cells_.size(); ++i) cells_[i].radiosity = even[i];
  // First from the coarse cells, then the fine ones from each other.
  for (int step = 0; step < grid.steps; ++step) {
    std::vector<Cell> next = MakeCells(grid.fine, grid.narrowing);
    pool.For(next.size(), 64, [&](size_t begin, size_t end, int) {
      for (size_t i = begin; i < end; ++i) {
        const Lanes arriving = IrradianceFrom(cells_, GaussPoints(next[i].corners), next[i].face);
        const double mean = 0.25 * (arriving[0] + arriving[1] + arriving[2] + arriving[3]);
        next[i].radiosity = Radiosity(next[i].face, mean);
      }
    });
    cells_ = std::move(next);
  }
}

Lanes CubeReference::IrradianceAt(const std::array<Vec3, 4>& points, int face) const {
  return IrradianceFrom(cells_, points, face);
}

double CubeReference::ErrorOfMeans() const {
  std::array<double, 6> mean{};
  for (const Cell& cell : cells_) {
    mean[cell.face] += cell.area * (cell.radiosity - Radiosity(cell.face, 0)) / kReflectance;
  }
  double worst = 0;
  for (int face = 0; face < 6; ++face) {
    const double exact = face == kFloor ? kFloorMean : face == 5 ? kCeilingMean : kWallMean;
    worst = std::max(worst, std::abs(mean[face] / exact - 1));
  }
  return worst;
}

// In the order of a GridBox.
std::vector<CubeReference::Cell> CubeReference::MakeCells(int n, bool narrowing) {
  std::vector<Cell> cells;
  const auto at = [&](int i) {
    const double share = static_cast<double>(i) / n;
    return narrowing ? 0.5 - 0.5 * std::cos(std::numbers::pi * share) : share;
  };
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, s = (axis + 1) % 3, t = (axis + 2) % 3;
    const auto corner = [&](int u, int v) {
      Vec3 p(0.0);
      p[axis] = face % 2;
      p[s] = at(u);
      p[t] = at(v);
      return p;
    };
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < n; ++k) {
        Cell cell;
        cell.face = face;
        cell.corners = {corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)};
        cell.area = (at(i + 1) - at(i)) * (at(k + 1) - at(k));
        if (face % 2 == 1) std::reverse(cell.corners.begin(), cell.corners.end());
        cells.push_back(cell);
      }
    }
  }
  return cells;
}

Lanes CubeReference::IrradianceFrom(const std::vector<Cell>& cells,
                                    const std::array<Vec3, 4>& points, int face) {
  Vec3 normal(0.0);
  normal[face / 2] = face % 2 == 0 ? 1 : -1;
  const Vec3x4 lanes(points);
  Lanes sum{};
  for (const Cell& cell : cells) {
    if (cell.face != face) sum += cell.radiosity * PointFormFactors(lanes, normal, cell.corners);
  }
  return sum;
}

void SolveCube(const CubeReference& reference, double most_links,
               const std::function<void(const CubeRound&)>& after_round) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(kReflectance));
  faces.exitance[kFloor] = Rgb(1);
  const auto scene = std::make_shared<const Scene>(BoxRoom(Vec3(1.0), faces));
  const Hierarchy hierarchy(*scene);
  const Points points = TruePoints(hierarchy, reference);
  ThreadPool pool(2);
  Shard shard(scene, &pool);
  SolveOptions options;
  options.accuracy = 0.001;
  ASSERT_TRUE(shard.Start(options, {{{NodeId::kCluster, 0}}, {0}, 1}, 0).ok());
  NullExchange exchange;
  double epsilon = 0.04 * Sum(shard.EmittedPower());
  CubeRound round;
  while (round.links < most_links) {
    const auto report = shard.RunRound(epsilon, options.accuracy, exchange);
    ASSERT_TRUE(report.has_value());
    const Snapshot snapshot = shard.TakeSnapshot();
    ASSERT_TRUE(shard.InstallSnapshot(snapshot).ok());
    const auto part =
        GatherOutput(shard, hierarchy, snapshot, points.elements, {}, options.accuracy);
    ASSERT_TRUE(part.has_value());
    round = {static_cast<double>(report->links), ErrorAt(*part, points), report->error_estimate};
    after_round(round);
    epsilon /= 2;
  }
}

double AllowedInCube(double links) { return 0.025 * std::pow(links / 100, -std::log10(2)); }

}  // namespace isolux::testing
