// What leaving out effects saves, as a table in Markdown: three scenes, each solved by two workers
// in this process with --effects auto and all.
//
//   effects_saved > table.md
#include <cstdio>

#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

constexpr double kAccuracy = 0.02;

// A grey room with a chequered floor, a small mirror on a wall, and the sky where its ceiling is
// open.
Scene TexturedRoom() {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.5));
  Scene scene = BoxRoom({4, 3, 2.5}, faces);
  scene.polygons.erase(scene.polygons.begin() + 5);
  Texture chequers{2, 2, Wrap::kRepeat, Wrap::kRepeat, {}};
  for (const float texel : {1.5F, 0.5F, 0.5F, 1.5F}) {
    for (int c = 0; c < 3; ++c) chequers.texels.push_back(texel);
  }
  scene.textures = {chequers};
  scene.coordinates = {{{0, 2, 2, 0}, {0, 0, 2, 2}}};
  scene.materials[scene.polygons[4].material].reflectance_map.texture = 0;
  scene.polygons[4].coordinates = 0;
  Polygon mirror;
  mirror.vertices.fill(kNoVertex);
  for (const Vec3& v :
       {Vec3(0.02, 1, 1), Vec3(0.02, 1.2, 1), Vec3(0.02, 1.2, 1.2), Vec3(0.02, 1, 1.2)}) {
    mirror.vertices[scene.vertices.size() % 4] = static_cast<uint32_t>(scene.vertices.size());
    scene.vertices.push_back(v);
  }
  mirror.material = static_cast<uint32_t>(scene.materials.size());
  mirror.file_polygon = scene.file_polygon_count++;
  mirror.sides = kFrontTakesPart;
  scene.materials.push_back({"mirror", Rgb(0.05), Rgb(0.0)});
  scene.materials.back().specular = 0.9;
  scene.polygons.push_back(mirror);
  scene.sky.columns = scene.sky.rows = 1;
  scene.sky.texels = {1, 1, 1};
  return scene;
}

uint64_t BytesIn(const Traffic& traffic) {
  return traffic.Total(Phase::kValues).in + traffic.Total(Phase::kSums).in;
}

void Row(const char* name, const Scene& scene, const char* effects) {
  SolveOptions options;
  options.accuracy = kAccuracy;
  options.effects = effects;
  LocalCluster cluster(2, 1);
  Traffic traffic;
  const auto result = RunJob(cluster, MakeJobInput(scene, options), {}, &traffic);
  if (!result) {
    std::fprintf(stderr, "%s: %s\n", name, result.error().message().c_str());
    return;
  }
  const SolveSummary& summary = result->summary;
  const RoundSummary& last = summary.rounds.back();
  const auto per = [&](uint64_t count) {
    return static_cast<double>(last.memory_bytes) / static_cast<double>(count);
  };
  std::puts(fmt::format("| {} | {} | {:.2f} | {} | {} | {} | {:.0f} | {:.0f} | {} |", name, effects,
                        summary.seconds, last.links, last.elements, summary.rays, per(last.links),
                        per(last.elements), BytesIn(traffic))
                .c_str());
}

}  // namespace
}  // namespace isolux::testing

int main() {
  using namespace isolux;  // NOLINT
  std::puts(
      "| scene | effects | seconds | links | elements | rays | bytes a link | bytes an element | "
      "bytes of values and sums, in |\n|---|---|---|---|---|---|---|---|---|");
  const auto rows = [](const char* name, const Scene& scene) {
    for (const char* effects : {"auto", "all"}) testing::Row(name, scene, effects);
  };
  rows("grey convex box", testing::FurnaceCube(0.5, 1));
  rows("Cornell box, coloured", testing::CornellBox(true));
  rows("textured room, mirror, sky", testing::TexturedRoom());
  return 0;
}
