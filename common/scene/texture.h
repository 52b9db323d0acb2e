// Maps of reflectance and exitance: images in linear light, and their exact means over parts of
// polygons.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

inline constexpr uint32_t kNoTexture = 0xffffffffu;
inline constexpr uint32_t kNoCoordinates = 0xffffffffu;

// What lies outside [0, 1] of a texture coordinate.
enum class Wrap : uint8_t { kRepeat = 0, kClamp = 1, kMirror = 2 };

// Texels are constant over their squares. Values are relative to the mean of the image, channel by
// channel, so that a material's reflectance or exitance is its mean and the map says only how it
// varies. Texture coordinates (0, 0) are the image's upper left corner, (1, 1) the lower right one.
struct Texture {
  static constexpr uint32_t kMostTexels = 512 * 512;

  uint32_t width = 0, height = 0;
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  std::vector<float> texels;  // red, green, blue in turn; rows from the top
};

// Texture coordinates as an affine function of a point of the scene: (x, y, z, 1) times each row.
struct TextureCoordinates {
  std::array<double, 4> u{}, v{};
};

// What a material has of a texture. The transform's rows take (u, v, 1) to the image's coordinates.
struct TextureUse {
  uint32_t texture = kNoTexture;
  std::array<double, 6> transform{1, 0, 0, 0, 1, 0};
};

// A point of an image, in texels from its upper left corner.
struct TexturePoint {
  double x = 0, y = 0;
};

struct TextureMoments {
  Rgb mean{1.0};
  Rgb square{1.0};  // mean of the squares
};

// Integrates a texture over polygons. By Green's theorem the integral is one along the outline, of
// the antiderivative of the texels along their row, which is linear between the borders of texels:
// so it is exact, and costs a few operations for each texel that the outline crosses.
class TextureIntegral {
 public:
  explicit TextureIntegral(const Texture& texture);

  // Over a polygon of any winding; one without area gives the texel at its middle.
  TextureMoments Over(std::span<const TexturePoint> polygon) const;
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }

 private:
  using Sums = std::array<double, 6>;  // of the three channels, and of their squares

  int64_t Row(int64_t y) const;
  // Integral from 0 to x along a row of the image, which goes on beyond its borders.
  Sums Along(int64_t row, double x) const;
  Sums Within(int64_t row, double x) const;  // the same for x in [0, width]
  Sums TexelAt(const TexturePoint& p) const;

  uint32_t width_, height_;
  Wrap wrap_u_, wrap_v_;
  std::vector<Sums> before_;  // by row and column: sum of the texels before it; one more a row
};

// The largest value of each channel.
Rgb LargestTexel(const Texture& texture);

// Dimensions, number and values of texels.
Status CheckTexture(const Texture& texture);

}  // namespace isolux
