#include "client/output/error_map.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isolux {
namespace {

constexpr double kBackground = 0.05;  // linear: darker than the brightest colours, grey unlike all

double AreaOf(const PatchFile& file, const PatchFace& face) {
  const Vec3 origin = file.vertices[face.vertices[0]].position;
  Vec3 twice(0.0);
  for (size_t i = 1; i + 1 < face.vertices.size(); ++i) {
    twice += glm::cross(file.vertices[face.vertices[i]].position - origin,
                        file.vertices[face.vertices[i + 1]].position - origin);
  }
  return 0.5 * glm::length(twice);
}

// The value that is reached when the smallest make up a share of the whole weight.
double WeightedQuantile(const std::vector<double>& values, const std::vector<double>& weights,
                        double share) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return values[a] < values[b]; });
  double left = share * std::accumulate(weights.begin(), weights.end(), 0.0);
  for (const size_t i : order) {
    left -= weights[i];
    if (left <= 0) return values[i];
  }
  return order.empty() ? 0 : values[order.back()];
}

double Linear(uint8_t srgb) {
  const double value = srgb / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

}  // namespace

RelativeErrors FindRelativeErrors(const PatchFile& file) {
  RelativeErrors errors;
  Rgb power(0.0);
  double area = 0, error = 0;
  for (const PatchFace& face : file.faces) {
    errors.area.push_back(AreaOf(file, face));
    area += errors.area.back();
    error += errors.area.back() * face.error;
    power += errors.area.back() * Rgb(face.irradiance[0], face.irradiance[1], face.irradiance[2]);
  }
  errors.of_face.assign(file.faces.size(), 0);
  const double brightest = std::max({power.x, power.y, power.z});
  if (!(area > 0 && brightest > 0)) return errors;
  errors.mean_irradiance_w_m2 = brightest / area;
  errors.mean = error / brightest;
  for (size_t i = 0; i < file.faces.size(); ++i) {
    errors.of_face[i] = file.faces[i].error / errors.mean_irradiance_w_m2;
  }
  errors.p95 = WeightedQuantile(errors.of_face, errors.area, 0.95);
  return errors;
}

const std::array<std::array<uint8_t, 3>, 9>& FalseColours::Stops() {
  static const std::array<std::array<uint8_t, 3>, 9> stops{{{68, 1, 84},
                                                            {71, 44, 122},
                                                            {59, 81, 139},
                                                            {44, 113, 142},
                                                            {33, 144, 141},
                                                            {39, 173, 129},
                                                            {92, 200, 99},
                                                            {170, 220, 50},
                                                            {253, 231, 37}}};
  return stops;
}

Rgb FalseColours::Of(double value) const {
  const auto& stops = Stops();
  const double share =
      value > low ? std::min(std::log(value / low) / std::log(high / low), 1.0) : 0.0;
  const double place = share * static_cast<double>(stops.size() - 1);
  const size_t below = std::min(static_cast<size_t>(place), stops.size() - 2);
  const double t = place - static_cast<double>(below);
  Rgb colour(0.0);
  for (size_t c = 0; c < 3; ++c) {
    colour[static_cast<int>(c)] =
        (1 - t) * Linear(stops[below][c]) + t * Linear(stops[below + 1][c]);
  }
  return colour;
}

std::vector<uint8_t> RenderErrors(const PatchScene& scene, const Camera& camera,
                                  const RenderOptions& options, const RelativeErrors& errors,
                                  const FalseColours& colours, ThreadPool& pool) {
  std::vector<Rgb> of_face;
  for (const double error : errors.of_face) of_face.push_back(colours.Of(error));
  const Image image = RenderColours(
      scene, camera, options,
      [&of_face] { return [&of_face](const PatchHit& hit) { return of_face[hit.face]; }; },
      Rgb(kBackground), pool);
  return ToDisplay(image, {1.0, ToneMap::kLinear});
}

}  // namespace isolux
