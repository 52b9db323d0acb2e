// The methods of solver.h: over full matrices with known answers, and over links.
#include "worker/radiosity/solver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/util/random.h"
#include "tests/support/dense_transport.h"
#include "tests/support/link_bench.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

using testing::DenseTransport;
using testing::GridBox;
using testing::LinkBench;

constexpr SolverMethod kMethods[] = {SolverMethod::kConjugateGradients, SolverMethod::kJacobi,
                                     SolverMethod::kGaussSeidel, SolverMethod::kChebyshev,
                                     SolverMethod::kSouthwell};

std::vector<Lanes> Dark(size_t n) { return std::vector<Lanes>(n, Lanes{}); }

// Random reflectances and emissions, the channels unlike each other.
GridBox RandomBox(uint64_t seed, double most_reflectance) {
  GridBox box = testing::MakeGridBox({3, 2, 1}, {4, 3, 2});
  Random random(seed);
  for (size_t i = 0; i < box.leaves.size(); ++i) {
    const auto unit = [&] { return random.Unit(); };
    const double r = unit(), g = unit();
    box.leaves.reflectance[i] = most_reflectance * Lanes{r, g, unit(), 0};
    if (unit() < 0.2) box.leaves.exitance[i] = Lanes{unit(), 10 * unit(), 0.1 * unit(), 0};
  }
  return box;
}

// (I − ρF) B = E in one channel by Gaussian elimination.
std::vector<double> Eliminate(const GridBox& box, int c) {
  const size_t n = box.leaves.size(), width = n + 1;
  std::vector<double> matrix(n * width);
  const auto at = [&](size_t i, size_t j) -> double& { return matrix[i * width + j]; };
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j < n; ++j) {
      at(i, j) = (i == j ? 1.0 : 0.0) -
                 box.leaves.reflectance[i][c] * box.coupling_m2[i * n + j] / box.leaves.area_m2[i];
    }
    at(i, n) = box.leaves.exitance[i][c];
  }
  for (size_t k = 0; k < n; ++k) {  // diagonally dominant: no pivoting
    for (size_t i = k + 1; i < n; ++i) {
      const double factor = at(i, k) / at(k, k);
      if (factor == 0) continue;
      for (size_t j = k; j <= n; ++j) at(i, j) -= factor * at(k, j);
    }
  }
  std::vector<double> radiosity(n);
  for (size_t k = n; k-- > 0;) {
    double sum = at(k, n);
    for (size_t j = k + 1; j < n; ++j) sum -= at(k, j) * radiosity[j];
    radiosity[k] = sum / at(k, k);
  }
  return radiosity;
}

TEST(GridBox, HasRowsThatAddUpToTheirAreas) {
  const GridBox box = testing::MakeGridBox({2, 2, 10}, {3, 3, 6});
  const size_t n = box.leaves.size();
  for (size_t i = 0; i < n; ++i) {
    double row = 0;
    for (size_t k = 0; k < n; ++k) row += box.coupling_m2[i * n + k];
    EXPECT_NEAR(row / box.leaves.area_m2[i], 1, 1e-10);
  }
}

TEST(Solvers, AgreeWithElimination) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const GridBox box = RandomBox(seed, 0.9);
    for (const SolverMethod method : kMethods) {
      DenseTransport transport(box.coupling_m2, box.leaves);
      SolverOptions options;
      options.accuracy = 1e-8;
      NullExchange exchange;
      const auto solved =
          Solve(method, transport, box.leaves, Dark(box.leaves.size()), options, exchange);
      ASSERT_TRUE(solved.has_value());
      EXPECT_FALSE(solved->indefinite);
      EXPECT_GT(solved->largest_eigenvalue, 0.2) << ToText(method);
      for (int c = 0; c < 3; ++c) {
        const std::vector<double> truth = Eliminate(box, c);
        double error = 0, emitted = 0;
        for (size_t i = 0; i < truth.size(); ++i) {
          const double b =
              box.leaves.exitance[i][c] + box.leaves.reflectance[i][c] * solved->irradiance[i][c];
          error += box.leaves.area_m2[i] * std::abs(b - truth[i]);
          emitted += box.leaves.area_m2[i] * box.leaves.exitance[i][c];
        }
        // What the solver promises: residual/(1 − λ) ≤ accuracy/10.
        EXPECT_LE(error / emitted, 0.1 * options.accuracy)
            << ToText(method) << ", channel " << c << ", seed " << seed;
      }
    }
  }
}

TEST(Solvers, NeedAsManyProductsAsTheirSpectrumSays) {
  // Evenly reflecting closed box: λ = ρ. Jacobi gains ρ a step, Chebyshev ρ/(1 + √(1 − ρ²)).
  GridBox box = testing::MakeGridBox({1, 1, 1}, {4, 4, 4});
  box.leaves.reflectance.assign(box.leaves.size(), Lanes{0.9, 0.9, 0.9, 0});
  for (size_t i = 0; i < box.leaves.size(); ++i)
    if (box.face[i] == 4) box.leaves.exitance[i] = Lanes{1, 1, 1, 0};
  std::array<uint32_t, 5> products{};
  for (const SolverMethod method : kMethods) {
    DenseTransport transport(box.coupling_m2, box.leaves);
    SolverOptions options;
    options.accuracy = 1e-5;
    NullExchange exchange;
    const auto solved =
        Solve(method, transport, box.leaves, Dark(box.leaves.size()), options, exchange);
    ASSERT_TRUE(solved.has_value());
    EXPECT_LE(solved->residual / (1 - solved->largest_eigenvalue), 2e-6) << ToText(method);
    products[static_cast<int>(method)] = solved->products;
  }
  const auto of = [&](SolverMethod method) { return products[static_cast<int>(method)]; };
  EXPECT_LE(of(SolverMethod::kConjugateGradients), 14u);
  EXPECT_NEAR(of(SolverMethod::kJacobi), std::log(1e-7) / std::log(0.9), 30);
  EXPECT_NEAR(of(SolverMethod::kGaussSeidel), 0.5 * of(SolverMethod::kJacobi), 15);
  EXPECT_LE(of(SolverMethod::kChebyshev), 45u);
  EXPECT_LE(of(SolverMethod::kSouthwell), of(SolverMethod::kJacobi));
}

