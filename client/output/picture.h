// Pictures of a patch file: rays from the camera, radiosity interpolated over the faces, exposure,
// tone mapping, PNG and EXR.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/output/camera.h"
#include "client/output/patch_scene.h"
#include "common/util/parallel.h"

namespace isolux {

// Radiance B/π, W/(m² sr), linear; rows from the top, red green blue.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgb;
};

struct RenderOptions {
  int samples = 16;  // rays a pixel, spread over it evenly; the filter is the pixel's square
  uint64_t seed = 1;
  // Samples brighter than this (luminance, W/(m² sr)) are dimmed to it before they are averaged, so
  // that the outline of a lamp is smooth on a display; 0: none, the physical mean.
  double brightest = 0;
};

// What a ray that meets nothing sees is black.
Image Render(const PatchScene& scene, const Camera& camera, const RenderOptions& options,
             ThreadPool& pool);

// The same view in other colours (linear): `make` gives each thread the colouring of its hits.
using Colouring = std::function<Rgb(const PatchHit&)>;
Image RenderColours(const PatchScene& scene, const Camera& camera, const RenderOptions& options,
                    const std::function<Colouring()>& make, const Rgb& background,
                    ThreadPool& pool);

enum class ToneMap { kReinhard, kLinear };
Result<ToneMap> ParseToneMap(const std::string& text);  // reinhard|linear

// How radiance becomes a display's value: radiance × scale through the curve, then sRGB.
struct Exposure {
  double scale = 1;
  ToneMap tone_map = ToneMap::kReinhard;

  // Luminance that shows as full white.
  double WhiteLuminance() const;
};

// So that all but the brightest twentieth of what is seen (lamps not counted) stays well below
// white; `stops` brighter (doublings).
Exposure AutoExposure(const PatchScene& scene, const Camera& camera, ToneMap tone_map,
                      double stops);

// Eight bits a channel, dithered by a fixed pattern so that smooth walls show no bands.
std::vector<uint8_t> ToDisplay(const Image& image, const Exposure& exposure);

// The bytes of a file of eight bits a channel.
Result<std::string> EncodePng(int width, int height, const std::vector<uint8_t>& rgb);

// Written whole or not at all.
Status WritePng(const std::string& path, int width, int height, const std::vector<uint8_t>& rgb);
Status WriteExr(const std::string& path, const Image& image);  // 32-bit floats, linear radiance

}  // namespace isolux
