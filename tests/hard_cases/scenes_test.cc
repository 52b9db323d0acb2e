// Hard cases of whole solves: what no change of units, order, workers, seeds or wording of a scene
// may change.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "client/import/import.h"
#include "client/output/comparison.h"
#include "client/output/picture.h"
#include "tests/hard_cases/hard_case.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"
#include "tests/support/temp_dir.h"

namespace isolux::testing {
namespace {

SolveOptions ToAccuracy(double accuracy, uint64_t seed = 1) {
  SolveOptions options;
  options.accuracy = accuracy;
  options.seed = seed;
  return options;
}

SolveResult SolveScene(const Scene& scene, const SolveOptions& options, int workers = 1) {
  Result<SolveResult> result = SolveInProcess(scene, options, workers, workers == 1 ? 2 : 1);
  EXPECT_TRUE(result.has_value()) << result.error().message();
  return result ? std::move(*result) : SolveResult{};
}

const RoundSummary& Last(const SolveResult& result) { return result.summary.rounds.back(); }

double L1(const PatchFile& a, const PatchFile& b) {
  return Compare(a, b, {.samples = 1 << 14}).value().l1_relative;
}

// Difference over what the two estimates allow together.
double OverEstimates(const SolveResult& a, const SolveResult& b) {
  return L1(a.patch, b.patch) / (Last(a).error_estimate + Last(b).error_estimate);
}

std::string Seed(uint64_t seed) { return "seed " + std::to_string(seed); }

TEST(HardScenes, AnyNumberOfWorkers) {
  HardCase same("36", "1, 2, 3, 4 and 7 workers, a furnished room", "patch files that differ", 0);
  const Scene scene = FurnishedRoom();
  SolveOptions options = ToAccuracy(0.1);
  const SolveResult alone = SolveScene(scene, options);
  for (const RoundSummary& round : alone.summary.rounds) options.epsilons.push_back(round.epsilon);
  const std::string bytes = BytesWithoutComments(alone.patch);
  for (const int workers : {2, 3, 4, 7}) {
    const SolveResult result = SolveScene(scene, options, workers);
    same.Measure(BytesWithoutComments(result.patch) == bytes ? 0 : 1,
                 fmt::format("{} workers", workers));
  }
}

TEST(HardScenes, MigrationAndALostWorker) {
  HardCase same("37", "every cut node moves after every round; a worker dies in the last",
                "patch files that differ", 0);
  const Scene scene = FurnishedRoom();
  SolveOptions options = ToAccuracy(0.1);
  const SolveResult alone = SolveScene(scene, options);
  for (const RoundSummary& round : alone.summary.rounds) options.epsilons.push_back(round.epsilon);
  options.balance = BalanceStrategy::kRotate;
  LocalCluster cluster(3, 1);
  JobCallbacks callbacks;
  bool lost = false;
  callbacks.on_progress = [&](const JobProgress& progress) {
    if (lost || progress.round < alone.summary.rounds.size() ||
        progress.stage != JobProgress::Stage::kSolving) {
      return;
    }
    lost = true;
    cluster.Kill(1);
  };
  const auto result = RunJob(cluster, MakeJobInput(scene, options), callbacks);
  ASSERT_TRUE(result.has_value()) << result.error().message();
  EXPECT_TRUE(lost);
  same.Measure(BytesWithoutComments(result->patch) == BytesWithoutComments(alone.patch) ? 0 : 1);
}

TEST(HardScenes, Seeds) {
  HardCase twice("45", "one seed twice", "patch files that differ", 0);
  HardCase other("45a", "two seeds", "difference over the sum of the estimates", 1.5);
  const Scene scene = FurnishedRoom();
  const SolveResult first = SolveScene(scene, ToAccuracy(0.05, 1));
  const SolveResult again = SolveScene(scene, ToAccuracy(0.05, 1));
  twice.Measure(BytesWithoutComments(first.patch) == BytesWithoutComments(again.patch) ? 0 : 1);
  for (const uint64_t seed : {2, 3})
    other.Measure(OverEstimates(first, SolveScene(scene, ToAccuracy(0.05, seed))), Seed(seed));
}

TEST(HardScenes, Units) {
  HardCase same("3", "a furnished room 2^-20, 2^-10, 2^10 and 2^20 times as large",
                "irradiances of faces that are not the same to the bit", 0);
  HardCase close("60", "a furnished room in millimetres and in kilometres",
                 "difference over the sum of the estimates", 0.2);
  const Scene scene = FurnishedRoom();
  SolveOptions options = ToAccuracy(0.1);
  const SolveResult metres = SolveScene(scene, options);
  for (const double factor : {0x1p-20, 0x1p-10, 0x1p10, 0x1p20, 1e-3, 1e3}) {
    options.epsilons.clear();
    for (const RoundSummary& round : metres.summary.rounds)
      options.epsilons.push_back(round.epsilon * factor * factor);
    SolveResult scaled = SolveScene(Scaled(scene, factor), options);
    const std::string where = fmt::format("factor {}", factor);
    if (std::abs(std::log10(factor)) == 3) {
      for (PatchVertex& vertex : scaled.patch.vertices) vertex.position /= factor;
      close.Measure(OverEstimates(scaled, metres), where);
      continue;
    }
    ASSERT_EQ(scaled.patch.faces.size(), metres.patch.faces.size()) << where;
    for (size_t f = 0; f < scaled.patch.faces.size(); ++f) {
      const auto &a = scaled.patch.faces[f].irradiance, &b = metres.patch.faces[f].irradiance;
      same.Measure(a == b ? 0 : 1, where);
    }
  }
}

// Clusters lie along the axes, and so do the halves of what refinement divides by them.
TEST(HardScenes, TurnedAtRandom) {
  HardCase same("2a", "a furnished room turned at random, at 10, 5 and 2 %",
                "difference over the sum of the estimates", 0.5);
  HardCase conserved("2b", "the same", "energy imbalance over the error estimate", 1);
  const Scene scene = FurnishedRoom();
  for (const double accuracy : {0.1, 0.05, 0.02}) {
    const SolveResult upright = SolveScene(scene, ToAccuracy(accuracy));
    for (const uint64_t seed : {1, 2, 3}) {
      SolveResult turned = SolveScene(Turned(scene, seed), ToAccuracy(accuracy));
      for (PatchVertex& vertex : turned.patch.vertices)
        vertex.position = Turned(vertex.position, seed, true);
      same.Measure(OverEstimates(turned, upright), fmt::format("{}, {}", accuracy, Seed(seed)));
      conserved.Measure(Last(turned).energy_imbalance / Last(turned).error_estimate, Seed(seed));
    }
  }
}

TEST(HardScenes, Emission) {
  HardCase linear("28b", "a furnished room with 2, 1e9 and 1e-30 times the light",
                  "largest relative difference of a face's irradiance", 1e-6);
  const Scene scene = FurnishedRoom();
  SolveOptions options = ToAccuracy(0.1);
  const SolveResult once = SolveScene(scene, options);
  for (const double factor : {2.0, 1e9, 1e-30}) {
    Scene brighter = scene;
    for (Material& material : brighter.materials) material.exitance *= factor;
    options.epsilons.clear();
    for (const RoundSummary& round : once.summary.rounds)
      options.epsilons.push_back(round.epsilon * factor);
    const SolveResult result = SolveScene(brighter, options);
    const std::string where = fmt::format("factor {}", factor);
    ASSERT_EQ(result.patch.faces.size(), once.patch.faces.size()) << where;
    for (size_t f = 0; f < result.patch.faces.size(); ++f) {
      for (int c = 0; c < 3; ++c) {
        const double a = factor * once.patch.faces[f].irradiance[c];
        linear.Measure(std::abs(result.patch.faces[f].irradiance[c] - a) / a, where);
      }
    }
  }
}

TEST(HardScenes, ToldInAnotherWay) {
  HardCase same("61", "a room with polygons flipped, shuffled, or cut along other diagonals",
                "difference over the sum of the estimates", 1);
  for (const Scene& scene : {FurnishedRoom(), RandomRoom(61, 2)}) {
    const SolveResult plain = SolveScene(scene, ToAccuracy(0.05));
    SolveResult flipped = SolveScene(Flipped(scene), ToAccuracy(0.05));
    for (PatchFace& face : flipped.patch.faces) face.side ^= 1;
    same.Measure(OverEstimates(plain, flipped), "flipped");
    same.Measure(OverEstimates(plain, SolveScene(Shuffled(scene, 61), ToAccuracy(0.05))),
                 "shuffled");
    same.Measure(OverEstimates(plain, SolveScene(Retriangulated(scene, 61), ToAccuracy(0.05))),
                 "retriangulated");
  }
}

TEST(HardScenes, Doubled) {
  HardCase same("62", "every face of a file twice", "patch files that differ", 0);
  TempDir folder;
  std::ofstream(folder.path() + "/scene.mtl")
      << "newmtl m0\nKd .7 .7 .7\nnewmtl m1\nKd .3 .3 .3\nnewmtl m2\nKd .5 .5 .5\n"
         "newmtl m3\nKd .5 .5 .5\nKe 30 30 30\n";
  std::array<std::string, 2> bytes;
  for (const int copies : {1, 2}) {
    const std::string path = fmt::format("{}/room{}.obj", folder.path(), copies);
    std::ofstream(path) << AsObj(FurnishedRoom(), copies);
    const auto scene = ImportScene(path, {});
    ASSERT_TRUE(scene.has_value()) << scene.error().message();
    bytes[copies - 1] = BytesWithoutComments(SolveScene(*scene, ToAccuracy(0.1)).patch);
  }
  same.Measure(bytes[0] == bytes[1] ? 0 : 1);
}

TEST(HardScenes, LightsOfOneToAMillion) {
  HardCase conserved("63", "two lamps in a room, 1e6 times as bright as each other",
                     "energy imbalance over the error estimate", 1);
  HardCase dim("63a",
               "a closed room of 1e-6 of the light beside another, the dim one first or last",
               "radiosity of the dim one over E / (1 - rho), or 2 where it is 0", 1);
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.5), bright = sketch.Material("bright", 0, 1e6),
                 faint = sketch.Material("faint", 0, 1);
  sketch.Box({0, 0, 0}, {2, 2, 2}, true, wall, kFrontTakesPart);
  sketch.Rectangle(2, 1.9, {0.2, 0.2}, {0.6, 0.6}, false, bright, kBothTakePart | kFrontEmits);
  sketch.Rectangle(2, 1.9, {1.2, 1.2}, {1.6, 1.6}, false, faint, kBothTakePart | kFrontEmits);
  const SolveResult together = SolveScene(sketch.Take(), ToAccuracy(0.05));
  conserved.Measure(Last(together).energy_imbalance / Last(together).error_estimate);

