#include "client/import/lights_file.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "client/import/gltf_document.h"
#include "client/import/ies_file.h"
#include "client/import/json_element.h"
#include "client/import/sky_file.h"
#include "client/import/spectra_file.h"
#include "client/import/text_file.h"
#include "common/util/file.h"

namespace isolux {
namespace {

using Json = nlohmann::json;

constexpr uint64_t kMostLightsBytes = 16 << 20;
constexpr int kDeepest = 16;
constexpr double kSunDiameter = 0.533;  // degrees, seen from the earth

double Cosine(double degrees) { return std::cos(degrees * std::numbers::pi / 180); }

Status ReadSpot(const JsonElement& element, Light* light) {
  ASSIGN_OR_RETURN(const double outer, element.Number("outer_angle", 45, 0, 90));
  ASSIGN_OR_RETURN(const double inner, element.Number("inner_angle", 0, 0, outer));
  light->kind = LightKind::kSpot;
  light->cosine_full = Cosine(inner);
  light->cosine_none = Cosine(outer);
  return {};
}

// Its table becomes one of the file's, once for lights that share it.
Status ReadPhotometric(const JsonElement& element, const std::string& folder, SceneFile* file,
                       Light* light) {
  RETURN_IF_ERROR(
      element.CheckKeys({"type", "name", "position", "direction", "ahead", "file", "colour"}));
  light->kind = LightKind::kPhotometric;
  ASSIGN_OR_RETURN(light->position_m, element.Vector("position"));
  ASSIGN_OR_RETURN(light->direction, element.Direction("direction"));
  ASSIGN_OR_RETURN(light->intensity, element.Colour("colour", Rgb(1.0)));
  const Vec3& axis = light->direction;
  Vec3 ahead = std::abs(axis.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  if (element.json.contains("ahead")) {
    ASSIGN_OR_RETURN(ahead, element.Direction("ahead"));
  }
  ahead -= glm::dot(ahead, axis) * axis;
  if (!(glm::length(ahead) > 1e-6)) {
    return element.Error("\"ahead\" is along \"direction\"; choose another");
  }
  light->ahead = glm::normalize(ahead);
  ASSIGN_OR_RETURN(const std::string name, element.Text("file"));
  const Result<std::string> path = ResolveInside(folder, name);
  if (!path.has_value()) return path.error().Within(element.where);
  const auto known = std::ranges::find(file->photometries, *path, &Photometry::name);
  light->photometry = static_cast<uint32_t>(known - file->photometries.begin());
  if (known != file->photometries.end()) return {};
  const size_t most = SceneLimits().photometries;
  if (file->photometries.size() >= most) return element.Error("more than {} files", most);
  ASSIGN_OR_RETURN(Photometry photometry, ReadIes(*path));
  file->photometries.push_back(std::move(photometry));
  return {};
}

Result<Light> ReadLight(const JsonElement& element, const std::string& folder, SceneFile* file) {
  if (!element.json.is_object()) return element.Error("not an object; write {{…}}");
  const auto type = element.json.find("type");
  const std::string kind =
      type != element.json.end() && type->is_string() ? type->get<std::string>() : std::string();
  Light light;
  if (const auto name = element.json.find("name");
      name != element.json.end() && name->is_string()) {
    light.name = name->get<std::string>();
  }
  if (kind == "point") {
    RETURN_IF_ERROR(element.CheckKeys({"type", "name", "position", "intensity"}));
    ASSIGN_OR_RETURN(light.position_m, element.Vector("position"));
    ASSIGN_OR_RETURN(light.intensity, element.Colour("intensity"));
  } else if (kind == "spot") {
    RETURN_IF_ERROR(element.CheckKeys(
        {"type", "name", "position", "direction", "intensity", "inner_angle", "outer_angle"}));
    ASSIGN_OR_RETURN(light.position_m, element.Vector("position"));
    ASSIGN_OR_RETURN(light.direction, element.Direction("direction"));
    ASSIGN_OR_RETURN(light.intensity, element.Colour("intensity"));
    RETURN_IF_ERROR(ReadSpot(element, &light));
  } else if (kind == "directional") {
    RETURN_IF_ERROR(element.CheckKeys({"type", "name", "direction", "irradiance"}));
    light.kind = LightKind::kDirectional;
    ASSIGN_OR_RETURN(light.direction, element.Direction("direction"));
    ASSIGN_OR_RETURN(light.intensity, element.Colour("irradiance"));
  } else if (kind == "ies") {
    RETURN_IF_ERROR(ReadPhotometric(element, folder, file, &light));
  } else if (kind == "sun") {
    RETURN_IF_ERROR(
        element.CheckKeys({"type", "name", "direction", "irradiance", "angular_diameter"}));
    light.kind = LightKind::kDirectional;
    ASSIGN_OR_RETURN(light.direction, element.Direction("direction"));
    ASSIGN_OR_RETURN(light.intensity, element.Colour("irradiance"));
    ASSIGN_OR_RETURN(const double diameter,
                     element.Number("angular_diameter", kSunDiameter, 0.001, 20));
    light.disc_radius = std::tan(0.5 * diameter * std::numbers::pi / 180);
  } else {
    return element.Error(
        "\"type\" must be one of \"point\", \"spot\", \"directional\", \"ies\", \"sun\"");
  }
  return light;
}

Result<Medium> ReadMedium(const JsonElement& element) {
  if (!element.json.is_object()) return element.Error("not an object; write {{…}}");
  RETURN_IF_ERROR(element.CheckKeys({"extinction_per_m"}));
  Medium medium;
  ASSIGN_OR_RETURN(medium.extinction_per_m, element.Colour("extinction_per_m"));
  RETURN_IF_ERROR(CheckMedium(medium).Within(element.where));
  return medium;
}

Status ReadLights(const JsonElement& whole, SceneFile* file) {
  const auto lights = whole.json.find("lights");
  if (lights == whole.json.end()) return {};
  if (!lights->is_array()) return whole.Error("\"lights\" must be a list, like [{{…}}, {{…}}]");
  const size_t most = SceneLimits().lights;
  if (lights->size() > most) return whole.Error("more than {} lights; leave some out", most);
  for (size_t i = 0; i < lights->size(); ++i) {
    const std::string where = fmt::format("{}: lights[{}]", whole.where, i);
    ASSIGN_OR_RETURN(const Light light,
                     ReadLight({(*lights)[i], where}, FolderOf(whole.where), file));
    file->lights.push_back(light);
  }
  return {};
}

Result<Json> ParseJson(const std::string& text, const std::string& name) {
  try {  // the library throws
    return Json::parse(text, [](int depth, Json::parse_event_t, Json&) {
      if (depth > kDeepest) throw std::runtime_error("nested too deeply");
      return true;
    });
  } catch (const std::exception& exception) {
    std::string what = exception.what();
    if (const size_t at = what.find("parse error"); at != std::string::npos) what = what.substr(at);
    return Error(StatusCode::kInvalidArgument, "{}: {}; correct it", name, what);
  }
}

}  // namespace

Status ParseLightsFile(const std::string& text, const std::string& name, SceneFile* file) {
  ASSIGN_OR_RETURN(const Json json, ParseJson(text, name));
  const JsonElement whole{json, name};
  RETURN_IF_ERROR(whole.CheckKeys({"lights", "sky", "medium", "spectra"}));
  if (const auto sky = json.find("sky"); sky != json.end()) {
    ASSIGN_OR_RETURN(file->sky, ReadSky({*sky, fmt::format("{}: sky", name)}, FolderOf(name)));
  }
  if (const auto medium = json.find("medium"); medium != json.end()) {
    ASSIGN_OR_RETURN(file->medium, ReadMedium({*medium, fmt::format("{}: medium", name)}));
  }
  RETURN_IF_ERROR(ReadLights(whole, file));
  if (const auto spectra = json.find("spectra"); spectra != json.end()) {
    RETURN_IF_ERROR(ReadSpectra({*spectra, fmt::format("{}: spectra", name)}, file));
  }
  return {};
}

Status AddLightsFile(SceneFile* file) {
  namespace fs = std::filesystem;
  const std::string path = (fs::path(FolderOf(file->path)) / "isolux.json").string();
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMostLightsBytes));
  return ParseLightsFile(text, path, file);
}

}  // namespace isolux
