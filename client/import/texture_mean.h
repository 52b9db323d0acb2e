// Mean colour of an image in linear light: what a reflectance map counts for as long as a polygon
// has one reflectance.
#pragma once

#include <cstdint>
#include <string>

#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

// Reads a PNG, JPG, TGA or BMP file whose values are sRGB-encoded (IEC 61966-2-1), decodes them and
// averages over all pixels; transparency is ignored. An image of more than `most_pixels` is refused
// before memory is taken for it.
Result<Rgb> LinearMean(const std::string& path, uint64_t most_pixels = 128ULL << 20);

// Linear value in [0, 1] of an sRGB-encoded one in [0, 1].
double FromSrgb(double encoded);

}  // namespace isolux
