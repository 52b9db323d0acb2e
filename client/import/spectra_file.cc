#include "client/import/spectra_file.h"

#include <algorithm>

#include "client/import/glass.h"

namespace isolux {
namespace {

constexpr double kMostExitance = 1e30;  // W/m²

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

Result<Spectrum> ReadSpectrum(const JsonElement& element, size_t bands) {
  RETURN_IF_ERROR(element.CheckKeys({"reflectance", "transmittance", "exitance_w_m2"}));
  constexpr double kMostShare = 0.98;
  Spectrum spectrum;
  RETURN_IF_ERROR(ReadValues(element, "reflectance", bands, kMostShare, &spectrum.reflectance));
  RETURN_IF_ERROR(ReadValues(element, "transmittance", bands, kMostShare, &spectrum.transmittance));
  RETURN_IF_ERROR(ReadValues(element, "exitance_w_m2", bands, kMostExitance, &spectrum.exitance));
  if (spectrum.exists()) return spectrum;
  return element.Error("no spectrum; give reflectance, transmittance or exitance_w_m2");
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
      scene->materials[m].spectrum = named.spectrum;
      found = true;
    }
    if (found) continue;
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: the scene has no material '{}'; correct the name, or take it out",
                      named.where, named.material);
  }
  for (Material& material : scene->materials) {
    if (material.reradiation.exists()) {
      return MakeStatus(StatusCode::kInvalidArgument,
                        "material '{}': Fl is between three channels, and the scene has spectra; "
                        "take Fl or the spectra out",
                        material.name);
    }
    SetChannels(scene->bands, &material);
  }
  return {};
}

}  // namespace isolux
