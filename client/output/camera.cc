#include "client/output/camera.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <vector>

#include "common/util/file.h"
#include "common/util/random.h"

namespace isolux {
namespace {

using Json = nlohmann::json;

constexpr uint64_t kMostBytes = 1 << 20;

Result<Vec3> GetVector(const Json& json, const std::string& key, const std::string& name) {
  const auto it = json.find(key);
  const auto error = [&] {
    return Error(StatusCode::kInvalidArgument, "{}: \"{}\" must be three numbers, like [0, 1, 0]",
                 name, key);
  };
  if (it == json.end() || !it->is_array() || it->size() != 3) return error();
  Vec3 result;
  for (int d = 0; d < 3; ++d) {
    if (!(*it)[d].is_number()) return error();
    result[d] = (*it)[d].get<double>();
    if (!std::isfinite(result[d])) return error();
  }
  return result;
}

Result<int> GetPixels(const Json& json, const std::string& key, const std::string& name,
                      int otherwise) {
  const auto it = json.find(key);
  if (it == json.end()) return otherwise;
  const double value = it->is_number() ? it->get<double>() : 0;
  if (!(value >= 1 && value <= Camera::kMostPixelsASide) || value != std::floor(value)) {
    return Error(StatusCode::kInvalidArgument, "{}: \"{}\" must be a whole number from 1 to {}",
                 name, key, Camera::kMostPixelsASide);
  }
  return static_cast<int>(value);
}

Status CheckView(const Camera& camera, const std::string& name) {
  const Vec3 forward = camera.target - camera.eye;
  const double size = std::max({glm::length(camera.eye), glm::length(camera.target), 1e-300});
  if (!(glm::length(forward) > 1e-12 * size)) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: \"eye\" and \"target\" are the same point; move one", name);
  }
  if (!(glm::length(glm::cross(glm::normalize(forward), camera.up)) >
        1e-6 * glm::length(camera.up))) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: \"up\" is zero or along the line of sight; choose another", name);
  }
  return {};
}

// --- The guess.

constexpr double kGuessFov = 60;
constexpr double kEyeHeight = 0.55;  // of the room's height
constexpr double kOpenShare = 0.75;  // of rays through a side that must get out for it to be open
constexpr uint64_t kGuessSeed = 0x15011;

// Height of the lamps along each axis, from -1 (low end) to 1 (high end); each counts by its power
// and by how far it faces along the axis.
Vec3 LampHeight(const PatchScene& scene) {
  const PatchFile& file = scene.file();
  const Vec3 centre = scene.bounds().Centre();
  const Vec3 half = glm::max(0.5 * scene.bounds().Extent(), Vec3(1e-300));
  Vec3 height(0.0);
  double power = 0;
  for (const PatchFace& face : file.faces) {
    const double emission =
        static_cast<double>(face.emission[0]) + face.emission[1] + face.emission[2];
    if (!(emission > 0)) continue;
    const Vec3 origin = file.vertices[face.vertices[0]].position;
    Vec3 area(0.0);
    for (size_t i = 1; i + 1 < face.vertices.size(); ++i) {
      area += glm::cross(file.vertices[face.vertices[i]].position - origin,
                         file.vertices[face.vertices[i + 1]].position - origin);
    }
    height += emission * glm::abs(area) * ((origin - centre) / half);
    power += emission * glm::length(area);
  }
  return power > 0 ? height / power : Vec3(0.0);
}

// y, unless lamps hang high along z and the scene is lower than deep.
int UpAxis(const PatchScene& scene) {
  constexpr double kHigh = 0.5, kClearly = 0.25;
  const Vec3 lamps = LampHeight(scene), extent = scene.bounds().Extent();
  return lamps.z > kHigh && lamps.z > lamps.y + kClearly && extent.z < extent.y ? 2 : 1;
}

Vec3 Axis(int axis) {
  Vec3 v(0.0);
  v[axis] = 1;
  return v;
}