  for (const uint32_t dim_room : {0u, 1u}) {
    SceneSketch pair;
    const uint32_t pair_wall = pair.Material("wall", 0.5);
    for (uint32_t k = 0; k < 2; ++k) {
      const double x = 3.0 * k;
      const uint32_t lamp = pair.Material("lamp", 0, k == dim_room ? 1 : 1e6);
      pair.Box({x, 0, 0}, {x + 2, 2, 2}, true, pair_wall, kFrontTakesPart);
      pair.Rectangle(2, 1.9, {x + 0.2, 0.2}, {x + 0.6, 0.6}, false, lamp,
                     kBothTakePart | kFrontEmits);
    }
    const SolveResult result = SolveScene(pair.Take(), ToAccuracy(0.05));
    std::array<bool, 6> lit{};
    for (const PatchFace& face : result.patch.faces) {
      if (face.polygon / 7 != dim_room) continue;
      if (face.polygon % 7 < 6) lit[face.polygon % 7] = face.radiosity[0] > 0;
      dim.Measure(face.radiosity[0] / (1 / (1 - 0.5)), fmt::format("room {}", dim_room));
    }
    for (const bool wall_lit : lit) dim.Measure(wall_lit ? 0 : 2, fmt::format("room {}", dim_room));
  }
}

TEST(HardScenes, CamerasInAwkwardPlaces) {
  HardCase sane("44", "a camera on a face, an edge, a corner, inside a wall or a box",
                "radiance below 0, above the brightest point, or not finite", 0);
  const SolveResult result = SolveScene(FurnishedRoom(), ToAccuracy(0.1));
  const auto scene = PatchScene::Build(result.patch);
  ASSERT_TRUE(scene.has_value());
  double brightest = 0;
  for (const PatchVertex& vertex : result.patch.vertices)
    for (const float b : vertex.radiosity) brightest = std::max<double>(brightest, b);
  ThreadPool pool(2);
  RenderOptions options;
  options.samples = 4;
  const Vec3 eyes[] = {{2, 1, 0},   {2, 0, 0},     {0, 0, 0},       {-1e-9, 1, 1},   {-1, 1, 1},
                       {1, 1, 0.5}, {2, 1.5, 2.3}, {0.5, 0.5, 0.3}, {1.5, 1.2, 2.3}, {4, 3, 2.5}};
  for (const Vec3& eye : eyes) {
    for (const Vec3& target : {Vec3(2, 1.5, 1.25), Vec3(4, 0, 0), Vec3(2, 1, 2.3)}) {
      if (eye == target) continue;
      Camera camera;
      camera.eye = eye;
      camera.target = target;
      camera.up = {0.1, 0.2, 1};
      camera.width = 16;
      camera.height = 12;
      double wrong = 0;
      for (const float v : Render(*scene, camera, options, pool).rgb)
        wrong += v >= 0 && v * M_PI <= brightest * (1 + 1e-5) ? 0 : 1;
      sane.Measure(wrong, fmt::format("({}, {}, {})", eye.x, eye.y, eye.z));
    }
  }
  HardCase bounded("44a", "output points on edges and corners of a furnished room",
                   "irradiance below 0, above the brightest point, or not finite", 0);
  for (const PatchVertex& vertex : result.patch.vertices) {
    for (const float h : vertex.irradiance)
      bounded.Measure(h >= 0 && h <= brightest * (1 + 1e-6) ? 0 : 1);
  }
}

}  // namespace
}  // namespace isolux::testing
