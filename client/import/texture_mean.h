// Mean colour of an image in linear light: what a reflectance map counts for as long as a polygon
// has one reflectance.
#pragma once

#include <cstdint>
#include <string>

#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

// How an image's values stand for light.
enum class Encoding { kSrgb, kLinear };

// Averages an encoded PNG, JPG, TGA or BMP image over all pixels, after decoding values that are
// sRGB-encoded (IEC 61966-2-1); transparency is ignored. `name` stands in messages. An image of
// more than `most_pixels` is refused before memory is taken for it.
Result<Rgb> LinearMean(const std::string& bytes, const std::string& name, Encoding encoding,
                       uint64_t most_pixels = 128ULL << 20);
// Of an sRGB-encoded file.
Result<Rgb> LinearMean(const std::string& path, uint64_t most_pixels = 128ULL << 20);

// Linear value in [0, 1] of an sRGB-encoded one in [0, 1].
double FromSrgb(double encoded);

}  // namespace isolux
