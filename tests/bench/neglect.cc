// What neglecting an effect truly costs: how far irradiance is off without it, over its mean.
//
//   neglect paths SCENE.obj EFFECT [--points N] [--emit both]
//     By path tracing at N points uniform over the participating sides, 4096 paths a point. EFFECT:
//     mirrors, clear-glass, which only add light or only take some; or gloss, of lobes as narrow as
//     a mirror's and of some as wide as what is diffuse. Where all that the effect does is to add
//     mirrors, of light that met one alone, so that no other noise is in it; else with the effect
//     and without it, by the same random numbers, so that most noise is in both. Prints CSV, a line
//     each: all, narrow or wide, the difference of the means, its standard error.
//   neglect solved WITHOUT.ply WITH.ply
//     By two solutions. Prints CSV: `l1`, of the difference everywhere, and `mean`, of the means,
//     which is the same where an effect only adds or only takes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/import/import.h"
#include "client/output/comparison.h"
#include "common/scene/patch_file.h"
#include "tests/support/path_tracer.h"

namespace isolux {
namespace {

int Fail(const Status& status) {
  std::fprintf(stderr, "%s\n", status.message().c_str());
  return 2;
}

// The scene with its lobes; of narrow ones the mean of the channels, as a mirror is grey.
Scene WithLobes(Scene scene, bool wide) {
  for (Material& material : scene.materials) {
    const Gloss& gloss = material.gloss;
    if (wide && !gloss.kept) material.reflectance += gloss.share;
    if (wide) continue;
    const double share = Sum(gloss.share) / 3;
    material.specular += share;
    if (gloss.kept) material.reflectance = glm::max(material.reflectance - gloss.share, Rgb(0.0));
    const Rgb left = Rgb(1 - material.specular);
    material.reflectance = glm::min(material.reflectance, left);
  }
  return scene;
}

// Of scenes with the effect, by name, and one without; none where paths do not know of it.
struct Pair {
  std::vector<std::pair<std::string, Scene>> with;
  Scene without;
};
Pair PairOf(const std::string& effect, const Scene& scene) {
  Pair pair{{}, scene};
  if (effect == "gloss") {
    // Maps by their means: where a map is bright there is less room for a lobe.
    for (Material& material : pair.without.materials) material.reflectance_map = {};
    pair.with = {{"narrow", WithLobes(pair.without, false)},
                 {"wide", WithLobes(pair.without, true)}};
    return pair;
  }
  if (effect == "mirrors") {
    for (Material& material : pair.without.materials) material.specular = 0;
  } else if (effect == "clear-glass") {
    pair.without.glazing = {};
  } else {
    return pair;
  }
  pair.with = {{"all", scene}};
  return pair;
}

// Whether the second scene is the first with mirrors, and nothing else.
bool AddsMirrorsAlone(const Scene& without, const Scene& with) {
  for (size_t m = 0; m < without.materials.size(); ++m) {
    const Material &less = without.materials[m], &more = with.materials[m];
    if (less.specular != 0 || less.reflectance != more.reflectance) return false;
  }
  return true;
}

std::vector<double> Irradiances(const Scene& scene, const testing::PathTracing& paths,
                                ThreadPool& pool) {
  std::vector<double> irradiances;
  for (const ReferencePoint& point : testing::TracePaths(scene, paths, pool)) {
    irradiances.push_back(Sum(point.irradiance));
  }
  return irradiances;
}

// What the effect adds at each point.
std::vector<double> Added(const Scene& with, const Pair& pair, std::span<const double> without,
                          testing::PathTracing paths, ThreadPool& pool) {
  paths.by_mirrors_alone = AddsMirrorsAlone(pair.without, with);
  std::vector<double> added = Irradiances(with, paths, pool);
  for (size_t i = 0; i < added.size() && !paths.by_mirrors_alone; ++i) added[i] -= without[i];
  return added;
}

void PrintMean(const std::string& name, std::span<const double> added,
               std::span<const double> without) {
  double sum = 0, off = 0, squares = 0;
  for (size_t i = 0; i < added.size(); ++i) {
    sum += without[i] + added[i];
    off += added[i];
    squares += added[i] * added[i];
  }
  const auto n = static_cast<double>(added.size());
  const double variance = std::max(0.0, squares / n - (off / n) * (off / n));
  std::printf("%s,%.6f,%.6f\n", name.c_str(), off / sum, std::sqrt(variance * n) / sum);
}

int ByPaths(const std::string& path, const std::string& effect, bool emit_both,
            const testing::PathTracing& paths) {
  ImportOptions import;
  import.emit_both = emit_both;
  const Result<Scene> scene = ImportScene(path, import);
  if (!scene) return Fail(scene.error());
  const Pair pair = PairOf(effect, *scene);
  if (pair.with.empty()) {
    std::fprintf(stderr, "no paths know of '%s'\n", effect.c_str());
    return 2;
  }
  ThreadPool pool(0);
  const std::vector<double> without = Irradiances(pair.without, paths, pool);
  for (const auto& [name, with] : pair.with) {
    PrintMean(name, Added(with, pair, without, paths, pool), without);
  }
  return 0;
}

int BySolutions(const std::string& without, const std::string& with) {
  const Result<PatchFile> less = ReadPatchFile(without), more = ReadPatchFile(with);
  if (!less || !more) return Fail(less ? more.error() : less.error());
  const Result<Comparison> found = Compare(*less, *more, {});
  if (!found) return Fail(found.error());
  std::printf("l1,%.6f\nmean,%.6f\n", found->l1_relative, -found->bias_relative);
  return 0;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  const std::string mode = argc > 3 ? argv[1] : "";
  isolux::testing::PathTracing paths;
  paths.error = paths.seconds = std::numeric_limits<double>::max();  // the least number of paths
  bool emit_both = false;
  for (int i = 4; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    if (flag == "--points") paths.points = std::strtoul(argv[i + 1], nullptr, 10);
    if (flag == "--emit") emit_both = std::strcmp(argv[i + 1], "both") == 0;
  }
  if (mode == "paths") return isolux::ByPaths(argv[2], argv[3], emit_both, paths);
  if (mode == "solved") return isolux::BySolutions(argv[2], argv[3]);
  std::fprintf(stderr,
               "usage: neglect paths SCENE.obj EFFECT [...] | solved WITHOUT.ply WITH.ply\n");
  return 2;
}