TEST(Solvers, TellWhereThereIsNoSolution) {
  for (const SolverMethod method : kMethods) {
    for (const double rho : {1.0, 1.2}) {
      GridBox box = testing::MakeGridBox({1, 1, 1}, {2, 2, 2});
      box.leaves.reflectance.assign(box.leaves.size(), Lanes{rho, 0.5, rho, 0});
      box.leaves.exitance[0] = Lanes{1, 1, 1, 0};
      DenseTransport transport(box.coupling_m2, box.leaves);
      NullExchange exchange;
      const auto solved =
          Solve(method, transport, box.leaves, Dark(box.leaves.size()), {}, exchange);
      ASSERT_TRUE(solved.has_value());
      EXPECT_TRUE(solved->indefinite) << ToText(method) << ", reflectance " << rho;
    }
  }
}

TEST(Solvers, EndWhenTheyAreTold) {
  const GridBox box = RandomBox(5, 0.9);
  for (const SolverMethod method : kMethods) {
    DenseTransport transport(box.coupling_m2, box.leaves);
    SolverOptions options;
    options.accuracy = 1e-9;
    uint32_t seen = 0;
    options.watch = [&](std::span<const Lanes> radiosity) {
      EXPECT_EQ(radiosity.size(), box.leaves.size());
      return ++seen == 3;
    };
    NullExchange exchange;
    const auto solved =
        Solve(method, transport, box.leaves, Dark(box.leaves.size()), options, exchange);
    ASSERT_TRUE(solved.has_value());
    EXPECT_EQ(solved->iterations, 3u) << ToText(method);
    EXPECT_GT(solved->residual, 0.0);
  }
}

TEST(LocalRows, SweepAndShotsBringWhatAProductBrings) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    LinkBench bench(testing::RandomRoom(seed, 3), 1e-2);
    const size_t n = bench.system.size();
    Random random(seed);
    for (double& d : bench.system.closure) d = 0.8 + 0.4 * random.Unit();
    LinkTransport transport(*bench.product, bench.system);
    const std::vector<Lanes> radiosity = bench.RandomValues(seed);
    std::vector<Lanes> whole(n), from_others(n), swept(n), shot(n, Lanes{});
    ASSERT_TRUE(transport.Irradiance(radiosity, Splat(1), whole).ok());
    ASSERT_TRUE(transport.IrradianceFromOthers(radiosity, Splat(1), from_others).ok());
    std::vector<Lanes> kept = radiosity;
    transport.Sweep(kept, from_others, [&](size_t i, const Lanes& irradiance) {
      swept[i] = irradiance;
      return radiosity[i];
    });
    for (size_t i = 0; i < n; ++i) transport.Shoot(i, radiosity[i], shot);
    for (size_t i = 0; i < n; ++i) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(shot[i][c] + from_others[i][c], whole[i][c], 1e-12) << "seed " << seed;
      }
    }
    // Sweeping what a sweep leaves alone: what each leaf sees is the product of what is there.
    for (size_t i = 0; i < n; ++i) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(swept[i][c], whole[i][c], 1e-12) << "seed " << seed;
    }
  }
}

TEST(Solvers, AgreeOverLinks) {
  LinkBench bench(testing::RandomRoom(4, 3), 1e-2);
  const size_t n = bench.system.size();
  std::vector<Lanes> first;
  for (const SolverMethod method : kMethods) {
    LinkTransport transport(*bench.product, bench.system);
    SolverOptions options;
    options.accuracy = 1e-7;
    const auto solved = Solve(method, transport, bench.system, Dark(n), options, bench.exchange);
    ASSERT_TRUE(solved.has_value());
    if (first.empty()) first = solved->irradiance;
    double difference = 0, power = 0;
    for (size_t i = 0; i < n; ++i) {
      const Lanes d = Absolute(solved->irradiance[i] - first[i]);
      difference += bench.system.area_m2[i] * (d[0] + d[1] + d[2]);
      power += bench.system.area_m2[i] * (first[i][0] + first[i][1] + first[i][2]);
    }
    EXPECT_LE(difference, 2e-8 * power) << ToText(method);
  }
}

TEST(SmallestEigenvalue, MatchesAKnownMatrix) {
  // Tridiagonal (−1, 2, −1) of order 10: 2 − 2 cos(π/11).
  const std::vector<double> diagonal(10, 2.0), off(9, -1.0);
  EXPECT_NEAR(SmallestEigenvalue(diagonal, off), 2 - 2 * std::cos(M_PI / 11), 1e-10);
}

}  // namespace
}  // namespace isolux
