// Fluorescence between spectral bands: light that a surface takes in one band and gives out in
// bands of longer wavelength. Within a group of three bands that is fluorescence between channels
// (reradiation.h); what goes from group to group is given out once the group that it came from has
// been solved for (server/handed_on.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/reradiation.h"
#include "common/util/bytes.h"

namespace isolux {

struct Band;
struct Scene;

struct BandReradiation {
  size_t bands = 0;  // 0: nothing is reradiated
  // Of the irradiance in a band, in power: by the band that it is taken from, then by the band that
  // it comes out in. Nothing but what goes to longer bands is above 0.
  std::vector<double> shares;

  bool exists() const { return bands > 0; }
  double Share(size_t from, size_t to) const { return exists() ? shares[bands * from + to] : 0.0; }
  // Share of what arrives in a band that comes out in all others.
  double Taken(size_t from) const;
  // The largest of these over the bands.
  double LargestTaken() const;
  // What a group takes from one channel of its scene and gives out in another.
  Reradiation WithinGroup(uint32_t group) const;
  // The same of the scene's channels: means over the bands that each takes light in, by width.
  Reradiation BetweenChannels(std::span<const Band> of_scene) const;
  // What comes out in other bands of the same channel, likewise.
  double WithinChannel(std::span<const Band> of_scene, int channel) const;

  bool operator==(const BandReradiation&) const = default;
};

// Whether a group gives out light that groups before it have taken.
bool IsHandedLight(const Scene& scene, uint32_t group);

// The shares that may be above 0, of a number of bands that is known.
void PutShares(ByteWriter& out, const BandReradiation& reradiation);
BandReradiation TakeShares(ByteReader& in, size_t bands);

}  // namespace isolux
