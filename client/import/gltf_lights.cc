#include "client/import/gltf_lights.h"

#include <cmath>

namespace isolux {
namespace {

// The angles of a cone: 0 ≤ inner ≤ outer ≤ π/2.
Status SetCone(const GltfDocument& document, const std::string& element,
               const tinygltf::SpotLight& spot, Light* light) {
  const double inner = spot.innerConeAngle, outer = spot.outerConeAngle;
  if (!(inner >= 0 && inner <= outer && outer <= 1.5708)) {
    return document.Error(
        StatusCode::kInvalidArgument, element,
        "a cone from {} to {} radians; its angles must rise from 0 to at most π/2", inner, outer);
  }
  light->cosine_full = std::cos(inner);
  light->cosine_none = std::cos(outer);
  return {};
}

Result<Light> ReadLight(const GltfDocument& document, size_t number) {
  const tinygltf::Light& from = document.model.lights[number];
  const std::string element = fmt::format("extensions.KHR_lights_punctual.lights[{}]", number);
  const auto fail = [&](const char* what) {
    return document.Error(StatusCode::kInvalidArgument, element, "{}", what);
  };
  Light light;
  light.name = from.name;
  if (from.type == "point") {
    light.kind = LightKind::kPoint;
  } else if (from.type == "spot") {
    light.kind = LightKind::kSpot;
    RETURN_IF_ERROR(SetCone(document, element, from.spot, &light));
  } else if (from.type == "directional") {
    light.kind = LightKind::kDirectional;
  } else {
    return fail("its type is none of point, spot, directional; correct it");
  }
  Rgb colour(1.0);
  if (!from.color.empty()) {
    if (from.color.size() != 3) return fail("its color is not three numbers; correct it");
    colour = {from.color[0], from.color[1], from.color[2]};
  }
  light.intensity = from.intensity * colour;
  for (int c = 0; c < 3; ++c) {
    if (!(light.intensity[c] >= 0 && std::isfinite(light.intensity[c]))) {
      return fail("its color times its intensity is negative or not a number; correct it");
    }
  }
  return light;
}

}  // namespace

Result<std::vector<Light>> ReadGltfLights(const GltfDocument& document, const GltfNodes& nodes) {
  std::vector<Light> lights;
  for (const GltfLightInstance& instance : nodes.lights) {
    const size_t count = document.model.lights.size();
    if (instance.light < 0 || static_cast<size_t>(instance.light) >= count) {
      return document.Error(StatusCode::kInvalidArgument, instance.where,
                            "its light {} does not exist, the file has {}; is the file whole?",
                            instance.light, count);
    }
    ASSIGN_OR_RETURN(Light light, ReadLight(document, static_cast<size_t>(instance.light)));
    if (light.name.empty()) light.name = instance.where;
    light.position_m = Vec3(instance.to_scene[3]);
    const Vec3 axis = -Vec3(instance.to_scene[2]);  // a light shines along −z
    const double length = glm::length(axis);
    if (light.kind != LightKind::kPoint) {
      if (!(length > 0 && std::isfinite(length))) {
        return document.Error(StatusCode::kInvalidArgument, instance.where,
                              "its scale leaves its light no direction; scale it by more than 0");
      }
      light.direction = axis / length;
    }
    lights.push_back(light);
  }
  return lights;
}

}  // namespace isolux