// Share of rays from the middle of the room through this side that meet nothing. They start halfway
// to it: what stands in the room does not close it.
double OpenShare(const PatchScene& scene, int axis, double sign) {
  const Vec3 centre = scene.bounds().Centre(), extent = scene.bounds().Extent();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Random random(Hash(kGuessSeed, static_cast<uint64_t>(axis), sign > 0 ? 1 : 0));
  constexpr int kRays = 256;
  int out = 0;
  for (int i = 0; i < kRays; ++i) {
    Vec3 from = centre, to = centre;
    from[axis] += sign * 0.25 * extent[axis];
    from[u] += 0.5 * extent[u] * (random.Unit() - 0.5);
    from[v] += 0.5 * extent[v] * (random.Unit() - 0.5);
    to[axis] += sign * 0.5 * extent[axis];
    to[u] += 0.9 * extent[u] * (random.Unit() - 0.5);
    to[v] += 0.9 * extent[v] * (random.Unit() - 0.5);
    if (!scene.Cast(from, to - from, true).has_value()) ++out;
  }
  return static_cast<double>(out) / kRays;
}

// In front of the open side, far enough back that it fills the picture.
Camera OutsideCamera(const PatchScene& scene, int up, int axis, double sign) {
  const Vec3 centre = scene.bounds().Centre(), extent = scene.bounds().Extent();
  const int side = 3 - up - axis;
  Camera camera;
  const double aspect = std::clamp(extent[side] / extent[up], 0.5, 2.0);
  camera.height = 960;
  camera.width = static_cast<int>(std::lround(camera.height * aspect));
  camera.fov_y_deg = kGuessFov;
  const double half_tangent = std::tan(0.5 * kGuessFov * std::numbers::pi / 180);
  const double half = 0.5 * std::max(extent[up], extent[side] / aspect);
  camera.up = Axis(up);
  camera.target = centre;
  camera.eye = centre + sign * (0.5 * extent[axis] + 1.04 * half / half_tangent) * Axis(axis);
  return camera;
}

// Calls look(direction) for rays spread over the picture; returns how many.
template <typename Look>
int LookAround(const Camera& camera, const Look& look) {
  constexpr int kColumns = 12, kRows = 9;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      look(glm::normalize(camera.Direction((x + 0.5) * camera.width / kColumns,
                                           (y + 0.5) * camera.height / kRows)));
    }
  }
  return kColumns * kRows;
}

// Share of the picture that is not background.
double LitShare(const PatchScene& scene, const Camera& camera) {
  double lit = 0;
  const int rays = LookAround(camera, [&](const Vec3& direction) {
    if (scene.Cast(camera.eye, direction).has_value()) ++lit;
  });
  return lit / rays;
}

// How much of the scene a view shows: rays that meet lit sides, far rather than near, and many
// different polygons; little where the eye is inside or behind something.
double ViewValue(const PatchScene& scene, const Camera& camera) {
  constexpr double kTwins = 1e-4;   // the sides of one polygon may be hit this far apart
  constexpr double kVariety = 1.5;  // a polygon more is worth this many rays of a diagonal's length
  double value = 0;
  std::set<uint32_t> polygons;
  const int rays = LookAround(camera, [&](const Vec3& direction) {
    const auto nearest = scene.Cast(camera.eye, direction, true);
    if (!nearest.has_value()) return;
    const auto hit = scene.Cast(camera.eye, direction);
    if (!hit.has_value() || hit->distance > nearest->distance * (1 + kTwins)) {
      value -= 1;
      return;
    }
    value += std::min(1.0, hit->distance / scene.bounds().Diagonal());
    polygons.insert(scene.file().faces[hit->face].polygon);
  });
  return (value + kVariety * static_cast<double>(polygons.size())) / rays;
}

