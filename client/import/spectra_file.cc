#include "client/import/spectra_file.h"

#include <algorithm>

#include "client/import/glass.h"

namespace isolux {
namespace {

constexpr double kMostExitance = 1e30;  // W/m²
constexpr double kMostShare = 0.98;     // of what arrives

Status ReadBands(const JsonElement& element, std::vector<Band>* bands) {
  const auto found = element.json.find("bands_nm");
  const auto fail = [&] {
    return element.Error(
        "\"bands_nm\" must be a list of 1 to {} bands from short to long, none within another, "
        "like [[400, 490], [490, 580], [580, 700]]",
        kMostBands);
  };
  if (found == element.json.end() || !found->is_array() || found->empty() ||
      found->size() > kMostBands) {
    return fail();
  }
  double last_nm = 1;
  for (const auto& pair : *found) {
    const bool numbers =
        pair.is_array() && pair.size() == 2 && pair[0].is_number() && pair[1].is_number();
    Band band;
    if (numbers) band = {pair[0].get<double>(), pair[1].get<double>()};
    if (!numbers || !(band.low_nm >= last_nm && band.high_nm > band.low_nm && band.high_nm < 1e6)) {
      return fail();
    }
    bands->push_back(band);
    last_nm = band.high_nm;
  }
  return {};
}

// One number for all bands, or one a band; none where the key is not there.
Status ReadValues(const JsonElement& element, const char* key, size_t bands, double most,
                  std::vector<double>* values) {
  const auto found = element.json.find(key);
  if (found == element.json.end()) return {};
  const auto good = [&](const nlohmann::json& value) {
    return value.is_number() && value.get<double>() >= 0 && value.get<double>() <= most;
  };
  if (good(*found)) {
    values->assign(bands, found->get<double>());
    return {};
  }
  if (!found->is_array() || found->size() != bands || !std::ranges::all_of(*found, good)) {
    return element.Error("\"{}\" must be a number from 0 to {}, or {} of them, one a band", key,
                         most, bands);
  }
  for (const auto& value : *found) values->push_back(value.get<double>());
  return {};
}

// A row a band that light is taken from.
Status ReadReradiation(const JsonElement& element, size_t bands, BandReradiation* reradiation) {
  const auto found = element.json.find("reradiation");
  if (found == element.json.end()) return {};
  if (!found->is_array() || found->size() != bands) {
    return element.Error("\"reradiation\" must be {} rows, one a band that light is taken from",
                         bands);
  }
  std::vector<double> shares;
  for (size_t from = 0; from < bands; ++from) {
    const auto& row = (*found)[from];
    const auto good = [](const nlohmann::json& value) {
      return value.is_number() && value.get<double>() >= 0 && value.get<double>() <= kMostShare;
    };
    if (!row.is_array() || row.size() != bands || !std::ranges::all_of(row, good)) {
      return element.Error(
          "\"reradiation\": row {} must be {} numbers from 0 to {}, one a band "
          "that light comes out in",
          from + 1, bands, kMostShare);
    }
    for (size_t to = 0; to < bands; ++to) {
      shares.push_back(row[to].get<double>());
      if (to > from || shares.back() == 0) continue;
      return element.Error(
          "\"reradiation\": row {}: light comes out in longer bands alone; write 0 "
          "in column {}",
          from + 1, to + 1);
    }
  }
  if (std::ranges::any_of(shares, [](double share) { return share > 0; })) {
    *reradiation = {bands, std::move(shares)};
  }
  return {};
}

Result<Spectrum> ReadSpectrum(const JsonElement& element, size_t bands) {
  RETURN_IF_ERROR(
      element.CheckKeys({"reflectance", "transmittance", "exitance_w_m2", "reradiation"}));
  Spectrum spectrum;
  RETURN_IF_ERROR(ReadValues(element, "reflectance", bands, kMostShare, &spectrum.reflectance));
  RETURN_IF_ERROR(ReadValues(element, "transmittance", bands, kMostShare, &spectrum.transmittance));
  RETURN_IF_ERROR(ReadValues(element, "exitance_w_m2", bands, kMostExitance, &spectrum.exitance));
  RETURN_IF_ERROR(ReadReradiation(element, bands, &spectrum.reradiation));
  if (spectrum.exists()) return spectrum;
  return element.Error(
      "no spectrum; give reflectance, transmittance, exitance_w_m2 or reradiation above 0");
}

// Light of a channel without bands is no light of the scene.
void Darken(const std::vector<Band>& bands, SceneFile* file) {
  for (int c = 0; c < 3; ++c) {
    if (HasBands(bands, c)) continue;
    for (Light& light : file->lights) light.intensity[c] = 0;
    for (size_t i = static_cast<size_t>(c); i < file->sky.texels.size(); i += 3) {
      file->sky.texels[i] = 0;
    }
  }
}

Status CheckNamed(const FileSpectrum& named, const FileMaterial& material) {
  const auto fail = [&](const std::string& what) {
    return MakeStatus(StatusCode::kInvalidArgument, "{}: {} ({})", named.where, what,
                      material.where);
  };
  const bool reflects = !named.spectrum.reflectance.empty();
  if (IsPane(material))
    return fail("the material is clear glass, which has no spectrum; take it out");
  if (reflects && !(material.diffuse_map.name.empty() && material.metallic_map.name.empty())) {
    return fail("the material has a map of its reflectance; take the map or the spectrum out");
  }
  if (!named.spectrum.exitance.empty() && !material.emission_map.name.empty()) {
    return fail("the material has a map of its emission; take the map or the spectrum out");
  }
  return {};
}

// Red, green and blue as the bands have it.
void SetChannels(const std::vector<Band>& bands, Material* material) {
  const Spectrum& spectrum = material->spectrum;
  for (int c = 0; c < 3; ++c) {
    double& reflectance = material->reflectance[c];
    double& transmittance = material->transmittance[c];
    double& exitance = material->exitance[c];
    if (!spectrum.reflectance.empty()) {
      reflectance = MeanOfChannel(bands, spectrum.reflectance, c, reflectance);
    }
    if (!spectrum.transmittance.empty()) {
      transmittance = MeanOfChannel(bands, spectrum.transmittance, c, transmittance);
    }
    if (!spectrum.exitance.empty()) exitance = SumOfChannel(bands, spectrum.exitance, c);
    if (!HasBands(bands, c)) exitance = 0;
  }
  if (!spectrum.reradiation.exists()) return;
  // What changes its band, but not its channel, counts as reflected by the channel.
  material->reradiation = spectrum.reradiation.BetweenChannels(bands);
  if (material->reflectance_map.texture != kNoTexture) return;
  for (int c = 0; c < 3; ++c) {
    material->reflectance[c] += spectrum.reradiation.WithinChannel(bands, c);
  }
}

// Before anything counts as reflected by the channels that is not.
void SpellOutReflectance(const std::vector<Band>& bands, Material* material) {
  Spectrum& spectrum = material->spectrum;
  const bool map = material->reflectance_map.texture != kNoTexture;
  if (!spectrum.reradiation.exists() || !spectrum.reflectance.empty() || map) return;
  for (const Band& band : bands) {
    spectrum.reflectance.push_back(material->reflectance[band.channel()]);
  }
}

// Where a material is fluorescent.
Status CheckGivenBack(const FileSpectrum& named, const FileMaterial& from, const Scene& scene,
                      const Material& material) {
  if (!named.spectrum.reradiation.exists()) return {};
  for (size_t b = 0; b < scene.bands.size(); ++b) {
    const double back = GivenBack(scene, material, b);
    if (back <= kMostShare) continue;
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: of band {} ({} to {} nm) it reflects, passes on and reradiates {:.3g}; "
                      "lower these to {} together ({})",
                      named.where, b + 1, scene.bands[b].low_nm, scene.bands[b].high_nm, back,
                      kMostShare, from.where);
  }
  return {};
}

}  // namespace

