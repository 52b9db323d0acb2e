// isolux render room.ply [--camera cam.json|room.glb] -o room.png|room.exr
//
// A picture of a patch file. PNG: exposed and tone-mapped for a display; EXR: linear radiance,
// W/(m² sr), as floats.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "client/commands/camera_file.h"
#include "client/commands/commands.h"
#include "client/commands/fail.h"
#include "client/output/picture.h"

namespace isolux {
namespace {

constexpr int64_t kMostPixels = 1LL << 28;

struct RenderFlags {
  std::string patch_file, camera_file, output, tone_map = "reinhard", up = "auto";
  RenderOptions render;
  double exposure_stops = 0;
  int width = 0, height = 0, threads = 0;  // 0: the camera's; one a core
};

Result<bool> IsExr(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".exr") return true;
  if (extension == ".png") return false;
  return Error(StatusCode::kInvalidArgument, "{}: a picture's name ends in .png or .exr", path);
}

// The size asked for; where only one side is given the other keeps the picture's shape.
Status SetSize(const RenderFlags& options, Camera* camera) {
  const double aspect = static_cast<double>(camera->width) / camera->height;
  if (options.width > 0) {
    camera->width = options.width;
    if (options.height == 0) camera->height = static_cast<int>(std::lround(options.width / aspect));
  }
  if (options.height > 0) {
    camera->height = options.height;
    if (options.width == 0) camera->width = static_cast<int>(std::lround(options.height * aspect));
  }
  camera->width = std::max(camera->width, 1);
  camera->height = std::max(camera->height, 1);
  if (int64_t{camera->width} * camera->height > kMostPixels) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{} × {} pixels are too many; the limit is {} in all", camera->width,
                      camera->height, kMostPixels);
  }
  return {};
}

Status RenderToFile(const RenderFlags& options) {
  ASSIGN_OR_RETURN(const bool exr, IsExr(options.output));
  ASSIGN_OR_RETURN(const ToneMap tone_map, ParseToneMap(options.tone_map));
  Camera camera;
  if (!options.camera_file.empty()) {
    ASSIGN_OR_RETURN(camera, ReadCameraOf(options.camera_file));
  }
  const auto start = std::chrono::steady_clock::now();
  ASSIGN_OR_RETURN(const PatchFile file, ReadPatchFile(options.patch_file));
  auto scene = PatchScene::Build(file);
  if (!scene.has_value()) return scene.error().Within(options.patch_file);
  if (options.camera_file.empty()) {
    camera = GuessCamera(*scene, options.up == "y" ? 1 : options.up == "z" ? 2 : 0);
  }
  RETURN_IF_ERROR(SetSize(options, &camera));

  ThreadPool pool(options.threads);
  RenderOptions render = options.render;
  if (exr) {
    RETURN_IF_ERROR(WriteExr(options.output, Render(*scene, camera, render, pool)));
  } else {
    const Exposure exposure = AutoExposure(*scene, camera, tone_map, options.exposure_stops);
    render.brightest = exposure.WhiteLuminance();
    const Image image = Render(*scene, camera, render, pool);
    RETURN_IF_ERROR(
        WritePng(options.output, image.width, image.height, ToDisplay(image, exposure)));
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  fmt::print(stderr, "{}: {} × {} pixels, {} faces, {:.1f} s\n", options.output, camera.width,
             camera.height, file.faces.size(), seconds.count());
  return {};
}

int RunRender(const RenderFlags& options) {
  const Status status = RenderToFile(options);
  return status.ok() ? 0 : Fail("render", status);
}

}  // namespace

void AddRenderCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<RenderFlags>();
  CLI::App* command = app.add_subcommand("render", "a picture of a patch file");
  command->add_option("patch_file", options->patch_file, "patch file (.ply)")->required();
  command->add_option(
      "--camera", options->camera_file,
      "camera.json: eye, target, up, fov_y_deg, width, height, in the scene file's "
      "unit; or a camera of a scene, FILE.gltf[:NUMBER|:NAME] (default: a view that "
      "shows much)");
  command->add_option("--up", options->up, "without a camera: which axis is up, y, z or auto")
      ->check(CLI::IsMember({"auto", "y", "z"}))
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "picture, .png or .exr")->required();
  command->add_option("--samples", options->render.samples, "rays a pixel")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  command
      ->add_option("--exposure", options->exposure_stops,
                   "stops (doublings) brighter than the metered exposure; PNG only")
      ->check(CLI::Range(-60.0, 60.0))
      ->capture_default_str();
  command->add_option("--tone-map", options->tone_map, "reinhard or linear; PNG only")
      ->check(CLI::IsMember({"reinhard", "linear"}))
      ->capture_default_str();
  command->add_option("--width", options->width, "pixels (default: the camera's)")
      ->check(CLI::Range(1, Camera::kMostPixelsASide));
  command->add_option("--height", options->height, "pixels (default: the camera's)")
      ->check(CLI::Range(1, Camera::kMostPixelsASide));
  command->add_option("--threads", options->threads, "threads (default: one a core)")
      ->check(CLI::Range(0, 4096));
  command->callback([options, &run] { run = [options] { return RunRender(*options); }; });
}

}  // namespace isolux