Camera InsideCamera(const PatchScene& scene, int up) {
  const Bounds3& bounds = scene.bounds();
  const Vec3 extent = bounds.Extent();
  Camera best;
  double best_value = -2;
  Random random(kGuessSeed);
  const std::array<int, 2> horizontal{up == 1 ? 0 : 1, up == 1 ? 2 : 0};
  for (int i = 0; i < 512; ++i) {
    Camera camera;
    camera.fov_y_deg = kGuessFov;
    camera.up = Axis(up);
    camera.eye = bounds.low + Vec3(0.04 + 0.92 * random.Unit(), 0.04 + 0.92 * random.Unit(),
                                   0.04 + 0.92 * random.Unit()) *
                                  extent;
    camera.eye[up] = bounds.low[up] + kEyeHeight * extent[up];
    // Along one of the horizontal axes, turned a little.
    const double angle = 0.5 * std::numbers::pi * (i % 4) + 0.6 * (random.Unit() - 0.5);
    camera.target = camera.eye;
    camera.target[horizontal[0]] += std::cos(angle) * bounds.Diagonal();
    camera.target[horizontal[1]] += std::sin(angle) * bounds.Diagonal();
    const double value = ViewValue(scene, camera);
    if (value > best_value) {
      best_value = value;
      best = camera;
    }
  }
  return best;
}

}  // namespace

Vec3 Camera::Direction(double x, double y) const {
  const Vec3 forward = glm::normalize(target - eye);
  const Vec3 right = glm::normalize(glm::cross(forward, up));
  const Vec3 above = glm::cross(right, forward);
  const double half = std::tan(0.5 * fov_y_deg * std::numbers::pi / 180);
  return forward + half * ((2 * x - width) / height * right + (height - 2 * y) / height * above);
}

Result<Camera> ParseCamera(const std::string& json_text, const std::string& name) {
  Json json;
  try {
    json = Json::parse(json_text);
  } catch (const Json::parse_error& error) {
    const size_t end = std::min<size_t>(error.byte, json_text.size());
    const auto line = 1 + std::count(json_text.begin(),
                                     json_text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    return Error(StatusCode::kInvalidArgument, "{}:{}: not JSON: {}", name, line, error.what());
  } catch (const Json::exception& error) {
    return Error(StatusCode::kInvalidArgument, "{}: not JSON: {}", name, error.what());
  }
  if (!json.is_object()) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: a camera is an object with \"eye\" and \"target\"", name);
  }
  for (const auto& item : json.items()) {
    const std::vector<std::string> known{"eye",   "target", "up",  "fov_y_deg",
                                         "width", "height", "note"};
    if (std::find(known.begin(), known.end(), item.key()) == known.end()) {
      return Error(StatusCode::kInvalidArgument,
                   "{}: \"{}\" is no key of a camera; there are eye, target, up, fov_y_deg, width, "
                   "height, note",
                   name, item.key());
    }
  }
  Camera camera;
  ASSIGN_OR_RETURN(camera.eye, GetVector(json, "eye", name));
  ASSIGN_OR_RETURN(camera.target, GetVector(json, "target", name));
  if (json.contains("up")) {
    ASSIGN_OR_RETURN(camera.up, GetVector(json, "up", name));
  }
  if (const auto it = json.find("fov_y_deg"); it != json.end()) {
    camera.fov_y_deg = it->is_number() ? it->get<double>() : 0;
    if (!(camera.fov_y_deg >= 0.01 && camera.fov_y_deg <= 175)) {
      return Error(StatusCode::kInvalidArgument,
                   "{}: \"fov_y_deg\" must be a number of degrees from 0.01 to 175", name);
    }
  }
  ASSIGN_OR_RETURN(camera.width, GetPixels(json, "width", name, camera.width));
  ASSIGN_OR_RETURN(camera.height, GetPixels(json, "height", name, camera.height));
  RETURN_IF_ERROR(CheckView(camera, name));
  return camera;
}

Result<Camera> ReadCamera(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string json, ReadFile(path, kMostBytes));
  return ParseCamera(json, path);
}

Camera GuessCamera(const PatchScene& scene, int up) {
  if (up == 0) up = UpAxis(scene);
  int open_axis = -1;
  double open_sign = 0, open_share = kOpenShare;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == up) continue;
    for (const double sign : {1.0, -1.0}) {
      const double share = OpenShare(scene, axis, sign);
      if (share > open_share) {
        open_axis = axis;
        open_sign = sign;
        open_share = share;
      }
    }
  }
  if (open_axis >= 0) {
    const Camera camera = OutsideCamera(scene, up, open_axis, open_sign);
    if (LitShare(scene, camera) > kOpenShare) return camera;
  }
  return InsideCamera(scene, up);
}

}  // namespace isolux
