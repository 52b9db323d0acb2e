// How fast a scene's links are made, alone: no output, no other worker.
//
//   refine_bench SCENE [--emit both] [--finest SHARE] [--factor F] [--threads N]
//     Rounds whose thresholds fall by F (16) from 1e-1 of the emitted power to SHARE (1e-5). Prints
//     CSV, a row a round: links kept, evaluations, share of proofs, rays, seconds of refinement,
//     links kept a second and thread of all refinement so far.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include "client/import/import.h"
#include "common/util/parallel.h"
#include "worker/shard.h"

namespace isolux {
namespace {

struct Flags {
  ImportOptions import;
  double finest = 1e-5, factor = 16;
  int threads = 1;
};

int Run(const std::string& path, const Flags& flags) {
  const Result<Scene> scene = ImportScene(path, flags.import);
  if (!scene) {
    std::fprintf(stderr, "refine_bench: %s\n", scene.error().message().c_str());
    return 2;
  }
  ThreadPool pool(flags.threads);
  Shard shard(std::make_shared<const Scene>(*scene), &pool);
  SolveOptions options;
  if (!shard.Start(options, {{NodeId{NodeId::kCluster, 0}}, {0}, 1}, 0).ok()) return 2;
  NullExchange exchange;
  const double emitted = Sum(shard.EmittedPower());
  double refine_s = 0;
  std::printf("epsilon,links,evaluations,proved,rays,refine_s,links_per_s_and_thread\n");
  for (double share = 0.1; share > flags.finest; share /= flags.factor) {
    const auto report = shard.RunRound(share * emitted, options.accuracy, exchange);
    if (!report || !shard.InstallSnapshot(shard.TakeSnapshot()).ok()) return 2;
    refine_s += report->refine_s;
    std::printf("%.3g,%lu,%lu,%.3f,%lu,%.3f,%.0f\n", share, report->links, report->evaluations,
                static_cast<double>(report->proved_visible + report->proved_hidden) /
                    static_cast<double>(report->evaluations),
                report->rays, report->refine_s,
                static_cast<double>(report->links) / refine_s / flags.threads);
  }
  return 0;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  isolux::Flags flags;
  for (int i = 2; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--emit") == 0) {
      flags.import.emit_both = std::strcmp(argv[i + 1], "both") == 0;
    }
    if (std::strcmp(argv[i], "--finest") == 0) flags.finest = std::strtod(argv[i + 1], nullptr);
    if (std::strcmp(argv[i], "--factor") == 0) flags.factor = std::strtod(argv[i + 1], nullptr);
    if (std::strcmp(argv[i], "--threads") == 0) flags.threads = std::atoi(argv[i + 1]);
  }
  if (argc < 2) {
    std::fprintf(stderr, "usage: refine_bench SCENE [--emit both] [--finest SHARE] [...]\n");
    return 2;
  }
  return isolux::Run(argv[1], flags);
}
