#include "common/scene/light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isolux {
namespace {

constexpr uint32_t kLongestName = 1024;
constexpr double kFarthestM = 1e9;
constexpr double kLargestIntensity = 1e30;
constexpr double kLargestDisc = 0.2;
// The narrowest border of a spot, in the cosine (KHR_lights_punctual).
constexpr double kLeastBorder = 1e-3;

double Border(const Light& spot) {
  return std::max(kLeastBorder, spot.cosine_full - spot.cosine_none);
}

bool InRange(const Vec3& v, double least, double most) {
  for (int i = 0; i < 3; ++i) {
    if (!(v[i] >= least && v[i] <= most)) return false;
  }
  return true;
}

void PutVec3(ByteWriter& out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) out.Put(v[i] + 0.0);  // -0 and 0 are written alike
}

Vec3 GetVec3(ByteReader& in) {
  Vec3 v;
  for (int i = 0; i < 3; ++i) v[i] = in.Get<double>();
  return v;
}

}  // namespace

Rgb IntensityTowards(const Light& light, std::span<const Photometry> photometries,
                     const Vec3& direction) {
  if (light.kind == LightKind::kPhotometric) {
    const Photometry& table = photometries[light.photometry];
    return table.Towards(direction, light.direction, light.ahead) * light.intensity;
  }
  if (light.kind != LightKind::kSpot) return light.intensity;
  const double cosine = glm::dot(direction, light.direction);
  const double share = std::clamp((cosine - light.cosine_none) / Border(light), 0.0, 1.0);
  return share * share * light.intensity;
}

Rgb LargestIntensity(const Light& light, std::span<const Photometry> photometries) {
  if (light.kind != LightKind::kPhotometric) return light.intensity;
  return photometries[light.photometry].Largest() * light.intensity;
}

// Of a spot: ∫ over the cosine of the square of what grows evenly over the border.
Rgb PowerOf(const Light& light, std::span<const Photometry> photometries) {
  if (light.kind == LightKind::kPhotometric) {
    return photometries[light.photometry].Power() * light.intensity;
  }
  if (light.kind == LightKind::kPoint) return 4 * std::numbers::pi * light.intensity;
  const double border = Border(light);
  const double cone = std::max(0.0, 1 - (light.cosine_none + border)) + border / 3;
  return 2 * std::numbers::pi * cone * light.intensity;
}

Status CheckLight(const Light& light, std::span<const Photometry> photometries, size_t number) {
  const auto fail = [&](const char* what) {
    return MakeStatus(StatusCode::kInvalidArgument, "light {} '{}': {}", number, light.name, what);
  };
  if (light.kind > LightKind::kPhotometric) return fail("of an unknown kind");
  if (!InRange(light.position_m, -kFarthestM, kFarthestM))
    return fail("its position is not a point within 1e9 m");
  if (!InRange(light.intensity, 0, kLargestIntensity)) {
    return fail("its intensity is negative, too large or not a number");
  }
  if (!(std::abs(glm::length(light.direction) - 1) < 1e-9)) {
    return fail("its direction is not of length 1");
  }
  if (!(light.cosine_none >= -1 && light.cosine_none <= light.cosine_full &&
        light.cosine_full <= 1)) {
    return fail("the inner angle of its cone must not be larger than the outer one");
  }
  if (light.kind == LightKind::kPhotometric) {
    if (light.photometry >= photometries.size()) return fail("its photometric table is missing");
    if (!(std::abs(glm::length(light.ahead) - 1) < 1e-9 &&
          std::abs(glm::dot(light.ahead, light.direction)) < 1e-9)) {
      return fail("its direction ahead is not across its axis and of length 1");
    }
  }
  if (!(light.disc_radius >= 0 && light.disc_radius <= kLargestDisc) ||
      (light.is_sun() && light.kind != LightKind::kDirectional)) {
    return fail("a disc that is too large, or not of a directional light");
  }
  return {};
}

void Put(ByteWriter& out, const Light& light) {
  out.PutText(std::string_view(light.name).substr(0, kLongestName));
  out.Put(static_cast<uint8_t>(light.kind));
  PutVec3(out, light.position_m);
  PutVec3(out, light.direction);
  PutVec3(out, light.intensity);
  out.Put(light.cosine_full + 0.0);
  out.Put(light.cosine_none + 0.0);
  out.Put(light.disc_radius + 0.0);
  out.Put(light.photometry);
  PutVec3(out, light.ahead);
}

Light GetLight(ByteReader& in) {
  Light light;
  light.name = in.GetText(kLongestName);
  light.kind = static_cast<LightKind>(in.Get<uint8_t>());
  light.position_m = GetVec3(in);
  light.direction = GetVec3(in);
  light.intensity = GetVec3(in);
  light.cosine_full = in.Get<double>();
  light.cosine_none = in.Get<double>();
  light.disc_radius = in.Get<double>();
  light.photometry = in.Get<uint32_t>();
  light.ahead = GetVec3(in);
  return light;
}

}  // namespace isolux
