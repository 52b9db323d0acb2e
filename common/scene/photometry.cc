#include "common/scene/photometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/angles.h"

namespace isolux {
namespace {

constexpr uint32_t kLongestName = 1024;
constexpr float kLargestIntensity = 1e30F;
constexpr double kDegree = std::numbers::pi / 180;

// Where an angle lies among ascending ones: the place before it, and how far on to the next.
struct Place {
  size_t before = 0;
  double share = 0;
};

Place PlaceOf(const std::vector<float>& angles, double angle) {
  if (angles.size() < 2 || angle <= angles.front()) return {};
  const auto next = std::upper_bound(angles.begin(), angles.end() - 1, static_cast<float>(angle));
  const auto before = static_cast<size_t>(next - angles.begin()) - 1;
  const double width = angles[before + 1] - angles[before];
  return {before, std::clamp((angle - angles[before]) / width, 0.0, 1.0)};
}

bool Ascend(const std::vector<float>& angles) {
  return std::is_sorted(angles.begin(), angles.end(), [](float a, float b) { return !(a > b); });
}

// ∫ (a + b (t − t0)) sin t dt from t0 to t1, the intensity going from a to a + b (t1 − t0).
double Ring(double t0, double t1, double first, double last) {
  const double slope = (last - first) / (t1 - t0);
  return first * std::cos(t0) - last * std::cos(t1) + slope * (std::sin(t1) - std::sin(t0));
}

}  // namespace

double Photometry::Towards(const Vec3& direction, const Vec3& axis, const Vec3& ahead) const {
  const double polar =
      Angle(glm::length(glm::cross(axis, direction)), glm::dot(axis, direction)) / kDegree;
  constexpr double kRounding = 1e-4;
  if (polar < from_axis.front() - kRounding || polar > from_axis.back() + kRounding) return 0;
  double turn = 0;
  if (around.size() > 1) {
    // Counter-clockwise for who looks along the axis from the far end of its light.
    turn =
        Angle(glm::dot(glm::cross(-axis, ahead), direction), glm::dot(ahead, direction)) / kDegree;
    if (turn < 0) turn = around.back() > 180 ? turn + 360 : -turn;
    if (around.back() <= 90 && turn > 90) turn = 180 - turn;
  }
  const Place row = PlaceOf(around, turn), column = PlaceOf(from_axis, polar);
  const auto at = [&](size_t i, size_t k) {
    const size_t y = std::min(i, around.size() - 1), x = std::min(k, from_axis.size() - 1);
    return static_cast<double>(intensity[y * from_axis.size() + x]);
  };
  const auto along = [&](size_t i) {
    return (1 - column.share) * at(i, column.before) + column.share * at(i, column.before + 1);
  };
  return (1 - row.share) * along(row.before) + row.share * along(row.before + 1);
}

double Photometry::Largest() const {
  return intensity.empty() ? 0.0 : *std::max_element(intensity.begin(), intensity.end());
}

double Photometry::Power() const {
  const size_t columns = from_axis.size();
  const auto power_of = [&](size_t row) {  // for each radian around
    double sum = 0;
    for (size_t k = 0; k + 1 < columns; ++k) {
      sum += Ring(kDegree * from_axis[k], kDegree * from_axis[k + 1], intensity[row * columns + k],
                  intensity[row * columns + k + 1]);
    }
    return sum;
  };
  if (around.size() == 1) return 2 * std::numbers::pi * power_of(0);
  double sum = 0;
  for (size_t row = 0; row + 1 < around.size(); ++row) {
    const double share = (around[row + 1] - around[row]) / around.back();
    sum += share * 0.5 * (power_of(row) + power_of(row + 1));
  }
  return 2 * std::numbers::pi * sum;
}

Status CheckPhotometry(const Photometry& photometry) {
  const auto fail = [&](const char* what) {
    return MakeStatus(StatusCode::kInvalidArgument, "photometry '{}': {}", photometry.name, what);
  };
  const auto& [name, from_axis, around, intensity] = photometry;
  if (from_axis.size() < 2 || from_axis.size() > Photometry::kMostAngles || around.empty() ||
      around.size() > Photometry::kMostAngles) {
    return fail("it must have from 2 to 3,601 vertical and from 1 to 3,601 horizontal angles");
  }
  if (!Ascend(from_axis) || !Ascend(around)) return fail("its angles do not ascend");
  if (!(from_axis.front() >= 0 && from_axis.back() <= 180)) {
    return fail("its vertical angles are not from 0 to 180 degrees");
  }
  const float last = around.back();
  if (around.front() != 0 || (last != 0 && last != 90 && last != 180 && last != 360) ||
      (last == 0) != (around.size() == 1)) {
    return fail("its horizontal angles do not go from 0 to 0, 90, 180 or 360 degrees");
  }
  if (intensity.size() != from_axis.size() * around.size()) {
    return fail("it has not as many intensities as angles");
  }
  const auto in_range = [](float value) { return value >= 0 && value <= kLargestIntensity; };
  if (!std::all_of(intensity.begin(), intensity.end(), in_range)) {
    return fail("an intensity is negative, too large or not a number");
  }
  return {};
}

void Put(ByteWriter& out, const Photometry& photometry) {
  out.PutText(std::string_view(photometry.name).substr(0, kLongestName));
  out.Put(static_cast<uint32_t>(photometry.from_axis.size()));
  out.Put(static_cast<uint32_t>(photometry.around.size()));
  for (const auto* numbers : {&photometry.from_axis, &photometry.around, &photometry.intensity}) {
    for (const float number : *numbers) out.Put(number + 0.0F);
  }
}

Photometry GetPhotometry(ByteReader& in) {
  Photometry photometry;
  photometry.name = in.GetText(kLongestName);
  const auto columns = in.Get<uint32_t>(), rows = in.Get<uint32_t>();
  if (columns > Photometry::kMostAngles || rows > Photometry::kMostAngles) return photometry;
  const uint64_t count = static_cast<uint64_t>(columns) * rows;
  if (!in.Holds(count + columns + rows, sizeof(float))) return photometry;
  photometry.from_axis.resize(columns);
  photometry.around.resize(rows);
  photometry.intensity.resize(count);
  for (auto* numbers : {&photometry.from_axis, &photometry.around, &photometry.intensity}) {
    for (float& number : *numbers) number = in.Get<float>();
  }
  return photometry;
}

}  // namespace isolux
