// Light from all around a scene: radiance by direction alone. Texels of equal solid angle tell it:
// rows of equal height along an axis from the zenith down, and columns of equal angle around it
// (Lambert's cylinder). A texel is even.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/util/bytes.h"
#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

struct Sky {
  static constexpr uint32_t kMostColumns = 4096, kMostRows = 2048;

  std::string name;                   // what it is, for people
  uint32_t columns = 0, rows = 0;     // 0: there is no sky
  Vec3 up{0, 1, 0}, ahead{0, 0, -1};  // zenith; where the columns begin; orthogonal, of length 1
  // Radiance, three channels a texel, W/(m² sr); columns turn from `ahead` to up × ahead.
  std::vector<float> texels;

  bool operator==(const Sky&) const = default;

  bool exists() const { return rows > 0; }
  Rgb Texel(uint32_t column, uint32_t row) const {
    const float* texel = &texels[3 * (static_cast<size_t>(row) * columns + column)];
    return {texel[0], texel[1], texel[2]};
  }
  // In a direction of length 1, from the scene outwards.
  Rgb RadianceFrom(const Vec3& direction) const;
  // Over all directions.
  Rgb MeanRadiance() const;
};

// Whether axes and texels are in range.
Status CheckSky(const Sky& sky);

// A sky as part of an encoded scene. What is not there has too few texels, or the reader fails.
void Put(ByteWriter& out, const Sky& sky);
Sky GetSky(ByteReader& in);

}  // namespace isolux
