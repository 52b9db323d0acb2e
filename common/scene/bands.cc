#include "common/scene/bands.h"

#include <algorithm>
#include <cmath>

#include "common/scene/scene.h"

namespace isolux {
namespace {

constexpr double kShortestNm = 1, kLongestNm = 1e6;
// Beside the bits of the three spectra: what a material's bytes have.
constexpr uint8_t kHasReradiation = 8;

// What stands in the channels of a group.
class Group {
 public:
  Group(std::span<const Band> bands, uint32_t group) : bands_(bands) {
    for (int c = 0; c < 3; ++c) {
      uint32_t band = BandInChannel(bands.size(), group, c);
      lit_[c] = band < bands.size();
      if (!lit_[c]) band = static_cast<uint32_t>(bands.size() - 1);
      band_[c] = band;
      from_[c] = bands[band].channel();
      share_[c] = lit_[c] ? ShareOfChannel(bands, band) : 0.0;
    }
  }

  // Of shares of the light: those of each band's channel, or its own.
  Rgb Shares(const Rgb& of_channels, std::span<const double> spectrum = {}) const {
    Rgb result;
    for (int c = 0; c < 3; ++c) {
      result[c] = spectrum.empty() ? of_channels[from_[c]] : spectrum[band_[c]];
    }
    return result;
  }
  // Of light.
  Rgb Light(const Rgb& of_channels, std::span<const double> spectrum = {}) const {
    Rgb result;
    for (int c = 0; c < 3; ++c) {
      result[c] = spectrum.empty() ? share_[c] * of_channels[from_[c]]
                  : lit_[c]        ? spectrum[band_[c]]
                                   : 0.0;
    }
    return result;
  }

