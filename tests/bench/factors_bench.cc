// Speed and accuracy of factors past obstacles. Prints CSV: benchmark,quantity,value,unit.
//
//   factors_bench [TOLERANCE [THREADS]]     default: 1e-4 on one thread and on two
//
// The room has 654 polygons, all rows of which add up to 1; pairs a second count all 213,531.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "tests/support/factor_scenes.h"
#include "worker/factors/factors.h"

namespace isolux {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Print(const std::string& quantity, double value, const char* unit) {
  std::printf("factors,%s,%.6g,%s\n", quantity.c_str(), value, unit);
}

void Run(const Scene& scene, double tolerance, int threads) {
  ThreadPool pool(threads);
  double best = 1e300;
  FactorTable table;
  for (int run = 0; run < 3; ++run) {
    const double start = Now();
    table = ComputeFactors(scene, {.tolerance = tolerance}, pool).value();
    best = std::min(best, Now() - start);
  }
  const auto n = static_cast<double>(table.ends.size());
  double worst = 0, worst_before = 0, squares = 0;
  for (const FactorEnd& end : table.ends) {
    worst = std::max(worst, std::abs(end.row_sum - 1));
    worst_before = std::max(worst_before, std::abs(end.row_sum_before - 1));
    squares += (end.row_sum_before - 1) * (end.row_sum_before - 1);
  }
  Print("tolerance", tolerance, "");
  Print("threads", threads, "");
  Print("polygons", n, "");
  Print("wall", best, "s");
  Print("pairs a second", 0.5 * n * (n - 1) / best, "1/s");
  for (int way = 0; way < kWayCount; ++way) {
    Print(std::string("pairs ") + ToText(static_cast<Way>(way)),
          static_cast<double>(table.pairs[way]), "");
  }
  Print("pairs stated above the tolerance", static_cast<double>(table.above_tolerance), "");
  Print("largest |row sum - 1| as integrated", worst_before, "");
  Print("root mean square of it", std::sqrt(squares / n), "");
  Print("largest |row sum - 1|", worst, "");
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  const isolux::Scene scene = isolux::testing::MakePanelledRoom({});
  const double tolerance = argc > 1 ? std::atof(argv[1]) : 1e-4;
  if (argc > 2) {
    isolux::Run(scene, tolerance, std::atoi(argv[2]));
    return 0;
  }
  for (const int threads : {1, 2}) isolux::Run(scene, tolerance, threads);
  return 0;
}
