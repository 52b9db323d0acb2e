#include "client/output/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "client/output/interpolate.h"
#include "common/util/random.h"

namespace isolux {
namespace {

constexpr int kTile = 16;              // pixels a side; a thread's piece of work
constexpr double kRetryPixels = 0.01;  // a ray that meets nothing tries again this far beside
constexpr int kMeteringSide = 192;     // rays a side by which the exposure is metered
constexpr double kMeteredShare = 0.95;

// The Reinhard curve with a white point: L (1 + L/w²) / (1 + L), which is 1 at L = w.
constexpr double kReinhardMetered = 1.5;  // L of the metered luminance: shows as 0.66 linear
constexpr double kReinhardWhite = 4.0;
constexpr double kLinearMetered = 0.8;

double Luminance(const Rgb& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// Shades points of faces. One a thread: keeps its buffers.
class Shader {
 public:
  explicit Shader(const PatchScene& scene) : scene_(scene) {}

  // Radiance along a ray; black where it meets nothing.
  Rgb Radiance(const PatchHit& hit) {
    const PatchFile& file = scene_.file();
    const std::vector<uint32_t>& vertices = file.faces[hit.face].vertices;
    corners_.clear();
    for (const uint32_t v : vertices) corners_.push_back(file.vertices[v].position);
    weights_.resize(vertices.size());
    MeanValueWeights(corners_, hit.position, weights_);
    Rgb radiosity(0.0);
    for (size_t k = 0; k < vertices.size(); ++k) {
      const std::array<float, 3>& b = file.vertices[vertices[k]].radiosity;
      radiosity += weights_[k] * Rgb(b[0], b[1], b[2]);
    }
    return radiosity / std::numbers::pi;
  }

 private:
  const PatchScene& scene_;
  std::vector<Vec3> corners_;
  std::vector<double> weights_;
};

// Walls that meet at an angle share no vertices: where their sides are divided differently,
// rounding leaves gaps of the width of a float. A ray that falls through one tries again beside it.
std::optional<PatchHit> CastThrough(const PatchScene& scene, const Camera& camera, double x,
                                    double y) {
  constexpr std::array<std::array<double, 2>, 5> kOffsets{
      {{0, 0}, {1, 0.5}, {-0.5, 1}, {-1, -0.5}, {0.5, -1}}};
  for (const auto& offset : kOffsets) {
    const auto hit = scene.Cast(
        camera.eye, camera.Direction(x + kRetryPixels * offset[0], y + kRetryPixels * offset[1]));
    if (hit.has_value()) return hit;
  }
  return std::nullopt;
}

Rgb RenderPixel(const PatchScene& scene, const Camera& camera, const RenderOptions& options, int x,
                int y, const Colouring& colouring, const Rgb& background) {
  // The R2 sequence [Roberts18], the same in all pixels: straight edges come out even.
  constexpr double kR2X = 0.7548776662466927, kR2Y = 0.5698402909980532;
  Random random(options.seed);
  const double shift_x = random.Unit(), shift_y = random.Unit();
  Rgb sum(0.0);
  for (int s = 0; s < options.samples; ++s) {
    const double u = shift_x + kR2X * s, v = shift_y + kR2Y * s;
    const auto hit = CastThrough(scene, camera, x + u - std::floor(u), y + v - std::floor(v));
    Rgb radiance = hit.has_value() ? colouring(*hit) : background;
    const double luminance = Luminance(radiance);
    if (options.brightest > 0 && luminance > options.brightest) {
      radiance *= options.brightest / luminance;
    }
    sum += radiance;
  }
  return sum / static_cast<double>(options.samples);
}

double Curve(double x, ToneMap tone_map) {
  switch (tone_map) {
    case ToneMap::kReinhard:
      return x * (1 + x / (kReinhardWhite * kReinhardWhite)) / (1 + x);
    case ToneMap::kLinear:
      return x;
  }
  return x;
}

double EncodeSrgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// The curve on each channel: bright colours pale smoothly towards white, without the edge that a
// limit on saturation would draw.
Rgb MapTone(const Rgb& radiance, const Exposure& exposure) {
  Rgb shown(0.0);
  for (int c = 0; c < 3; ++c) {
    shown[c] = std::clamp(Curve(exposure.scale * radiance[c], exposure.tone_map), 0.0, 1.0);
  }
  return shown;
}

}  // namespace

Image Render(const PatchScene& scene, const Camera& camera, const RenderOptions& options,
             ThreadPool& pool) {
  const auto radiance = [&scene] {
    return [shader = Shader(scene)](const PatchHit& hit) mutable { return shader.Radiance(hit); };
  };
  return RenderColours(scene, camera, options, radiance, Rgb(0.0), pool);
}

Image RenderColours(const PatchScene& scene, const Camera& camera, const RenderOptions& options,
                    const std::function<Colouring()>& make, const Rgb& background,
                    ThreadPool& pool) {
  Image image{camera.width, camera.height, {}};
  image.rgb.assign(3 * static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height), 0);
  const int columns = (camera.width + kTile - 1) / kTile,
            rows = (camera.height + kTile - 1) / kTile;
  const auto tiles = static_cast<size_t>(columns) * static_cast<size_t>(rows);
  pool.For(tiles, 1, [&](size_t begin, size_t end, int) {
    const Colouring colouring = make();
    for (size_t tile = begin; tile < end; ++tile) {
      const int x0 = kTile * static_cast<int>(tile % static_cast<size_t>(columns));
      const int y0 = kTile * static_cast<int>(tile / static_cast<size_t>(columns));
      for (int y = y0; y < std::min(y0 + kTile, camera.height); ++y) {
        for (int x = x0; x < std::min(x0 + kTile, camera.width); ++x) {
          const Rgb radiance = RenderPixel(scene, camera, options, x, y, colouring, background);
          float* pixel =
              &image.rgb[3 * (static_cast<size_t>(y) * static_cast<size_t>(camera.width) +
                              static_cast<size_t>(x))];
          for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(radiance[c]);
        }
      }
    }
  });
  return image;
}

Result<ToneMap> ParseToneMap(const std::string& text) {
  if (text == "reinhard") return ToneMap::kReinhard;
  if (text == "linear") return ToneMap::kLinear;
  return Error(StatusCode::kInvalidArgument, "no tone map '{}'; there are reinhard and linear",
               text);
}

double Exposure::WhiteLuminance() const {
  return (tone_map == ToneMap::kReinhard ? kReinhardWhite : 1.0) / scale;
}

Exposure AutoExposure(const PatchScene& scene, const Camera& camera, ToneMap tone_map,
                      double stops) {
  Shader shader(scene);
  std::vector<double> lit, lamps;
  for (int y = 0; y < kMeteringSide; ++y) {
    for (int x = 0; x < kMeteringSide; ++x) {
      const auto hit =
          scene.Cast(camera.eye, camera.Direction((x + 0.5) * camera.width / kMeteringSide,
                                                  (y + 0.5) * camera.height / kMeteringSide));
      if (!hit.has_value()) continue;
      const double luminance = Luminance(shader.Radiance(*hit));
      const std::array<float, 3>& emission = scene.file().faces[hit->face].emission;
      if (luminance > 0)
        (emission[0] + emission[1] + emission[2] > 0 ? lamps : lit).push_back(luminance);
    }
  }
  std::vector<double>& seen = lit.empty() ? lamps : lit;
  Exposure exposure;
  exposure.tone_map = tone_map;
  if (seen.empty()) return exposure;
  const auto place = static_cast<std::ptrdiff_t>(kMeteredShare * static_cast<double>(seen.size()));
  std::nth_element(seen.begin(), seen.begin() + place, seen.end());
  const double target = tone_map == ToneMap::kReinhard ? kReinhardMetered : kLinearMetered;
  exposure.scale = target / seen[static_cast<size_t>(place)] * std::exp2(stops);
  return exposure;
}

std::vector<uint8_t> ToDisplay(const Image& image, const Exposure& exposure) {
  std::vector<uint8_t> bytes(image.rgb.size());
  for (size_t i = 0; i < image.rgb.size(); i += 3) {
    const Rgb colour = MapTone(Rgb(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]), exposure);
    for (int c = 0; c < 3; ++c) {
      // Triangular noise of one step. Black and white stay as they are.
      const double noise = ToUnit(Hash(i, static_cast<uint64_t>(c), 1)) +
                           ToUnit(Hash(i, static_cast<uint64_t>(c), 2)) - 1;
      const double value = 255 * EncodeSrgb(colour[c]);
      const bool ends = value < 0.5 || value > 254.5;
      bytes[i + static_cast<size_t>(c)] = static_cast<uint8_t>(
          std::clamp(std::floor(value + 0.5 + (ends ? 0.0 : 0.5 * noise)), 0.0, 255.0));
    }
  }
  return bytes;
}

}  // namespace isolux
