#include "client/commands/camera_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <numbers>
#include <string_view>

#include "client/import/gltf_nodes.h"

namespace isolux {
namespace {

constexpr int kHeight = 960;
constexpr double kAspect = 4.0 / 3;
constexpr size_t kMostNamed = 20;  // in a message

bool HasExtension(const std::string& name, std::initializer_list<std::string_view> extensions) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::find(extensions, extension) != extensions.end();
}

// How long the name of the glTF file is that the argument begins with; 0 where it is another file.
size_t LengthOfGltfName(const std::string& argument) {
  if (HasExtension(argument, {".json"})) return 0;
  size_t missing = 0;
  for (size_t at = argument.find(':'); true; at = argument.find(':', at + 1)) {
    const std::string name = argument.substr(0, at);
    if (HasExtension(name, {".gltf", ".glb"})) {
      std::error_code error;
      if (std::filesystem::is_regular_file(name, error)) return name.size();
      missing = name.size();
    }
    if (at == std::string::npos) return missing;
  }
}

bool IsNumber(const std::string& text) {
  return !text.empty() && text.size() < 10 &&
         std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0; });
}

std::string NamesOf(const std::vector<GltfCameraInstance>& cameras) {
  std::string names;
  for (size_t i = 0; i < std::min(cameras.size(), kMostNamed); ++i) {
    names += fmt::format("{}{} {}", i == 0 ? "" : ", ", i, cameras[i].where);
  }
  return cameras.size() > kMostNamed ? names + ", …" : names;
}

Result<GltfCameraInstance> Choose(const GltfDocument& document,
                                  const std::vector<GltfCameraInstance>& cameras,
                                  const std::string& which) {
  const tinygltf::Model& model = document.model;
  if (cameras.empty()) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: no node of its scene has a camera; give a camera.json", document.path);
  }
  if (which.empty()) return cameras.front();
  for (size_t i = 0; i < cameras.size(); ++i) {
    const auto number = static_cast<size_t>(cameras[i].camera);
    const bool named =
        cameras[i].name == which || (cameras[i].camera >= 0 && number < model.cameras.size() &&
                                     model.cameras[number].name == which);
    if (named || (IsNumber(which) && std::stoul(which) == i)) return cameras[i];
  }
  return Error(StatusCode::kInvalidArgument, "{}: no camera '{}'; there are: {}", document.path,
               which, NamesOf(cameras));
}

// What its lens is; where it stands is another matter.
Status SetLens(const GltfDocument& document, const GltfCameraInstance& chosen, Camera* camera) {
  const auto fail = [&](const char* what) {
    return document.Error(StatusCode::kInvalidArgument, chosen.where, "{}", what);
  };
  const auto& all = document.model.cameras;
  if (chosen.camera < 0 || static_cast<size_t>(chosen.camera) >= all.size()) {
    return fail("its camera does not exist; is the file whole?");
  }
  const tinygltf::Camera& from = all[static_cast<size_t>(chosen.camera)];
  if (from.type == "orthographic") {
    return fail(
        "its camera is orthographic, pictures are taken in perspective; choose another, or "
        "give a camera.json");
  }
  camera->fov_y_deg = from.perspective.yfov * 180 / std::numbers::pi;
  if (!(camera->fov_y_deg >= 0.01 && camera->fov_y_deg <= 175)) {
    return fail("its camera's yfov is not from 0.0002 to 3.05 radians; correct it");
  }
  const double given = from.perspective.aspectRatio;
  const double aspect = given == 0 ? kAspect : given;
  const double width = std::round(kHeight * aspect);
  if (!(width >= 1 && width <= Camera::kMostPixelsASide)) {
    return fail("its camera's aspectRatio leaves no picture; correct it");
  }
  camera->height = kHeight;
  camera->width = static_cast<int>(width);
  return {};
}

}  // namespace

Result<Camera> CameraOf(const GltfDocument& document, const std::string& which) {
  ASSIGN_OR_RETURN(const GltfNodes nodes, WalkNodes(document));
  ASSIGN_OR_RETURN(const GltfCameraInstance chosen, Choose(document, nodes.cameras, which));
  Camera camera;
  RETURN_IF_ERROR(SetLens(document, chosen, &camera));
  // It looks along −z, y upwards; a scale changes neither.
  const Vec3 forward = -Vec3(chosen.to_scene[2]), up(chosen.to_scene[1]);
  const double length = glm::length(forward), height = glm::length(up);
  if (!(length > 0 && height > 0 &&
        glm::length(glm::cross(forward / length, up / height)) > 1e-6)) {
    return document.Error(StatusCode::kInvalidArgument, chosen.where,
                          "its scale leaves its camera no direction; scale it by more than 0");
  }
  camera.eye = Vec3(chosen.to_scene[3]);
  camera.target = camera.eye + std::max(1.0, glm::length(camera.eye)) * forward / length;
  camera.up = up / height;
  return camera;
}

Result<Camera> ReadCameraOf(const std::string& argument) {
  const size_t length = LengthOfGltfName(argument);
  if (length == 0) return ReadCamera(argument);
  ASSIGN_OR_RETURN(const GltfDocument document, ReadGltfDocument(argument.substr(0, length)));
  return CameraOf(document, length < argument.size() ? argument.substr(length + 1) : "");
}

}  // namespace isolux
