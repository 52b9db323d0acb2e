// How far the error that a solve states is from the one it has, over many scenes.
//
//   calibration [--scenes FOLDER] [--rooms N] [--accuracies A,A,…] [--points N]
//               [--references FOLDER] [--reference-links N] [--paths SECONDS]
//               [--most-polygons N] [--only TEXT]
//     Scenes: NAME/NAME.obj below FOLDER (--emit both where NAME/SOURCE.md says that emitters
//     radiate from both sides), and N random rooms with blockers, every other one open. Each is
//     solved at every accuracy by a coordinator and a worker in this process. The true error is
//     that of the patch file at points uniform over the surfaces, against irradiance gathered there
//     from a solution with many more links, twenty times the rays and other samples, or traced by
//     paths for so many seconds; --references keeps it for the next run.
//     Prints CSV, a row a run, then on standard error the distribution of estimated over true.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>

#include "client/import/import.h"
#include "client/import/prepare.h"
#include "client/output/comparison.h"
#include "common/util/file.h"
#include "tests/support/local_cluster.h"
#include "tests/support/output_gather.h"
#include "tests/support/path_tracer.h"
#include "tests/support/scenes.h"
#include "tests/support/surface_points.h"
#include "worker/shard.h"

namespace isolux::testing {
namespace {

struct Flags {
  std::string scenes, references, only;
  uint64_t rooms = 50, points = 1000, reference_links = 700'000, most_polygons = 1000;
  double paths_s = 0;
  std::vector<double> accuracies{0.1, 0.05, 0.02};
};

struct NamedScene {
  std::string name;
  std::shared_ptr<const Scene> scene;
};

Scene RandomRoomForTransport(uint64_t seed) {
  Scene scene = RandomRoom(seed, 1 + static_cast<int>(seed % 7));
  // One wall is missing in every other room.
  if (seed % 2 == 1) scene.polygons.erase(scene.polygons.begin() + static_cast<int>(seed / 2 % 6));
  RepairLog log;
  PrepareForTransport(&scene, &log, [](uint32_t p) { return std::to_string(p); });
  return scene;
}

std::vector<NamedScene> MakeScenes(const Flags& flags) {
  std::vector<NamedScene> scenes;
  const auto add = [&](const std::string& name, Scene scene) {
    if (name.find(flags.only) == std::string::npos) return;
    scenes.push_back({name, std::make_shared<const Scene>(std::move(scene))});
  };
  if (!flags.scenes.empty()) {
    std::vector<std::filesystem::path> folders;
    for (const auto& entry : std::filesystem::directory_iterator(flags.scenes)) {
      folders.push_back(entry.path());
    }
    std::sort(folders.begin(), folders.end());
    for (const auto& folder : folders) {
      const std::string name = folder.filename().string();
      std::ifstream source(folder / "SOURCE.md");
      std::ostringstream text;
      text << source.rdbuf();
      ImportOptions import;
      import.emit_both = text.str().find("both sides") != std::string::npos;
      auto scene = ImportScene((folder / (name + ".obj")).string(), import);
      if (!scene || scene->polygons.size() > flags.most_polygons) {
        std::fprintf(stderr, "left out: %s\n", name.c_str());
        continue;
      }
      add(name, std::move(*scene));
    }
  }
  for (uint64_t seed = 1; seed <= flags.rooms; ++seed) {
    const char* kind = seed % 2 == 1 ? "open" : "closed";
    add(fmt::format("{} room {}", kind, seed), RandomRoomForTransport(seed));
  }
  return scenes;
}

// Irradiance at points, from many links.
Result<std::vector<ReferencePoint>> SolveAtPoints(const NamedScene& named, const Flags& flags,
                                                  ThreadPool& pool) {
  const Hierarchy hierarchy(*named.scene);
  std::vector<PointOnSurface> points = UniformPoints(hierarchy, flags.points, 3);
  constexpr double kAccuracy = 0.003;
  SolveOptions options;
  options.accuracy = kAccuracy;
  options.seed = 1234;
  Shard shard(named.scene, &pool);
  RETURN_IF_ERROR(shard.Start(options, {{NodeId{NodeId::kCluster, 0}}, {0}, 1}, 0));
  NullExchange exchange;
  double epsilon = 0.02 * Sum(shard.EmittedPower());
  double estimate = 1;
  Snapshot snapshot;
  for (uint64_t links = 0; links < flags.reference_links / 2 && estimate > kAccuracy;
       epsilon *= 0.3) {
    ASSIGN_OR_RETURN(const RoundReport report, shard.RunRound(epsilon, kAccuracy, exchange));
    snapshot = shard.TakeSnapshot();
    RETURN_IF_ERROR(shard.InstallSnapshot(snapshot));
    links = report.links;
    estimate = report.error_estimate;
  }
  std::fprintf(stderr, "%s: reference states %.2f %%\n", named.name.c_str(), 100 * estimate);
  const std::vector<uint8_t> corners(points.size(), 1);
  ASSIGN_OR_RETURN(const GatherPart part, GatherOutput(shard, hierarchy, snapshot,
                                                       ElementsOf(points), corners, kAccuracy));
  std::vector<ReferencePoint> known;
  for (size_t i = 0; i < points.size(); ++i) {
    known.push_back(points[i].expected);
    known.back().irradiance = IrradianceOf(part, i);
  }
  return known;
}

Result<std::vector<ReferencePoint>> ReferenceOf(const NamedScene& named, const Flags& flags,
                                                ThreadPool& pool) {
  const auto make = [&]() -> Result<std::vector<ReferencePoint>> {
    if (flags.paths_s <= 0) return SolveAtPoints(named, flags, pool);
    PathTracing paths;
    paths.points = flags.points;
    paths.seconds = flags.paths_s;
    auto points = TracePaths(*named.scene, paths, pool);
    std::fprintf(stderr, "%s: reference's noise %.2f %%\n", named.name.c_str(),
                 100 * NoiseOf(points));
    return points;
  };
  if (flags.references.empty()) return make();
  Scene simulated = *named.scene;  // gloss is not
  for (Material& material : simulated.materials) material.gloss = {};
  const std::string path =
      fmt::format("{}/{}-{}.csv", flags.references, HashOf(Encode(simulated)), flags.points);
  if (std::filesystem::exists(path)) return ReadReferencePoints(path);
  ASSIGN_OR_RETURN(auto points, make());
  RETURN_IF_ERROR(MakeDirectories(flags.references));
  RETURN_IF_ERROR(WriteReferencePoints(points, path));
  return points;
}

// A solve, what its patch file is off, and what the irradiance gathered at the points is off.
struct Run {
  double accuracy = 0, cpu_s = 0;
  uint64_t rays = 0;
  RoundSummary last;
  Comparison output;
  double gathered = 0;
};

Result<double> ErrorAtPoints(const NamedScene& named, const SolveOptions& options,
                             const std::vector<Snapshot>& snapshots,
                             std::span<const MeasuredEffect> measured,
                             std::span<const ReferencePoint> known, ThreadPool& pool) {
  const Hierarchy hierarchy(*named.scene);
  const std::vector<PointOnSurface> points = PlacePoints(hierarchy, known);
  Shard shard(named.scene, &pool);
  RETURN_IF_ERROR(shard.Start(options, {{NodeId{NodeId::kCluster, 0}}, {0}, 1}, 0, measured));
  NullExchange exchange;
  for (const Snapshot& snapshot : snapshots) {
    RETURN_IF_ERROR(shard.ReplayRound(snapshot.epsilon, exchange));
    RETURN_IF_ERROR(shard.InstallSnapshot(snapshot));
  }
  const std::vector<uint8_t> corners(points.size(), 1);
  ASSIGN_OR_RETURN(const GatherPart part,
                   GatherOutput(shard, hierarchy, snapshots.back(), ElementsOf(points), corners,
                                options.accuracy));
  ErrorTally tally;
  for (size_t i = 0; i < points.size(); ++i) {
    tally.Add(IrradianceOf(part, i), points[i].expected.irradiance, points[i].expected.deviation);
  }
  ASSIGN_OR_RETURN(const Comparison comparison, tally.Finish());
  return comparison.l1_relative;
}

Result<Run> SolveAndMeasure(const NamedScene& named, double accuracy,
                            std::span<const ReferencePoint> known, ThreadPool& pool) {
  SolveOptions options;
  options.accuracy = accuracy;
  std::vector<Snapshot> snapshots;
  JobCallbacks callbacks;
  callbacks.on_snapshot = [&](const Snapshot& snapshot) {
    snapshots.push_back(snapshot);
    return Status();
  };
  LocalCluster cluster(1, pool.thread_count());
  ASSIGN_OR_RETURN(const SolveResult result,
                   RunJob(cluster, MakeJobInput(*named.scene, options), callbacks));
  Run run;
  run.accuracy = accuracy;
  run.rays = result.summary.rays;
  run.last = result.summary.rounds.back();
  for (const RoundSummary& round : result.summary.rounds) {
    for (const double s : round.worker_cpu_s) run.cpu_s += s;
  }
  for (const double s : result.summary.gather_cpu_s) run.cpu_s += s;
  ASSIGN_OR_RETURN(run.output, Compare(result.patch, known));
  ASSIGN_OR_RETURN(run.gathered,
                   ErrorAtPoints(named, options, snapshots, result.summary.rounds.front().measured,
                                 known, pool));
  return run;
}

void Print(const NamedScene& named, const Run& run) {
  const RoundSummary& r = run.last;
  std::printf(
      "%s,%g,%u,%lu,%lu,%lu,%.3f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%."
      "3f\n",
      named.name.c_str(), run.accuracy, r.round, r.links, r.elements, run.rays, run.cpu_s,
      r.error_estimate, r.error_spread, r.error_visibility, r.error_coupling, r.error_solver,
      r.energy_imbalance, run.output.l1_relative, run.gathered, r.error_rms,
      run.output.rms_relative, run.output.p95_local, run.output.bias_relative,
      r.error_estimate / run.output.l1_relative);
  std::fflush(stdout);
}

double RatioOfMeans(const Run& run) { return run.last.error_estimate / run.output.l1_relative; }
double RatioOfRms(const Run& run) { return run.last.error_rms / run.output.rms_relative; }

void PrintDistribution(const std::vector<Run>& runs, const char* title,
                       double (*ratio_of)(const Run&) = RatioOfMeans) {
  if (runs.empty()) return;
  std::vector<double> ratios;
  double inside = 0, low = 0, met = 0;
  for (const Run& run : runs) {
    const double ratio = ratio_of(run);
    ratios.push_back(ratio);
    inside += ratio >= 0.7 && ratio <= 3 ? 1 : 0;
    low += ratio < 0.5 ? 1 : 0;
    met += run.output.l1_relative <= run.accuracy ? 1 : 0;
  }
  std::sort(ratios.begin(), ratios.end());
  const auto n = static_cast<double>(ratios.size());
  const auto quantile = [&](double q) {
    return ratios[std::min(ratios.size() - 1, static_cast<size_t>(q * n))];
  };
  std::fprintf(
      stderr,
      "%-14s %4zu runs: estimated/true min %.2f, 5 %% %.2f, 25 %% %.2f, median %.2f, 75 %% "
      "%.2f, 95 %% %.2f, max %.2f; in [0.7, 3] %.1f %%, below 0.5 %.1f %%, true within "
      "accuracy %.1f %%\n",
      title, ratios.size(), ratios.front(), quantile(0.05), quantile(0.25), quantile(0.5),
      quantile(0.75), quantile(0.95), ratios.back(), 100 * inside / n, 100 * low / n,
      100 * met / n);
}

int Calibrate(const Flags& flags) {
  ThreadPool pool(0);
  std::vector<Run> all;
  std::map<std::string, std::vector<Run>> groups;
  std::printf(
      "scene,accuracy,rounds,links,elements,rays,cpu_s,estimate,spread,visibility,coupling,solver,"
      "imbalance,true,gathered,rms_estimate,rms,p95,bias,ratio\n");
  for (const NamedScene& named : MakeScenes(flags)) {
    const auto known = ReferenceOf(named, flags, pool);
    if (!known) {
      std::fprintf(stderr, "%s: %s\n", named.name.c_str(), known.error().message().c_str());
      return 1;
    }
    for (const double accuracy : flags.accuracies) {
      const Result<Run> run = SolveAndMeasure(named, accuracy, *known, pool);
      if (!run) {
        std::fprintf(stderr, "%s: %s\n", named.name.c_str(), run.error().message().c_str());
        return 1;
      }
      Print(named, *run);
      all.push_back(*run);
      const size_t room = named.name.find(" room");
      groups[room == std::string::npos ? "scenes" : named.name.substr(0, room) + " rooms"]
          .push_back(*run);
      groups[fmt::format("accuracy {:g}", accuracy)].push_back(*run);
    }
  }
  for (const auto& [title, runs] : groups) PrintDistribution(runs, title.c_str());
  PrintDistribution(all, "all");
  PrintDistribution(all, "root mean square", RatioOfRms);
  return 0;
}

std::vector<double> ParseList(const char* text) {
  std::vector<double> values;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) {
    values.push_back(std::strtod(word.c_str(), nullptr));
  }
  return values;
}

}  // namespace
}  // namespace isolux::testing

int main(int argc, char** argv) {
  isolux::testing::Flags flags;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    const char* value = argv[i + 1];
    const auto number = [&] { return std::strtoull(value, nullptr, 10); };
    if (flag == "--scenes") flags.scenes = value;
    if (flag == "--references") flags.references = value;
    if (flag == "--only") flags.only = value;
    if (flag == "--rooms") flags.rooms = number();
    if (flag == "--points") flags.points = number();
    if (flag == "--reference-links") flags.reference_links = number();
    if (flag == "--most-polygons") flags.most_polygons = number();
    if (flag == "--paths") flags.paths_s = std::strtod(value, nullptr);
    if (flag == "--accuracies") flags.accuracies = isolux::testing::ParseList(value);
  }
  if (argc % 2 == 0) {
    std::fprintf(stderr, "usage: calibration [--scenes FOLDER] [--rooms N] [...]\n");
    return 2;
  }
  return isolux::testing::Calibrate(flags);
}
