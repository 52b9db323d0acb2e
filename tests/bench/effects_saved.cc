// What leaving out effects saves, as a table in Markdown: three scenes, each solved by two workers
// in this process with --effects auto and all, in turns; of times the medians.
//
//   effects_saved [RUNS] > table.md      (7 runs of each where it is not given)
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <vector>

#include "client/output/comparison.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "tests/support/textured_room.h"

namespace isolux::testing {
namespace {

constexpr double kAccuracy = 0.02;
constexpr std::array<const char*, 2> kChoices = {"auto", "all"};

// All runs with one choice.
struct Runs {
  std::vector<double> wall_s, cpu_s;
  Traffic traffic;                    // of the last
  std::optional<SolveResult> result;  // likewise
};

uint64_t BytesIn(const Traffic& traffic) {
  return traffic.Total(Phase::kValues).in + traffic.Total(Phase::kSums).in;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

void Run(const Scene& scene, const char* effects, Runs* runs) {
  SolveOptions options;
  options.accuracy = kAccuracy;
  options.effects = effects;
  LocalCluster cluster(2, 1);
  runs->traffic = {};
  const std::clock_t start = std::clock();  // of the process
  auto result = RunJob(cluster, MakeJobInput(scene, options), {}, &runs->traffic);
  if (!result) {
    std::fprintf(stderr, "%s: %s\n", effects, result.error().message().c_str());
    std::exit(1);
  }
  runs->cpu_s.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  runs->wall_s.push_back(result->summary.seconds);
  runs->result = *std::move(result);
}

// How far the two are from each other, over the mean irradiance.
double Difference(const std::array<Runs, 2>& of) {
  return Compare(of[0].result->patch, of[1].result->patch, {}).value().l1_relative;
}

void Rows(const char* name, const Scene& scene, int runs) {
  std::array<Runs, 2> of;
  for (int run = 0; run < runs; ++run) {
    for (size_t i = 0; i < 2; ++i) {
      const size_t choice = (i + static_cast<size_t>(run)) % 2;  // each first in every other turn
      Run(scene, kChoices[choice], &of[choice]);
    }
  }
  for (size_t i = 0; i < 2; ++i) {
    const SolveSummary& summary = of[i].result->summary;
    const RoundSummary& last = summary.rounds.back();
    const auto per = [&](uint64_t count) {
      return static_cast<double>(last.memory_bytes) / static_cast<double>(count);
    };
    std::puts(fmt::format(
                  "| {} | {} | {:.3f} | {:.3f} | {} | {} | {} | {:.0f} | {:.0f} | {} | {} |", name,
                  kChoices[i], Median(of[i].cpu_s), Median(of[i].wall_s), last.links, last.elements,
                  summary.rays, per(last.links), per(last.elements), BytesIn(of[i].traffic),
                  i == 0 ? fmt::format("{:.2g} %", 100 * Difference(of)) : "")
                  .c_str());
  }
}

}  // namespace
}  // namespace isolux::testing

int main(int argc, char** argv) {
  using namespace isolux;  // NOLINT
  const int runs = argc > 1 ? std::max(1, std::atoi(argv[1])) : 7;
  std::puts(
      "| scene | effects | CPU seconds | seconds | links | elements | rays | bytes a link | "
      "bytes an element | bytes of values and sums, in | auto from all |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|");
  testing::Rows("grey convex box", testing::FurnaceCube(0.5, 1), runs);
  testing::Rows("Cornell box, coloured", testing::CornellBox(true), runs);
  testing::Rows("textured room, mirror, sky", testing::TexturedRoom(), runs);
  return 0;
}
