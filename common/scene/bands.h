// Spectral bands: light in more parts than red, green and blue. A scene with bands has channels
// too, made of them, which decide how finely it is divided and what is linked. What the bands then
// bring is found three at a time: each group of them is a scene of three channels like any other.
//
// Light of a channel that no spectrum tells of is spread over the channel's bands in proportion to
// their width; reflectances, transmittances, extinctions and depths of glass are those of the
// channel in all its bands.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/band_reradiation.h"
#include "common/util/bytes.h"
#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

inline constexpr uint32_t kMostBands = 64;
inline constexpr uint32_t kBandsOfGroup = 3;
// Where the middle of a band tells its channel: blue below the first, green below the second.
inline constexpr double kBlueBelowNm = 490, kGreenBelowNm = 580;

// Of wavelengths, in nanometres.
struct Band {
  double low_nm = 0, high_nm = 0;

  double width_nm() const { return high_nm - low_nm; }
  int channel() const {  // 0 red, 1 green, 2 blue
    const double middle_nm = 0.5 * (low_nm + high_nm);
    return middle_nm < kBlueBelowNm ? 2 : middle_nm < kGreenBelowNm ? 1 : 0;
  }
  bool operator==(const Band&) const = default;
};

// Of a material, one number a band; what is empty follows from the material's channels.
struct Spectrum {
  std::vector<double> reflectance, transmittance;
  std::vector<double> exitance;  // W/m²
  BandReradiation reradiation{};

  bool exists() const {
    return !reflectance.empty() || !transmittance.empty() || !exitance.empty() ||
           reradiation.exists();
  }
  bool operator==(const Spectrum&) const = default;
};

// Share of its channel's light that a band has where no spectrum says otherwise.
double ShareOfChannel(std::span<const Band> bands, uint32_t band);
// Whether a channel has bands; of the others a scene with bands has no light.
bool HasBands(std::span<const Band> bands, int channel);

// A channel's reflectance or the like: the mean over its bands by width; `otherwise` without bands.
double MeanOfChannel(std::span<const Band> bands, std::span<const double> values, int channel,
                     double otherwise);
// A channel's power: the sum over its bands.
double SumOfChannel(std::span<const Band> bands, std::span<const double> values, int channel);

struct Scene;
struct Material;

inline uint32_t BandGroupCount(size_t bands) {
  return static_cast<uint32_t>((bands + kBandsOfGroup - 1) / kBandsOfGroup);
}
// The band that stands in a channel of a group's scene: the shortest of the group in blue, the
// longest in red. kMostBands where the last group has none for it.
uint32_t BandInChannel(size_t bands, uint32_t group, int channel);
// The scene with the bands of a group in the place of its channels. A channel without a band
// reflects as the longest band of the group does, and is dark.
Scene SceneOfGroup(const Scene& scene, uint32_t group);
Material MaterialOfGroup(const Scene& scene, const Material& material, uint32_t group);

// What of a band a material reflects, passes on and reradiates at most, where its map is brightest.
double GivenBack(const Scene& scene, const Material& material, size_t band);

// Whether bands are ascending and disjoint, each spectrum has a number for each, and no surface
// gives more back of a band than arrives in it.
Status CheckBands(const Scene& scene);

// What of a scene's bytes tells of bands and spectra: behind all else, and only where there are
// some.
inline constexpr uint64_t kBandsMagic = 0x31444e4258554c49ULL;  // "ILUXBND1": what follows
void PutBands(ByteWriter& out, const Scene& scene);
// The magic number comes next.
Status TakeBands(ByteReader& in, Scene* scene);

}  // namespace isolux
