#include "common/scene/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/angles.h"

namespace isolux {
namespace {

constexpr uint32_t kLongestName = 1024;
constexpr float kLargestRadiance = 1e30F;

bool IsUnit(const Vec3& v) { return std::abs(glm::length(v) - 1) < 1e-9; }

}  // namespace

Rgb Sky::RadianceFrom(const Vec3& direction) const {
  const double height = 0.5 * (1 - glm::dot(direction, up)) * rows;
  const auto row = static_cast<uint32_t>(std::clamp(height, 0.0, rows - 1.0));
  if (columns == 1) return Texel(0, row);
  const double angle =
      Angle(glm::dot(direction, glm::cross(up, ahead)), glm::dot(direction, ahead));
  const double turn = angle / (2 * std::numbers::pi);
  const double place = (turn < 0 ? turn + 1 : turn) * columns;
  return Texel(static_cast<uint32_t>(std::clamp(place, 0.0, columns - 1.0)), row);
}

Rgb Sky::MeanRadiance() const {
  Rgb sum(0.0);
  for (size_t i = 0; i + 2 < texels.size(); i += 3) {
    sum += Rgb(texels[i], texels[i + 1], texels[i + 2]);
  }
  return texels.empty() ? sum : sum / (static_cast<double>(texels.size()) / 3);
}

Status CheckSky(const Sky& sky) {
  const auto fail = [](const char* what) {
    return MakeStatus(StatusCode::kInvalidArgument, "sky: {}", what);
  };
  if (sky.columns > Sky::kMostColumns || sky.rows > Sky::kMostRows ||
      (sky.columns == 0) != (sky.rows == 0)) {
    return fail("more columns or rows than 4,096 times 2,048, or none");
  }
  if (sky.texels.size() != 3ULL * sky.columns * sky.rows) return fail("not as many texels as said");
  const auto in_range = [](float value) { return value >= 0 && value <= kLargestRadiance; };
  if (!std::all_of(sky.texels.begin(), sky.texels.end(), in_range)) {
    return fail("a radiance is negative, too large or not a number");
  }
  if (!IsUnit(sky.up) || !IsUnit(sky.ahead) || !(std::abs(glm::dot(sky.up, sky.ahead)) < 1e-9)) {
    return fail("its axes are not orthogonal and of length 1");
  }
  return {};
}

void Put(ByteWriter& out, const Sky& sky) {
  out.PutText(std::string_view(sky.name).substr(0, kLongestName));
  out.Put(sky.columns);
  out.Put(sky.rows);
  for (const Vec3* axis : {&sky.up, &sky.ahead}) {
    for (int i = 0; i < 3; ++i) out.Put((*axis)[i] + 0.0);
  }
  for (const float value : sky.texels) out.Put(value + 0.0F);
}

Sky GetSky(ByteReader& in) {
  Sky sky;
  sky.name = in.GetText(kLongestName);
  sky.columns = in.Get<uint32_t>();
  sky.rows = in.Get<uint32_t>();
  for (Vec3* axis : {&sky.up, &sky.ahead}) {
    for (int i = 0; i < 3; ++i) (*axis)[i] = in.Get<double>();
  }
  if (sky.columns > Sky::kMostColumns || sky.rows > Sky::kMostRows) return sky;
  const uint64_t count = 3ULL * sky.columns * sky.rows;
  if (!in.Holds(count, sizeof(float))) return sky;
  sky.texels.resize(count);
  for (float& value : sky.texels) value = in.Get<float>();
  return sky;
}

}  // namespace isolux
