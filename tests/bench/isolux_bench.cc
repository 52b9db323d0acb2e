// The benchmarks. Prints CSV: benchmark,quantity,value,unit. Run a name to run one, or nothing for
// all.
//
//   phases    seconds and bytes by phase of a job with two workers (Cornell box, both sides)
//   links     links kept a second of one thread's refinement, evaluations a kept link
//   rays      shadow rays a second in Embree alone, on packets as refinement makes them, and within
//             refinement, sampling and weighting included
//   memory    bytes a link and an element, without the solver's vectors
//   speedup   one against two workers of one thread: CPU of the busiest worker, and wall time
//
// Times are of this machine and this moment: compare figures of one run. Counts are steady.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>

#include "common/util/random.h"
#include "server/traffic.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "worker/radiosity/refine.h"
#include "worker/shard.h"

namespace isolux {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Print(const char* benchmark, const std::string& quantity, double value, const char* unit) {
  std::printf("%s,%s,%.6g,%s\n", benchmark, quantity.c_str(), value, unit);
  std::fflush(stdout);
}

const Scene& BenchScene() {
  static const Scene scene = testing::CornellBox(true);
  return scene;
}

// Thresholds from 1e-2 of the emitted power down, a quarter each round.
SolveOptions Options(double finest_share) {
  const Hierarchy hierarchy(BenchScene());
  double emitted = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    emitted += hierarchy.surface_area_m2(s) * Sum(hierarchy.surfaces()[s].exitance);
  }
  SolveOptions options;
  options.accuracy = 0.05;
  for (double share = 1e-2; share > finest_share; share /= 4)
    options.epsilons.push_back(share * emitted);
  return options;
}

struct TimedJob {
  SolveSummary summary;
  Traffic traffic;
  double wall_s = 0;
};

TimedJob RunTimed(int workers, const SolveOptions& options) {
  testing::LocalCluster cluster(workers, 1);
  TimedJob job;
  const double start = Now();
  const auto result =
      testing::RunJob(cluster, testing::MakeJobInput(BenchScene(), options), {}, &job.traffic);
  job.wall_s = Now() - start;
  if (!result) {
    std::fprintf(stderr, "isolux_bench: %s\n", result.error().message().c_str());
    std::exit(1);
  }
  job.summary = result->summary;
  return job;
}

void BenchPhases() {
  const TimedJob job = RunTimed(2, Options(3e-5));
  double refine = 0, exchange = 0, solve = 0, snapshot = 0, balance = 0;
  for (const RoundSummary& round : job.summary.rounds) {
    refine += round.refine_s;
    exchange += round.exchange_s;
    solve += round.solve_s;
    snapshot += round.snapshot_s;
    balance += round.balance_s;
  }
  const RoundSummary& last = job.summary.rounds.back();
  Print("phases", "rounds", last.round, "");
  Print("phases", "links", static_cast<double>(last.links), "");
  Print("phases", "elements", static_cast<double>(last.elements), "");
  Print("phases", "refine", refine, "s");
  Print("phases", "subscribe", exchange, "s");
  Print("phases", "solve", solve, "s");
  Print("phases", "snapshot", snapshot, "s");
  Print("phases", "balance", balance, "s");
  Print("phases", "gather", job.summary.gather_s, "s");
  Print("phases", "whole job", job.wall_s, "s");
  for (int p = 0; p < kPhaseCount; ++p) {
    const PhaseBytes bytes = job.traffic.Total(static_cast<Phase>(p));
    const std::string name = ToText(static_cast<Phase>(p));
    Print("phases", name + " from workers", static_cast<double>(bytes.in), "bytes");
    Print("phases", name + " to workers", static_cast<double>(bytes.out), "bytes");
  }
}

// One shard alone, refined through the same thresholds.
struct Solo {
  explicit Solo(double finest_share)
      : pool(1), shard(std::make_shared<Scene>(BenchScene()), &pool) {
    const SolveOptions options = Options(finest_share);
    const Assignment whole{{{NodeId::kCluster, 0}}, {0}, 1};
    if (!shard.Start(options, whole, 0).ok()) std::exit(1);
    NullExchange exchange;
    for (const double epsilon : options.epsilons) {
      reports.push_back(shard.RunRound(epsilon, options.accuracy, exchange).value());
      if (!shard.InstallSnapshot(shard.TakeSnapshot()).ok()) std::exit(1);
    }
  }
  template <typename Member>
  double Total(Member member) const {
    double sum = 0;
    for (const RoundReport& report : reports) sum += static_cast<double>(report.*member);
    return sum;
  }
  ThreadPool pool;
  Shard shard;
  std::vector<RoundReport> reports;
};

