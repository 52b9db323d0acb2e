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
//   truth worst ROOM.ply POINTS.csv
//     Prints CSV: the points in falling order of their share of the error; at each, sums of
//     channels: irradiance found and expected, the mean, error and area of the face.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "client/import/import.h"
#include "client/output/comparison.h"
#include "client/output/patch_locator.h"
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

int ShowWorst(const std::string& ply, const std::string& csv) {
  const Result<PatchFile> file = ReadPatchFile(ply);
  if (!file) return Fail(file.error());
  const auto points = ReadReferencePoints(csv);
  if (!points) return Fail(points.error());
  const PatchLocator locator(*file);
  double total = 0;
  std::vector<std::pair<double, std::string>> lines;
  for (const ReferencePoint& point : *points) {
    total += Sum(point.irradiance);
    const auto f = locator.FindAlong(point.normal, point.position);
    if (!f) continue;
    const PatchFace& face = file->faces[*f];
    const Rgb found = IrradianceAt(*file, *f, point.position);
    const double error = Sum(glm::abs(found - point.irradiance));
    const Vec3& p = point.position;
    lines.emplace_back(
        error, fmt::format("{:.4f},{:.4f},{:.4f},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.3g}", p.x,
                           p.y, p.z, face.polygon, face.side, Sum(found), Sum(point.irradiance),
                           face.irradiance[0] + face.irradiance[1] + face.irradiance[2], face.error,
                           glm::length(AreaVector(CornersOf(*file, face)))));
  }
  std::sort(lines.begin(), lines.end(), [](auto& a, auto& b) { return a.first > b.first; });
  std::printf("share,x,y,z,polygon,side,found,expected,face,face_error,face_area\n");
  for (const auto& [error, line] : lines) std::printf("%.5f,%s\n", error / total, line.c_str());
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
  if (mode == "worst") return isolux::ShowWorst(argv[2], argv[3]);
  std::fprintf(
      stderr, "usage: truth make SCENE.obj POINTS.csv [...] | compare|worst ROOM.ply POINTS.csv\n");
  return 2;
}
