// How much chance there is in what is gathered at single points: what one sees as speckle, and what
// no mean of a whole scene shows.
//
//   gather_noise SCENE [--emit both] [--accuracy A] [--epsilons E,E,…] [--points N] [--chances K]
//     Refines as a solve with these thresholds in W did (its JSON has them), then gathers at points
//     uniform over the surfaces, K times each with other rays. Prints CSV, one line: links; mean
//     over all points of the standard deviation, over the mean irradiance; the deviation over the
//     irradiance at the point (or a twentieth of the mean, if more): its root mean square, median,
//     90th and 99th percentile; rays a point; microseconds a point and thread.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>

#include "client/import/import.h"
#include "tests/support/output_gather.h"
#include "tests/support/surface_points.h"
#include "worker/shard.h"

namespace isolux {
namespace {

struct Flags {
  ImportOptions import;
  SolveOptions solve;
  std::vector<double> epsilons;
  uint64_t points = 1000;
  int chances = 16;  // a power of two
};

struct Noise {
  double irradiance = 0, deviation = 0;  // W/m², sums of channels
};

Flags Parse(int argc, char** argv) {
  Flags flags;
  for (int i = 2; i + 1 < argc; i += 2) {
    const auto is = [&](const char* name) { return std::strcmp(argv[i], name) == 0; };
    if (is("--emit")) flags.import.emit_both = std::strcmp(argv[i + 1], "both") == 0;
    if (is("--accuracy")) flags.solve.accuracy = std::atof(argv[i + 1]);
    if (is("--points")) flags.points = std::strtoull(argv[i + 1], nullptr, 10);
    if (is("--chances")) flags.chances = std::clamp(std::atoi(argv[i + 1]), 2, 256);
    if (!is("--epsilons")) continue;
    std::istringstream list(argv[i + 1]);
    for (std::string one; std::getline(list, one, ',');) {
      flags.epsilons.push_back(std::atof(one.c_str()));
    }
  }
  return flags;
}

// Elements within a speck, whose first corners are at one point for all that one can see, but have
// other rays.
std::vector<NodeId> Repeated(std::span<const testing::PointOnSurface> points, int chances) {
  const int levels = static_cast<int>(std::ceil(std::log2(chances)));
  std::vector<NodeId> ids;
  for (const testing::PointOnSurface& point : points) {
    for (int k = 0; k < chances; ++k) {
      ids.push_back(
          {point.element.surface, point.element.path << levels | static_cast<uint64_t>(k)});
    }
  }
  return ids;
}

std::vector<Noise> NoiseOf(const GatherPart& part, size_t points, int chances) {
  std::vector<Noise> noise(points);
  for (size_t i = 0; i < points; ++i) {
    double sum = 0, squares = 0;
    for (int k = 0; k < chances; ++k) {
      const Rgb h =
          testing::IrradianceOf(part, i * static_cast<size_t>(chances) + static_cast<size_t>(k));
      sum += h.x + h.y + h.z;
      squares += (h.x + h.y + h.z) * (h.x + h.y + h.z);
    }
    noise[i].irradiance = sum / chances;
    noise[i].deviation = std::sqrt(std::max(0.0, (squares - sum * sum / chances) / (chances - 1)));
  }
  return noise;
}

void Print(const std::vector<Noise>& noise, uint64_t links, double rays, double microseconds) {
  double irradiance = 0, deviation = 0, squares = 0;
  for (const Noise& point : noise) {
    irradiance += point.irradiance;
    deviation += point.deviation;
  }
  const double mean = irradiance / static_cast<double>(noise.size());
  std::vector<double> relative;
  for (const Noise& point : noise) {
    relative.push_back(point.deviation / std::max(point.irradiance, 0.05 * mean));
    squares += relative.back() * relative.back();
  }
  std::sort(relative.begin(), relative.end());
  const auto percentile = [&](double share) {
    return relative[static_cast<size_t>(share * static_cast<double>(relative.size() - 1))];
  };
  std::printf("links,mean,rms,median,p90,p99,rays,us\n%lu,%.4f,%.4f,%.4f,%.4f,%.4f,%.1f,%.1f\n",
              links, deviation / irradiance, std::sqrt(squares / static_cast<double>(noise.size())),
              percentile(0.5), percentile(0.9), percentile(0.99), rays, microseconds);
}

int Run(const char* path, const Flags& flags) {
  Result<Scene> read = ImportScene(path, flags.import);
  if (!read) {
    std::fprintf(stderr, "%s\n", read.error().message().c_str());
    return 2;
  }
  const auto scene = std::make_shared<const Scene>(std::move(*read));
  const Hierarchy hierarchy(*scene);
  ThreadPool pool(1);
  Shard shard(scene, &pool);
  if (!shard.Start(flags.solve, {{NodeId{NodeId::kCluster, 0}}, {0}, 1}, 0).ok()) return 1;
  NullExchange exchange;
  uint64_t links = 0;
  for (const double epsilon : flags.epsilons) {
    const auto report = shard.RunRound(epsilon, std::min(0.1, flags.solve.accuracy), exchange);
    if (!report || !shard.InstallSnapshot(shard.TakeSnapshot()).ok()) return 1;
    links = report->links;
  }
  const auto points = testing::UniformPoints(hierarchy, flags.points, 7);
  const std::vector<NodeId> ids = Repeated(points, flags.chances);
  const auto start = std::chrono::steady_clock::now();
  const auto part = shard.Gather(ids, std::vector<uint8_t>(ids.size(), 1), flags.solve.accuracy);
  if (!part) return 1;
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto count = static_cast<double>(ids.size());
  const std::vector<Noise> noise = NoiseOf(*part, points.size(), flags.chances);
  Print(noise, links, static_cast<double>(part->rays) / count, 1e6 * seconds / count);
  return 0;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  using namespace isolux;
  if (argc >= 2) return Run(argv[1], Parse(argc, argv));
  std::fprintf(stderr, "usage: gather_noise SCENE [...]\n");
  return 2;
}
