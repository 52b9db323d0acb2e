// Where the error of a solution is: the estimated error of each face as a share of the mean
// irradiance, and pictures of it in false colours.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/output/picture.h"

namespace isolux {

// Errors of the irradiance over its mean. The mean is over the area of all faces, in the channel
// where it is largest; a face's error is that of its worst channel.
struct RelativeErrors {
  double mean_irradiance_w_m2 = 0;
  std::vector<double> of_face;  // in the order of the file
  std::vector<double> area;     // of each face, in squares of the file's unit
  double mean = 0;              // over the area
  double p95 = 0;               // 95 % of the area have less
};
// All 0 where nothing is lit.
RelativeErrors FindRelativeErrors(const PatchFile& file);

// A range of values in false colours, by their logarithms: `low` and less is the first colour,
// `high` and more the last.
struct FalseColours {
  double low = 0.002, high = 0.2;

  // Dark blue over green to yellow: evenly brighter, for those who tell no colours apart too; sRGB.
  // Source: viridis [Smith15].
  static const std::array<std::array<uint8_t, 3>, 9>& Stops();
  Rgb Of(double value) const;  // linear
};

// The view of Render, each face in the colour of its error. Where a ray meets nothing it is grey.
// sRGB, three bytes a pixel.
std::vector<uint8_t> RenderErrors(const PatchScene& scene, const Camera& camera,
                                  const RenderOptions& options, const RelativeErrors& errors,
                                  const FalseColours& colours, ThreadPool& pool);

}  // namespace isolux
