#include "common/scene/band_reradiation.h"

#include <algorithm>

#include "common/scene/scene.h"

namespace isolux {
namespace {

// Mean over a channel's bands, by width, of what each gives out in those of another.
double Between(const BandReradiation& reradiation, std::span<const Band> bands, int from, int to) {
  std::vector<double> given(bands.size(), 0.0);
  for (size_t i = 0; i < bands.size(); ++i) {
    for (size_t j = i + 1; j < bands.size(); ++j) {
      if (bands[j].channel() == to) given[i] += reradiation.Share(i, j);
    }
  }
  return MeanOfChannel(bands, given, from, 0);
}

}  // namespace

double BandReradiation::Taken(size_t from) const {
  double sum = 0;
  for (size_t to = from + 1; to < bands; ++to) sum += Share(from, to);
  return sum;
}

double BandReradiation::LargestTaken() const {
  double largest = 0;
  for (size_t from = 0; from < bands; ++from) largest = std::max(largest, Taken(from));
  return largest;
}

Reradiation BandReradiation::WithinGroup(uint32_t group) const {
  const auto share = [&](int from_channel, int to_channel) {
    const uint32_t from = BandInChannel(bands, group, from_channel);
    const uint32_t to = BandInChannel(bands, group, to_channel);
    return from < bands && to < bands ? Share(from, to) : 0.0;
  };
  return {share(2, 1), share(2, 0), share(1, 0)};
}

Reradiation BandReradiation::BetweenChannels(std::span<const Band> of_scene) const {
  return {Between(*this, of_scene, 2, 1), Between(*this, of_scene, 2, 0),
          Between(*this, of_scene, 1, 0)};
}

double BandReradiation::WithinChannel(std::span<const Band> of_scene, int channel) const {
  return Between(*this, of_scene, channel, channel);
}

bool IsHandedLight(const Scene& scene, uint32_t group) {
  const size_t first = size_t{kBandsOfGroup} * group;
  const size_t end = std::min(first + kBandsOfGroup, scene.bands.size());
  return std::ranges::any_of(scene.materials, [&](const Material& material) {
    for (size_t from = 0; from < first; ++from) {
      for (size_t to = first; to < end; ++to) {
        if (material.spectrum.reradiation.Share(from, to) > 0) return true;
      }
    }
    return false;
  });
}

void PutShares(ByteWriter& out, const BandReradiation& reradiation) {
  for (size_t from = 0; from < reradiation.bands; ++from) {
    for (size_t to = from + 1; to < reradiation.bands; ++to) {
      out.Put(reradiation.Share(from, to) + 0.0);
    }
  }
}

BandReradiation TakeShares(ByteReader& in, size_t bands) {
  BandReradiation result{bands, std::vector<double>(bands * bands, 0.0)};
  for (size_t from = 0; from < bands; ++from) {
    for (size_t to = from + 1; to < bands; ++to)
      result.shares[bands * from + to] = in.Get<double>();
  }
  return result;
}

}  // namespace isolux
