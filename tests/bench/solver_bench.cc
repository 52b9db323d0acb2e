// Carter's comparison of solvers [Carter93]: boxes of about 1,000 patches at average reflectances
// of .4 to .9, by Jacobi, Gauss–Seidel, shooting (Southwell) and conjugate gradients, here with
// Chebyshev beside them, over a full matrix of exact couplings, until four decimals are right.
//
//   solver_bench            CSV: a row a box, reflectance and solver
//   solver_bench markdown   the table of docs/results.md
//
// One face emits; every patch has a random reflectance about the mean. Four decimals are right when
// no radiosity is off by more than 5e-5 of the largest, measured against conjugate gradients run to
// 1e-13. Operations are multiply-adds of couplings (one channel), and in shooting also those by
// which the next patch is chosen. Seconds are CPU time, the least of three runs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "common/util/parallel.h"
#include "common/util/random.h"
#include "tests/support/dense_transport.h"
#include "worker/radiosity/solver.h"

namespace isolux {
namespace {

constexpr uint64_t kSeed = 1993;
constexpr double kFourDecimals = 5e-5;
constexpr int kRuns = 3;

struct Box {
  const char* name;
  std::array<double, 3> size_m;
  std::array<int, 3> cells;
};

constexpr Box kBoxes[] = {{"10 x 10 x 10", {10, 10, 10}, {13, 13, 13}},
                          {"13.5 x 9 x 8", {13.5, 9, 8}, {17, 12, 10}},
                          {"2 x 2 x 10", {2, 2, 10}, {7, 7, 34}}};
constexpr double kReflectances[] = {0.4, 0.55, 0.7, 0.9};
constexpr SolverMethod kMethods[] = {SolverMethod::kConjugateGradients, SolverMethod::kJacobi,
                                     SolverMethod::kGaussSeidel, SolverMethod::kSouthwell,
                                     SolverMethod::kChebyshev};

struct Run {
  uint32_t iterations = 0;
  double operations = 0;
  double cpu_s = 0;
};

std::vector<Lanes> Dark(size_t n) { return std::vector<Lanes>(n, Lanes{}); }

// Reflectances spread evenly over as far about the mean as 0 and 1 allow, half of it at most.
void Paint(double mean, testing::GridBox* box) {
  Random random(kSeed);
  const double reach = std::min(0.5 * mean, 0.95 * (1 - mean));
  for (size_t i = 0; i < box->leaves.size(); ++i) {
    const double rho = mean + reach * (2 * random.Unit() - 1);
    box->leaves.reflectance[i] = Lanes{rho, 0, 0, 0};
    box->leaves.exitance[i] = Lanes{box->face[i] == 5 ? 1.0 : 0.0, 0, 0, 0};
  }
}

double MeanReflectance(const LeafSystem& leaves) {
  double sum = 0, area = 0;
  for (size_t i = 0; i < leaves.size(); ++i) {
    sum += leaves.area_m2[i] * leaves.reflectance[i][0];
    area += leaves.area_m2[i];
  }
  return sum / area;
}

std::vector<double> Truth(const testing::GridBox& box) {
  testing::DenseTransport transport(box.coupling_m2, box.leaves);
  NullExchange exchange;
  SolverOptions options;
  options.accuracy = 1e-12;
  const auto solved = Solve(SolverMethod::kConjugateGradients, transport, box.leaves,
                            Dark(box.leaves.size()), options, exchange);
  std::vector<double> radiosity;
  for (size_t i = 0; i < box.leaves.size(); ++i)
    radiosity.push_back(box.leaves.exitance[i][0] +
                        box.leaves.reflectance[i][0] * solved.value().irradiance[i][0]);
  return radiosity;
}

Run Measure(SolverMethod method, const testing::GridBox& box, const std::vector<double>& truth) {
  testing::DenseTransport transport(box.coupling_m2, box.leaves);
  NullExchange exchange;
  SolverOptions options;
  options.accuracy = 1e-12;  // not what ends it
  options.max_products = 10'000;
  const double largest = *std::max_element(truth.begin(), truth.end());
  Run run;
  const double start = ThreadCpuSeconds();
  options.watch = [&](std::span<const Lanes> radiosity) {
    double worst = 0;
    for (size_t i = 0; i < truth.size(); ++i)
      worst = std::max(worst, std::abs(radiosity[i][0] - truth[i]));
    if (worst > kFourDecimals * largest) return false;
    run.cpu_s = ThreadCpuSeconds() - start;
    run.operations = static_cast<double>(transport.multiply_adds());
    return true;
  };
  const auto solved =
      Solve(method, transport, box.leaves, Dark(box.leaves.size()), options, exchange);
  if (!solved || run.operations == 0) {
    std::fprintf(stderr, "solver_bench: %s did not get there\n", ToText(method));
    std::exit(1);
  }
  run.iterations = solved->iterations;
  return run;
}

Run LeastOf(SolverMethod method, const testing::GridBox& box, const std::vector<double>& truth) {
  Run least = Measure(method, box, truth);
  for (int k = 1; k < kRuns; ++k) {
    least.cpu_s = std::min(least.cpu_s, Measure(method, box, truth).cpu_s);
  }
  return least;
}

void PrintCsv(const Box& box, size_t patches, double rho, const std::vector<Run>& runs) {
  for (size_t m = 0; m < runs.size(); ++m) {
    std::printf("%s,%zu,%.4f,%s,%u,%.0f,%.5f\n", box.name, patches, rho, ToText(kMethods[m]),
                runs[m].iterations, runs[m].operations, runs[m].cpu_s);
  }
}

// Operations and seconds over those of conjugate gradients, which come first.
void PrintMarkdown(const Box& box, size_t patches, double rho, const std::vector<Run>& runs) {
  std::printf("| %s | %zu | %.2f |", box.name, patches, rho);
  for (const Run& run : runs) std::printf(" %u", run.iterations);
  std::printf(" | %.1f |", 1e-6 * runs[0].operations);
  for (size_t m = 1; m < runs.size(); ++m)
    std::printf(" %.1f", runs[m].operations / runs[0].operations);
  std::printf(" |");
  for (size_t m = 1; m < runs.size(); ++m) std::printf(" %.1f", runs[m].cpu_s / runs[0].cpu_s);
  std::printf(" |\n");
}

int Main(int argc, char** argv) {
  const bool markdown = argc > 1 && std::strcmp(argv[1], "markdown") == 0;
  if (argc > 1 && !markdown) {
    std::fprintf(stderr, "usage: solver_bench [markdown]\n");
    return 2;
  }
  if (markdown) {
    std::printf(
        "| box | patches | mean ρ | iterations C J G S Ch | million multiply-adds, C | "
        "multiply-adds "
        "over C's: J G S Ch | CPU time over C's: J G S Ch |\n|---|---|---|---|---|---|---|\n");
  } else {
    std::printf("box,patches,reflectance,solver,iterations,multiply_adds,cpu_s\n");
  }
  for (const Box& b : kBoxes) {
    testing::GridBox box = testing::MakeGridBox(b.size_m, b.cells);
    for (const double mean : kReflectances) {
      Paint(mean, &box);
      const std::vector<double> truth = Truth(box);
      std::vector<Run> runs;
      for (const SolverMethod method : kMethods) runs.push_back(LeastOf(method, box, truth));
      (markdown ? PrintMarkdown : PrintCsv)(b, truth.size(), MeanReflectance(box.leaves), runs);
      std::fflush(stdout);
    }
  }
  return 0;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) { return isolux::Main(argc, argv); }
