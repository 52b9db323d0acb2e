// The true error of a solution: path-traced irradiance at seeded points, and how far a patch file
// is from it there. Shares no transport with the solver: no hierarchy of links, no form factors.
//
//   truth make SCENE.obj POINTS.csv [--points N] [--error SHARE] [--seconds S] [--emit both]
//     N points uniform over the participating sides; paths are added until the standard error of
//     each point is below SHARE of its irradiance (or of a twentieth of the mean, if more), or S
//     seconds have passed.
//   truth compare ROOM.ply POINTS.csv
//     Prints CSV: the L1 error relative to the mean irradiance, the same net of the reference's own
//     noise, the bias (signed), and how many points lie on no face (counted as dark).
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "client/import/import.h"
#include "client/output/comparison.h"
#include "client/output/reference_points.h"
#include "common/scene/patch_file.h"
#include "tests/support/path_tracer.h"

namespace isolux {
namespace {

struct Flags {
  testing::PathTracing paths;
  bool emit_both = false;
};

int Fail(const Status& status) {
  std::fprintf(stderr, "%s\n", status.message().c_str());
  return 2;
}

int Make(const std::string& path, const std::string& out, const Flags& flags) {
  ImportOptions import;
  import.emit_both = flags.emit_both;
  const Result<Scene> scene = ImportScene(path, import);
  if (!scene) return Fail(scene.error());
  ThreadPool pool(0);
  const auto points = testing::TracePaths(*scene, flags.paths, pool);
  if (const Status written = WriteReferencePoints(points, out); !written.ok()) return Fail(written);
  std::printf("points,%zu\nnoise,%.3g\n", points.size(), testing::NoiseOf(points));
  return 0;
}

int CompareFiles(const std::string& ply, const std::string& csv) {
  const Result<PatchFile> file = ReadPatchFile(ply);
  if (!file) return Fail(file.error());
  const auto points = ReadReferencePoints(csv);
  if (!points) return Fail(points.error());
  auto exact = *points;
  for (ReferencePoint& point : exact) point.deviation = Rgb(0.0);
  const Result<Comparison> raw = Compare(*file, exact), net = Compare(*file, *points);
  if (!raw || !net) return Fail(raw ? net.error() : raw.error());
  std::printf("l1,%.5f\nl1_net,%.5f\nbias,%.5f\ndark,%lu of %lu\n", raw->l1_relative,
              net->l1_relative, net->bias_relative, net->unmatched, net->samples);
  return 0;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  const std::string mode = argc > 3 ? argv[1] : "";
  isolux::Flags flags;
  for (int i = 4; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--points") == 0)
      flags.paths.points = std::strtoul(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--error") == 0) flags.paths.error = std::strtod(argv[i + 1], nullptr);
    if (std::strcmp(argv[i], "--seconds") == 0)
      flags.paths.seconds = std::strtod(argv[i + 1], nullptr);
    if (std::strcmp(argv[i], "--emit") == 0)
      flags.emit_both = std::strcmp(argv[i + 1], "both") == 0;
  }
  if (mode == "make") return isolux::Make(argv[2], argv[3], flags);
  if (mode == "compare") return isolux::CompareFiles(argv[2], argv[3]);
  std::fprintf(stderr,
               "usage: truth make SCENE.obj POINTS.csv [...] | compare ROOM.ply POINTS.csv\n");
  return 2;
}
