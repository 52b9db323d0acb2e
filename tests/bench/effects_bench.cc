// What effects that are off save: the product of one channel against that of three, over the same
// links, in one run; and what a link and an element take.
//
//   effects_bench        a line a scene: links, elements, CPU nanoseconds a link and product (the
//                        least of several runs), their ratio, bytes a link
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <span>
#include <utility>
#include <vector>

#include "tests/support/link_bench.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Of one product.
template <typename V>
double ProductSeconds(testing::LinkBench& bench, std::span<const V> radiosity,
                      std::span<V> irradiance) {
  const double start = CpuSeconds();
  EXPECT_TRUE(bench.product->Irradiance(radiosity, V{} + 1.0, irradiance).ok());
  return CpuSeconds() - start;
}

// Of three channels and of one, in turns; of each the least of several.
std::pair<double, double> LeastSeconds(testing::LinkBench& bench) {
  constexpr int kRuns = 60;
  const std::vector<Lanes> three = bench.RandomValues(1);
  std::vector<Single> one;
  one.reserve(three.size());
  for (const Lanes& v : three) one.push_back(Single{v[0]});
  std::vector<Lanes> to_three(three.size());
  std::vector<Single> to_one(one.size());
  std::pair<double, double> least{HUGE_VAL, HUGE_VAL};
  for (int run = 0; run < kRuns; ++run) {
    least.first = std::min(least.first, ProductSeconds<Lanes>(bench, three, to_three));
    least.second = std::min(least.second, ProductSeconds<Single>(bench, one, to_one));
  }
  return least;
}

void Measure(const char* name, Scene scene, double share) {
  testing::LinkBench bench(std::move(scene), share, 1);
  const auto links = static_cast<double>(bench.links.own.size());
  const auto [three, one] = LeastSeconds(bench);
  std::printf(
      "%-24s %9.0f links %8zu elements  three %6.2f  one %6.2f ns a link  ratio %.2f  rays %llu\n",
      name, links, bench.system.size(), 1e9 * three / links, 1e9 * one / links, three / one,
      static_cast<unsigned long long>(bench.counters.rays));
}

}  // namespace
}  // namespace isolux

int main() {
  using isolux::Measure;
  for (const double share : {1e-4, 1e-5, 2e-6}) {
    Measure("grey box", isolux::testing::FurnaceCube(0.5, 1), share);
    Measure("Cornell box", isolux::testing::CornellBox(true), share);
  }
  return 0;
}
