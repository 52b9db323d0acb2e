#include "client/output/reference_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include "common/util/file.h"

namespace isolux {
namespace {

constexpr int kNumbers = 12;
constexpr uint64_t kMostBytes = 1ULL << 32;

// Numbers of a line, separated by commas; one more comma may end it.
bool ParseLine(const char* at, const char* end, std::array<double, kNumbers>* numbers) {
  for (int i = 0; i < kNumbers; ++i) {
    char* after = nullptr;
    (*numbers)[i] = std::strtod(at, &after);
    if (after == at || after > end || !std::isfinite((*numbers)[i])) return false;
    at = after;
    if (i + 1 < kNumbers && (at >= end || *at++ != ',')) return false;
  }
  if (at < end && *at == ',') ++at;
  while (at < end && (*at == ' ' || *at == '\r')) ++at;
  return at == end;
}

}  // namespace

Result<std::vector<ReferencePoint>> ReadReferencePoints(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMostBytes));
  std::vector<ReferencePoint> points;
  const auto bad = [&](int line, const char* what) {
    return Error(StatusCode::kInvalidArgument,
                 "{}:{}: {}; each line is position, normal, irradiance and its standard error, "
                 "twelve numbers separated by commas",
                 path, line, what);
  };
  int line = 0;
  for (size_t begin = 0; begin < text.size();) {
    ++line;
    const size_t end = std::min(text.find('\n', begin), text.size());
    std::array<double, kNumbers> v{};
    if (end > begin) {
      if (!ParseLine(text.data() + begin, text.data() + end, &v)) {
        return bad(line, "not twelve numbers");
      }
      ReferencePoint point{
          {v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}, {v[9], v[10], v[11]}};
      const double length = glm::length(point.normal);
      if (!(length > 0)) return bad(line, "the normal has no length");
      if (*std::min_element(v.begin() + 6, v.end()) < 0) {
        return bad(line, "irradiance or its error is negative");
      }
      point.normal /= length;
      points.push_back(point);
    }
    begin = end + 1;
  }
  if (points.empty()) return bad(1, "there is no point in it");
  return points;
}

Status WriteReferencePoints(std::span<const ReferencePoint> points, const std::string& path) {
  std::string text;
  for (const ReferencePoint& p : points) {
    for (const Vec3& v : {p.position, p.normal, p.irradiance, p.deviation}) {
      fmt::format_to(std::back_inserter(text), "{},{},{},", v.x, v.y, v.z);
    }
    text.back() = '\n';
  }
  return WriteFileDurably(path, text);
}

}  // namespace isolux
