// Images of scene files in linear light.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

// How an image's values stand for light.
enum class Encoding { kSrgb, kLinear };

struct LinearImage {
  uint32_t width = 0, height = 0;
  std::vector<double> texels;  // red, green, blue in turn, in [0, 1]; rows from the top

  Rgb Mean() const;
};

// Decodes a PNG, JPG, TGA or BMP image; values that are sRGB-encoded (IEC 61966-2-1) become linear,
// transparency is ignored. Sides of more than `most_side` pixels are averaged down to that, so that
// the mean stays. `name` stands in messages. An image of more than `most_pixels` is refused before
// memory is taken for it.
Result<LinearImage> DecodeImage(const std::string& bytes, const std::string& name,
                                Encoding encoding, uint32_t most_side,
                                uint64_t most_pixels = 128ULL << 20);

// Linear value in [0, 1] of an sRGB-encoded one in [0, 1].
double FromSrgb(double encoded);

}  // namespace isolux