Status ReadSpectra(const JsonElement& element, SceneFile* file) {
  RETURN_IF_ERROR(element.CheckKeys({"bands_nm", "materials"}));
  RETURN_IF_ERROR(ReadBands(element, &file->bands));
  Darken(file->bands, file);
  const auto materials = element.json.find("materials");
  if (materials == element.json.end()) return {};
  if (!materials->is_object()) {
    return element.Error("\"materials\" must be an object, like {{\"wall\": {{…}}}}");
  }
  for (const auto& item : materials->items()) {
    FileSpectrum& named = file->spectra.emplace_back();
    named.material = item.key();
    named.where = fmt::format("{}: materials: {}", element.where, item.key());
    ASSIGN_OR_RETURN(named.spectrum, ReadSpectrum({item.value(), named.where}, file->bands.size()));
  }
  return {};
}

Status ApplySpectra(const SceneFile& file, Scene* scene) {
  if (file.bands.empty()) return {};
  scene->bands = file.bands;
  for (const FileSpectrum& named : file.spectra) {
    bool found = false;
    for (size_t m = 0; m < file.materials.size(); ++m) {
      if (file.materials[m].name != named.material) continue;
      RETURN_IF_ERROR(CheckNamed(named, file.materials[m]));
      Material& material = scene->materials[m];
      material.spectrum = named.spectrum;
      RETURN_IF_ERROR(CheckGivenBack(named, file.materials[m], *scene, material));
      found = true;
    }
    if (found) continue;
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: the scene has no material '{}'; correct the name, or take it out",
                      named.where, named.material);
  }
  for (Material& material : scene->materials) {
    if (material.reradiation.exists() && !material.spectrum.reradiation.exists()) {
      return MakeStatus(StatusCode::kInvalidArgument,
                        "material '{}': Fl is between three channels, and the scene has spectra; "
                        "give it \"reradiation\" there, or take Fl or the spectra out",
                        material.name);
    }
    SpellOutReflectance(scene->bands, &material);
    SetChannels(scene->bands, &material);
  }
  return {};
}

}  // namespace isolux
