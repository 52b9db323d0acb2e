#include "client/import/lights_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "client/import/text_file.h"
#include "common/util/file.h"

namespace isolux {
namespace {

using Json = nlohmann::json;

constexpr uint64_t kMostBytes = 16 << 20;
constexpr int kDeepest = 16;

// An object of the file by its place in it: "lights[2]".
struct Element {
  const Json& json;
  std::string where;  // with the file's name

  template <typename... Args>
  internal::Failure Error(fmt::format_string<Args...> format, Args&&... args) const {
    return {MakeStatus(StatusCode::kInvalidArgument, "{}: {}", where,
                       fmt::format(format, std::forward<Args>(args)...))};
  }

  Status CheckKeys(std::initializer_list<std::string_view> known) const {
    if (!json.is_object()) return Error("not an object; write {{…}}");
    for (const auto& item : json.items()) {
      if (std::find(known.begin(), known.end(), item.key()) == known.end()) {
        return Error("there is no key '{}' here: choose among {}", item.key(),
                     fmt::join(known, ", "));
      }
    }
    return {};
  }

  Result<double> Number(const char* key, std::optional<double> missing, double least,
                        double most) const {
    const auto found = json.find(key);
    if (found == json.end() && missing) return *missing;
    if (found != json.end() && found->is_number()) {
      const double value = found->get<double>();
      if (value >= least && value <= most) return value;
    }
    return Error("\"{}\" must be a number from {} to {}", key, least, most);
  }

  Result<Vec3> Vector(const char* key) const {
    const auto found = json.find(key);
    Vec3 result(0.0);
    bool good = found != json.end() && found->is_array() && found->size() == 3;
    for (int i = 0; good && i < 3; ++i) {
      good = (*found)[i].is_number();
      if (good) result[i] = (*found)[i].get<double>();
      good = good && std::isfinite(result[i]);
    }
    if (good) return result;
    return Error("\"{}\" must be three numbers, like [0, 1, 0]", key);
  }

  Result<Vec3> Direction(const char* key) const {
    ASSIGN_OR_RETURN(const Vec3 v, Vector(key));
    const double length = glm::length(v);
    if (length > 1e-150 && length < 1e150) return v / length;
    return Error("\"{}\" has no length; give it one", key);
  }

  // Three numbers, or one for all channels.
  Result<Rgb> Colour(const char* key) const {
    constexpr double kMost = 1e30;
    if (const auto found = json.find(key); found != json.end() && found->is_number()) {
      ASSIGN_OR_RETURN(const double value, Number(key, {}, 0, kMost));
      return Rgb(value);
    }
    ASSIGN_OR_RETURN(const Rgb colour, Vector(key));
    for (int c = 0; c < 3; ++c) {
      if (!(colour[c] >= 0 && colour[c] <= kMost)) {
        return Error("\"{}\" must be 0 or more, one number or three", key);
      }
    }
    return colour;
  }
};

double Cosine(double degrees) { return std::cos(degrees * std::numbers::pi / 180); }

Status ReadSpot(const Element& element, Light* light) {
  ASSIGN_OR_RETURN(const double outer, element.Number("outer_angle", 45, 0, 90));
  ASSIGN_OR_RETURN(const double inner, element.Number("inner_angle", 0, 0, outer));
  light->kind = LightKind::kSpot;
  light->cosine_full = Cosine(inner);
  light->cosine_none = Cosine(outer);
  return {};
}

Result<Light> ReadLight(const Element& element) {
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
  } else {
    return element.Error("\"type\" must be one of \"point\", \"spot\", \"directional\"");
  }
  return light;
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
  const Element whole{json, name};
  RETURN_IF_ERROR(whole.CheckKeys({"lights"}));
  const auto lights = json.find("lights");
  if (lights == json.end()) return {};
  if (!lights->is_array()) return whole.Error("\"lights\" must be a list, like [{{…}}, {{…}}]");
  const size_t most = SceneLimits().lights;
  if (lights->size() > most) return whole.Error("more than {} lights; leave some out", most);
  for (size_t i = 0; i < lights->size(); ++i) {
    ASSIGN_OR_RETURN(const Light light,
                     ReadLight({(*lights)[i], fmt::format("{}: lights[{}]", name, i)}));
    file->lights.push_back(light);
  }
  return {};
}

Status AddLightsFile(SceneFile* file) {
  namespace fs = std::filesystem;
  const std::string path = (fs::path(FolderOf(file->path)) / "isolux.json").string();
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMostBytes));
  return ParseLightsFile(text, path, file);
}

}  // namespace isolux
