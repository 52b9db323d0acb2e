// Error against links, without mesh or network: one process refines a scene round by round and,
// after each, compares with true irradiance at points (see truth.cc) what the leaves hold and what
// is gathered at the points themselves.
//
//   convergence SCENE.obj POINTS.csv [--emit both] [--rounds N] [--step FACTOR] [--accuracy A]
//       [--effects CHOICE] [--seed N]
//     Prints CSV: ε over emitted power, links, leaves, rays, seconds of refinement and solution,
//     error of the leaves' constants, error gathered at accuracy A (signed mean, rays a point,
//     microseconds a point), estimated error and its parts, energy imbalance.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "client/import/import.h"
#include "client/output/comparison.h"
#include "tests/support/output_gather.h"
#include "tests/support/surface_points.h"
#include "worker/shard.h"

namespace isolux {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Comparison Finished(const ErrorTally& tally) { return tally.Finish().value_or(Comparison()); }

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  using namespace isolux;
  if (argc < 3) {
    std::fprintf(stderr, "usage: convergence SCENE.obj POINTS.csv [...]\n");
    return 2;
  }
  ImportOptions import;
  int rounds = 9;
  double step = 0.25, accuracy = 0.01, first = 0.02;
  std::string effects = "auto";
  uint64_t seed = 1;
  for (int i = 3; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--emit") == 0)
      import.emit_both = std::strcmp(argv[i + 1], "both") == 0;
    if (std::strcmp(argv[i], "--rounds") == 0) rounds = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--step") == 0) step = std::atof(argv[i + 1]);
    if (std::strcmp(argv[i], "--effects") == 0) effects = argv[i + 1];
    if (std::strcmp(argv[i], "--seed") == 0) seed = std::strtoull(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--accuracy") == 0) accuracy = std::atof(argv[i + 1]);
  }
  Result<Scene> read = ImportScene(argv[1], import);
  if (!read) {
    std::fprintf(stderr, "%s\n", read.error().message().c_str());
    return 2;
  }
  const auto scene = std::make_shared<const Scene>(std::move(*read));
  const Hierarchy hierarchy(*scene);
  const auto known = ReadReferencePoints(argv[2]);
  if (!known) {
    std::fprintf(stderr, "%s\n", known.error().message().c_str());
    return 2;
  }
  const std::vector<testing::PointOnSurface> points = testing::PlacePoints(hierarchy, *known);
  const std::vector<NodeId> ids = testing::ElementsOf(points);

  ThreadPool pool(0);
  Shard shard(scene, &pool);
  SolveOptions options;
  options.accuracy = accuracy;
  options.effects = effects;
  options.seed = seed;
  const Assignment assignment{{NodeId{NodeId::kCluster, 0}}, {0}, 1};
  if (!shard.Start(options, assignment, 0).ok()) return 1;
  NullExchange exchange;
  std::printf(
      "epsilon,links,leaves,rays,refine_s,solve_s,constants,gathered,gathered_bias,gather_rays,"
      "us_per_point,estimate,spread,visibility,coupling,solver,imbalance\n");
  double share = first;
  for (int r = 0; r < rounds; ++r, share *= step) {
    const double epsilon = share * Sum(shard.EmittedPower());
    const auto report = shard.RunRound(epsilon, std::min(0.1, accuracy), exchange);
    if (!report) {
      std::fprintf(stderr, "%s\n", report.error().message().c_str());
      return 1;
    }
    const Snapshot snapshot = shard.TakeSnapshot();
    if (!shard.InstallSnapshot(snapshot).ok()) return 1;
    const double start = Now();
    const auto part = testing::GatherOutput(shard, hierarchy, snapshot, ids,
                                            std::vector<uint8_t>(ids.size(), 1), accuracy);
    if (!part) {
      std::fprintf(stderr, "%s\n", part.error().message().c_str());
      return 1;
    }
    const double gather_s = Now() - start;
    ErrorTally constants, gathered;
    for (size_t i = 0; i < points.size(); ++i) {
      const auto leaf = std::find_if(snapshot.leaves.begin(), snapshot.leaves.end(),
                                     [&](const LeafRecord& l) { return Contains(l.id, ids[i]); });
      const ReferencePoint& expected = points[i].expected;
      constants.Add(Rgb(leaf->irradiance[0], leaf->irradiance[1], leaf->irradiance[2]),
                    expected.irradiance, expected.deviation);
      gathered.Add(testing::IrradianceOf(*part, i), expected.irradiance, expected.deviation);
    }
    std::printf(
        "%.3g,%lu,%lu,%lu,%.3f,%.3f,%.4f,%.4f,%+.4f,%.0f,%.1f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n",
        share, report->links, report->leaves, report->rays, report->refine_s, report->solve_s,
        Finished(constants).l1_relative, Finished(gathered).l1_relative,
        Finished(gathered).bias_relative,
        static_cast<double>(part->rays) / static_cast<double>(points.size()),
        1e6 * gather_s / static_cast<double>(points.size()) * pool.thread_count(),
        report->error_estimate, report->error_spread, report->error_visibility,
        report->error_coupling, report->error_solver, report->energy_imbalance);
    std::fflush(stdout);
  }
  return 0;
}
