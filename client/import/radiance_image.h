// Images of radiance: Radiance's .hdr and OpenEXR.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/util/status.h"

namespace isolux {

struct RadianceImage {
  uint32_t width = 0, height = 0;
  std::vector<float> pixels;  // three channels each, row by row from the top; not negative
};

// By the first bytes of the file. Errors name it.
Result<RadianceImage> ReadRadianceImage(const std::string& path, uint64_t most_pixels = 1ULL << 26);

}  // namespace isolux