void BenchLinks() {
  const Solo solo(3e-5);
  const double links = static_cast<double>(solo.reports.back().links);
  Print("links", "kept", links, "");
  Print("links", "kept a second of refinement", links / solo.Total(&RoundReport::refine_s), "1/s");
  Print("links", "evaluations a kept link", solo.Total(&RoundReport::evaluations) / links, "");
  Print("links", "rays a kept link", solo.Total(&RoundReport::rays) / links, "");
}

void BenchRays() {
  const Hierarchy hierarchy(BenchScene());
  const RayScene rays(hierarchy);
  const Tree tree(hierarchy);
  // Packets between two random surfaces each, as the links of a coarse round have them.
  constexpr int kPackets = 50000;
  std::vector<RayPacket> packets(kPackets);
  Random random(1);
  std::vector<std::pair<uint32_t, uint32_t>> ends(kPackets);
  const auto surfaces = static_cast<uint32_t>(hierarchy.surfaces().size());
  const auto point = [&](uint32_t node) {
    const double u = random.Unit();
    return SamplePolygon(tree.polygon(node), u, random.Unit());
  };
  for (int k = 0; k < kPackets; ++k) {
    const uint32_t p = tree.SurfaceIndex(random.Bits() % surfaces);
    const uint32_t q = tree.SurfaceIndex(random.Bits() % surfaces);
    ends[k] = {p, q};
    for (int i = 0; i < RayScene::kPacket; ++i) {
      packets[k].Set(i,
                     {point(p), point(q), tree.surface_of(p).polygon, tree.surface_of(q).polygon});
    }
  }
  double start = Now();
  uint64_t visible = 0;
  for (const auto& packet : packets) visible += rays.Visible(packet);
  const double alone = 8.0 * kPackets / (Now() - start);
  start = Now();
  uint64_t traced = 0;
  for (const auto& [p, q] : ends) traced += SampleVisibility(tree, rays, p, q, 1).traced;
  const double sampled = static_cast<double>(traced) / (Now() - start);
  Print("rays", "Embree alone", alone, "1/s");
  Print("rays", "with sampling and weights", sampled, "1/s");
  Print("rays", "ratio", sampled / alone, "");
  Print("rays", "check", static_cast<double>(visible % 1000), "");
}

void BenchMemory() {
  const Solo solo(3e-5);
  const Hierarchy hierarchy(BenchScene());
  Tree tree(hierarchy);
  std::vector<uint32_t> moved;
  if (!tree.Install(solo.shard.TakeSnapshot(), &moved).ok()) std::exit(1);
  Print("memory", "a link", sizeof(Link), "bytes");
  Print("memory", "an element",
        static_cast<double>(tree.memory_bytes()) / static_cast<double>(tree.size()), "bytes");
  Print("memory", "a leaf in the snapshot", sizeof(LeafRecord), "bytes");
}

void BenchSpeedup() {
  const SolveOptions options = Options(6e-6);
  const auto busiest = [](const TimedJob& job) {
    double sum = 0;
    for (const RoundSummary& round : job.summary.rounds) {
      sum += *std::max_element(round.worker_cpu_s.begin(), round.worker_cpu_s.end());
    }
    return sum +
           *std::max_element(job.summary.gather_cpu_s.begin(), job.summary.gather_cpu_s.end());
  };
  std::vector<double> cpu, wall;
  for (int run = 0; run < 3; ++run) {
    const TimedJob one = RunTimed(1, options), two = RunTimed(2, options);
    if (run == 0)
      Print("speedup", "links", static_cast<double>(one.summary.rounds.back().links), "");
    cpu.push_back(busiest(one) / busiest(two));
    wall.push_back(one.wall_s / two.wall_s);
  }
  std::sort(cpu.begin(), cpu.end());
  std::sort(wall.begin(), wall.end());
  Print("speedup", "busiest worker's CPU, median of 3", cpu[1], "");
  Print("speedup", "wall, median of 3", wall[1], "");
}

int Main(int argc, char** argv) {
  const std::vector<std::pair<const char*, std::function<void()>>> benchmarks = {
      {"phases", BenchPhases}, {"links", BenchLinks},     {"rays", BenchRays},
      {"memory", BenchMemory}, {"speedup", BenchSpeedup},
  };
  std::printf("benchmark,quantity,value,unit\n");
  bool any = false;
  for (const auto& [name, run] : benchmarks) {
    if (argc > 1 && std::strcmp(argv[1], name) != 0) continue;
    run();
    any = true;
  }
  if (!any) std::fprintf(stderr, "isolux_bench: no benchmark is called %s\n", argv[1]);
  return any ? 0 : 2;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) { return isolux::Main(argc, argv); }