 private:
  std::span<const Band> bands_;
  std::array<uint32_t, 3> band_{};
  std::array<int, 3> from_{};  // the channel of the band
  std::array<double, 3> share_{};
  std::array<bool, 3> lit_{};
};

Material InGroup(const Material& material, const Group& group, uint32_t number) {
  Material result = material;
  const Spectrum& spectrum = material.spectrum;
  result.spectrum = {};
  result.reflectance = group.Shares(material.reflectance, spectrum.reflectance);
  result.transmittance = group.Shares(material.transmittance, spectrum.transmittance);
  result.exitance = group.Light(material.exitance, spectrum.exitance);
  result.reradiation = spectrum.reradiation.WithinGroup(number);
  return result;
}

// Textures hold factors that materials multiply.
void PutInGroup(const Group& group, std::vector<float>* texels, bool light) {
  for (size_t i = 0; i + 2 < texels->size(); i += 3) {
    const Rgb before((*texels)[i], (*texels)[i + 1], (*texels)[i + 2]);
    const Rgb after = light ? group.Light(before) : group.Shares(before);
    for (int c = 0; c < 3; ++c)
      (*texels)[i + static_cast<size_t>(c)] = static_cast<float>(after[c]);
  }
}

Status CheckSpectrum(const Material& material, size_t bands) {
  const Spectrum& spectrum = material.spectrum;
  for (const auto* values : {&spectrum.reflectance, &spectrum.transmittance, &spectrum.exitance}) {
    if (values->empty() || values->size() == bands) continue;
    return MakeStatus(StatusCode::kInvalidArgument,
                      "material '{}': a spectrum of {} numbers for {} bands; give one a band",
                      material.name, values->size(), bands);
  }
  const bool maps =
      (!spectrum.reflectance.empty() && material.reflectance_map.texture != kNoTexture) ||
      (!spectrum.exitance.empty() && material.exitance_map.texture != kNoTexture);
  if (!maps) return {};
  return MakeStatus(StatusCode::kInvalidArgument,
                    "material '{}': both a map and a spectrum; take one of them out",
                    material.name);
}

Status CheckReradiation(const Scene& scene, const Material& material) {
  const BandReradiation& reradiation = material.spectrum.reradiation;
  const auto fail = [&](const std::string& what) {
    return MakeStatus(StatusCode::kInvalidArgument, "material '{}': {}", material.name, what);
  };
  if (!reradiation.exists()) {
    if (scene.bands.empty() || !material.reradiation.exists()) return {};
    return fail(
        "fluorescence between channels in a scene with spectra; take Fl or the spectra out");
  }
  const size_t n = scene.bands.size();
  if (reradiation.bands != n || reradiation.shares.size() != n * n) {
    return fail(fmt::format("its reradiation is between {} bands, not {}", reradiation.bands, n));
  }
  for (size_t from = 0; from < n; ++from) {
    for (size_t to = 0; to < n; ++to) {
      const double share = reradiation.Share(from, to);
      if (share >= 0 && share <= 1 && (share == 0 || to > from)) continue;
      return fail(
          fmt::format("of band {} {} comes out in band {}: give shares of what comes out "
                      "in longer bands",
                      from + 1, share, to + 1));
    }
    const double back = GivenBack(scene, material, from);
    if (back < 1) continue;
    return fail(
        fmt::format("of band {} it reflects, passes on and reradiates {}; lower that below "
                    "1 together",
                    from + 1, back));
  }
  return {};
}

std::vector<double> GetNumbers(ByteReader& in, size_t count) {
  std::vector<double> numbers(count);
  for (double& number : numbers) number = in.Get<double>();
  return numbers;
}

}  // namespace

double GivenBack(const Scene& scene, const Material& material, size_t band) {
  const Spectrum& spectrum = material.spectrum;
  const int c = scene.bands[band].channel();
  const uint32_t map = material.reflectance_map.texture;
  double reflected = material.reflectance[c];
  if (map < scene.textures.size()) reflected *= LargestTexel(scene.textures[map])[c];
  if (!spectrum.reflectance.empty()) reflected = spectrum.reflectance[band];
  const double passed =
      spectrum.transmittance.empty() ? material.transmittance[c] : spectrum.transmittance[band];
  return reflected + material.specular + passed + spectrum.reradiation.Taken(band);
}

double ShareOfChannel(std::span<const Band> bands, uint32_t band) {
  double whole_nm = 0;
  for (const Band& other : bands) {
    if (other.channel() == bands[band].channel()) whole_nm += other.width_nm();
  }
  return bands[band].width_nm() / whole_nm;
}

bool HasBands(std::span<const Band> bands, int channel) {
  return std::ranges::any_of(bands, [&](const Band& b) { return b.channel() == channel; });
}

double MeanOfChannel(std::span<const Band> bands, std::span<const double> values, int channel,
                     double otherwise) {
  double sum = 0, width_nm = 0, low = INFINITY, high = -INFINITY;
  for (size_t b = 0; b < bands.size(); ++b) {
    if (bands[b].channel() != channel) continue;
    sum += bands[b].width_nm() * values[b];
    width_nm += bands[b].width_nm();
    low = std::min(low, values[b]);
    high = std::max(high, values[b]);
  }
  return width_nm > 0 ? std::clamp(sum / width_nm, low, high) : otherwise;
}

double SumOfChannel(std::span<const Band> bands, std::span<const double> values, int channel) {
  double sum = 0;
  for (size_t b = 0; b < bands.size(); ++b) sum += bands[b].channel() == channel ? values[b] : 0.0;
  return sum;
}

uint32_t BandInChannel(size_t bands, uint32_t group, int channel) {
  const uint32_t band = kBandsOfGroup * group + static_cast<uint32_t>(2 - channel);
  return band < bands ? band : kMostBands;
}

Material MaterialOfGroup(const Scene& scene, const Material& material, uint32_t group) {
  return InGroup(material, Group(scene.bands, group), group);
}

Scene SceneOfGroup(const Scene& scene, uint32_t number) {
  const Group group(scene.bands, number);
  Scene result = scene;
  result.bands.clear();
  for (Material& material : result.materials) material = InGroup(material, group, number);
  for (Texture& texture : result.textures) PutInGroup(group, &texture.texels, false);
  for (Light& light : result.lights) light.intensity = group.Light(light.intensity);
  std::erase_if(result.lights, [](const Light& light) { return !(Sum(light.intensity) > 0); });
  PutInGroup(group, &result.sky.texels, true);
  if (!(Sum(result.sky.MeanRadiance()) > 0)) result.sky = {};
  result.medium.extinction_per_m = group.Shares(scene.medium.extinction_per_m);
  for (Glass& glass : result.glazing.glasses) {
    glass.optical_depth = group.Shares(glass.optical_depth);
  }
  return result;
}

Status CheckBands(const Scene& scene) {
  const std::vector<Band>& bands = scene.bands;
  if (bands.size() > kMostBands) {
    return MakeStatus(StatusCode::kInvalidArgument, "{} spectral bands, more than {}; join some",
                      bands.size(), kMostBands);
  }
  double last_nm = kShortestNm;
  for (const Band& band : bands) {
    if (!(band.low_nm >= last_nm && band.high_nm > band.low_nm && band.high_nm <= kLongestNm)) {
      return MakeStatus(StatusCode::kInvalidArgument,
                        "spectral band {} to {} nm: give bands one after the other, from short to "
                        "long, none within another",
                        band.low_nm, band.high_nm);
    }
    last_nm = band.high_nm;
  }
  for (const Material& material : scene.materials) {
    RETURN_IF_ERROR(CheckSpectrum(material, bands.size()));
    RETURN_IF_ERROR(CheckReradiation(scene, material));
  }
  return {};
}

void PutBands(ByteWriter& out, const Scene& scene) {
  if (scene.bands.empty()) return;
  out.Put(kBandsMagic);
  out.Put(static_cast<uint64_t>(scene.bands.size()));
  for (const Band& band : scene.bands) {
    out.Put(band.low_nm);
    out.Put(band.high_nm);
  }
  // For each material which spectra it has, by bits; then their numbers.
  for (const Material& material : scene.materials) {
    const Spectrum& spectrum = material.spectrum;
    const std::vector<double>* parts[] = {&spectrum.reflectance, &spectrum.transmittance,
                                          &spectrum.exitance};
    uint8_t has = 0;
    for (int i = 0; i < 3; ++i) has |= static_cast<uint8_t>(parts[i]->empty() ? 0 : 1 << i);
    if (spectrum.reradiation.exists()) has |= kHasReradiation;
    out.Put(has);
    for (const auto* part : parts) {
      for (const double number : *part) out.Put(number + 0.0);
    }
    PutShares(out, spectrum.reradiation);
  }
}

Status TakeBands(ByteReader& in, Scene* scene) {
  in.Get<uint64_t>();
  const auto count = in.Get<uint64_t>();
  const auto missing = [] {
    return MakeStatus(StatusCode::kDataLoss, "scene: its spectral bands are missing, or none");
  };
  if (!in.ok() || count == 0 || count > kMostBands) return missing();
  for (uint64_t i = 0; i < count; ++i) {
    const auto low_nm = in.Get<double>();
    scene->bands.push_back({low_nm, in.Get<double>()});
  }
  for (Material& material : scene->materials) {
    const auto has = in.Get<uint8_t>();
    if (!in.ok() || has >= 2 * kHasReradiation) return missing();
    Spectrum& spectrum = material.spectrum;
    if ((has & 1) != 0) spectrum.reflectance = GetNumbers(in, count);
    if ((has & 2) != 0) spectrum.transmittance = GetNumbers(in, count);
    if ((has & 4) != 0) spectrum.exitance = GetNumbers(in, count);
    if ((has & kHasReradiation) != 0) spectrum.reradiation = TakeShares(in, count);
  }
  return in.ok() ? CheckBands(*scene) : missing();
}

}  // namespace isolux
