#include "client/import/materials.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>

#include "client/import/glass.h"
#include "client/import/text_file.h"
#include "client/import/texture_image.h"
#include "common/util/file.h"

namespace isolux {
namespace {

constexpr double kLargestReflectance = 0.98;  // what 1 or more becomes
constexpr double kGrey = 0.5;                 // of faces without a material
constexpr uint32_t kMostSide = 512;           // of a texture
static_assert(kMostSide * kMostSide <= Texture::kMostTexels);

// Of a glossy material with what it reflects else. The lobe of a metal, so much of its reflectance,
// is kept in that; others add to it, and no more than is left.
Gloss GlossOf(const FileMaterial& from, double metallic, const Material& material) {
  if (!from.glossy) return {};
  if (metallic > 0) return {glm::min(metallic * material.reflectance + from.lobe, Rgb(1.0)), true};
  const Rgb taken = material.reflectance + material.transmittance + material.reradiation.Taken();
  const Rgb left = Rgb(kLargestReflectance - material.specular) - taken;
  return {glm::clamp(left, Rgb(0.0), from.lobe), false};
}

class MaterialMaker {
 public:
  MaterialMaker(const SceneFile& file, Scene* scene, RepairLog* log)
      : file_(file), scene_(*scene), log_(*log) {}

  Material Make(const FileMaterial& from);
  Glass MakeGlass(const FileMaterial& from);

 private:
  struct Varied {
    Rgb mean{0.0};
    TextureUse use;
  };

  void NoteEffects(const FileMaterial& from);
  // What a mirror reflects as such, grey; lowers it and what it reflects diffusely where together
  // they are more than what arrives.
  double Specular(const FileMaterial& from, double metallic, Rgb* diffuse);
  // What a sheet passes on; lowers it and what it reflects diffusely where together they are more
  // than what mirrors leave. Of a map the texels are limited later.
  Rgb Transmittance(const FileMaterial& from, double specular, Rgb* diffuse);
  // Each is decoded once; nothing where an image is missing or unreadable.
  const LinearImage* Image(const FileMap& map, Encoding encoding);
  // A factor times a map, no texel above `most`. `even`: the mean counts in any case, and `kind`
  // says so.
  Varied Vary(const FileMap& map, const Rgb& factor, double most, bool even, Repair kind,
              const std::string& where);
  uint32_t Texture(const FileMap& map, const LinearImage& image, const Rgb& factor, double most,
                   const Rgb& mean);

  const SceneFile& file_;
  Scene& scene_;
  RepairLog& log_;
  std::map<std::pair<std::string, Encoding>, std::optional<LinearImage>> images_;
  // By image and wrap modes, and by factor where texels are limited.
  std::map<std::tuple<std::string, Wrap, Wrap, double, double, double>, uint32_t> textures_;
};

void MaterialMaker::NoteEffects(const FileMaterial& from) {
  const auto where = [&] { return from.where; };
  if (from.opacity_map) log_.Add(Repair::kOpacityMap, where);
  if (from.mirror && Sum(from.specular) == 0) log_.Add(Repair::kMirror, where);
  if (from.glossy) log_.Add(Repair::kGlossy, where);
  if (from.glass && !IsPane(from)) log_.Add(Repair::kGlass, where);
  if (from.sheet_maps) log_.Add(Repair::kSheetMap, where);
  if (from.unlit) log_.Add(Repair::kUnlit, where);
}

const LinearImage* MaterialMaker::Image(const FileMap& map, Encoding encoding) {
  constexpr uint64_t kMostMapBytes = 1ULL << 30;
  const bool embedded = map.embedded != kNoImage;
  const std::string name = embedded ? map.name : FindFile(map.folder, map.name);
  if (name.empty()) return nullptr;
  const auto [at, is_new] = images_.try_emplace({name, encoding});
  if (is_new) {
    Result<std::string> bytes =
        embedded ? Result<std::string>(file_.images[map.embedded]) : ReadFile(name, kMostMapBytes);
    Result<LinearImage> image = bytes.has_value() ? DecodeImage(*bytes, name, encoding, kMostSide)
                                                  : tl::unexpected(bytes.error());
    if (image.has_value()) at->second = std::move(*image);
  }
  return at->second ? &*at->second : nullptr;
}

uint32_t MaterialMaker::Texture(const FileMap& map, const LinearImage& image, const Rgb& factor,
                                double most, const Rgb& mean) {
  const std::string name = map.embedded != kNoImage ? map.name : FindFile(map.folder, map.name);
  const bool limited = std::any_of(image.texels.begin(), image.texels.end(), [&](double texel) {
    return texel * std::max({factor.x, factor.y, factor.z}) > most;
  });
  const Rgb key = limited ? factor : Rgb(0.0);
  const auto [at, is_new] =
      textures_.try_emplace({name, map.wrap_u, map.wrap_v, key.x, key.y, key.z},
                            static_cast<uint32_t>(scene_.textures.size()));
  if (!is_new) return at->second;
  isolux::Texture& texture = scene_.textures.emplace_back();
  texture.width = image.width;
  texture.height = image.height;
  texture.wrap_u = map.wrap_u;
  texture.wrap_v = map.wrap_v;
  for (size_t i = 0; i < image.texels.size(); ++i) {
    const int c = static_cast<int>(i % 3);
    const double value = std::min(most, factor[c] * image.texels[i]);
    texture.texels.push_back(static_cast<float>(mean[c] > 0 ? value / mean[c] : 1.0));
  }
  return at->second;
}

MaterialMaker::Varied MaterialMaker::Vary(const FileMap& map, const Rgb& factor, double most,
                                          bool even, Repair kind, const std::string& where) {
  if (map.name.empty() || Sum(factor) == 0) return {factor, {}};
  const LinearImage* image = Image(map, Encoding::kSrgb);
  if (image == nullptr) {
    log_.Add(Repair::kNoMap, [&] { return where; });
    return {factor, {}};
  }
  Varied varied;
  bool constant = true;
  for (size_t i = 0; i < image->texels.size(); ++i) {
    const int c = static_cast<int>(i % 3);
    varied.mean[c] += std::min(most, factor[c] * image->texels[i]);
    constant = constant && image->texels[i] == image->texels[i % 3];
  }
  varied.mean /= static_cast<double>(image->width) * image->height;
  if (constant) return varied;
  if (even) {
    log_.Add(kind, [&] { return where; });
    return varied;
  }
  varied.use.texture = Texture(map, *image, factor, most, varied.mean);
  varied.use.transform = map.transform;
  return varied;
}

double MaterialMaker::Specular(const FileMaterial& from, double metallic, Rgb* diffuse) {
  const auto where = [&] { return from.where; };
  Rgb colour = metallic * from.specular;
  if (from.metallic > 0 && !from.diffuse_map.name.empty() && Sum(colour) > 0) {
    const LinearImage* image = Image(from.diffuse_map, Encoding::kSrgb);
    if (image != nullptr) colour *= image->Mean();
  }
  const bool grey = colour.x == colour.y && colour.y == colour.z;
  double specular = grey ? colour.x : Sum(colour) / 3;
  if (!grey) log_.Add(Repair::kMirrorColour, where);
  const double largest = std::max({diffuse->x, diffuse->y, diffuse->z});
  if (specular == 0 || specular + largest <= (largest > 0 ? kLargestReflectance : 1.0)) {
    return specular;
  }
  log_.Add(Repair::kMirrorShare, where);
  const double scale = (largest > 0 ? kLargestReflectance : 1.0) / (specular + largest);
  *diffuse *= scale;
  return specular * scale;
}

Rgb MaterialMaker::Transmittance(const FileMaterial& from, double specular, Rgb* diffuse) {
  Rgb passed = from.transmittance;
  const Rgb taken = from.reradiation.Taken();
  bool lowered = false;
  for (int c = 0; c < 3; ++c) {
    const double left = kLargestReflectance - specular - taken[c];
    const double both = passed[c] + (from.diffuse_map.name.empty() ? (*diffuse)[c] : 0.0);
    if (passed[c] == 0 || both <= left) continue;
    const double scale = std::max(0.0, left) / both;
    passed[c] *= scale;
    (*diffuse)[c] *= scale;
    lowered = true;
  }
  if (lowered) log_.Add(Repair::kSheetShare, [&] { return from.where; });
  return passed;
}

Material MaterialMaker::Make(const FileMaterial& from) {
  const auto where = [&] { return from.where; };
  NoteEffects(from);
  Rgb diffuse = from.diffuse;
  double metallic = from.metallic;
  if (from.metallic > 0) {
    if (!from.metallic_map.name.empty()) {
      const LinearImage* image = Image(from.metallic_map, Encoding::kLinear);
      log_.Add(image != nullptr ? Repair::kMap : Repair::kNoMap, where);
      if (image != nullptr) metallic *= image->Mean().z;
    }
    if (!from.glossy) diffuse *= 1 - metallic;
  }
  const double specular = Specular(from, from.metallic > 0 ? metallic : 1, &diffuse);
  const Rgb passed = Transmittance(from, specular, &diffuse);
  const Rgb other = passed + from.reradiation.Taken();
  const double most = kLargestReflectance * (1 - specular) - std::max({other.x, other.y, other.z});
  bool lowered = false;
  for (int c = 0; c < 3; ++c) {
    if (diffuse[c] < 1 || !from.diffuse_map.name.empty()) continue;
    diffuse[c] = kLargestReflectance;
    lowered = true;
  }
  const bool no_coordinates = file_.coordinates.empty();
  const Varied reflectance =
      Vary(from.diffuse_map, diffuse, most, no_coordinates, Repair::kMap, from.where);
  const Varied exitance = Vary(from.emission_map, std::numbers::pi * from.radiance,
                               std::numeric_limits<double>::infinity(),
                               no_coordinates || from.emission_map.set != from.coordinate_set(),
                               Repair::kEmissionMap, from.where);
  Material material;
  material.name = from.name;
  material.specular = specular;
  material.transmittance = passed;
  material.reradiation = from.reradiation;
  material.reflectance = reflectance.mean;
  material.reflectance_map = reflectance.use;
  material.exitance = exitance.mean;
  material.exitance_map = exitance.use;
  for (int c = 0; c < 3; ++c) {  // of a map that could not be read
    if (material.reflectance[c] < 1 - specular - other[c] || material.reflectance[c] == 0) {
      continue;
    }
    material.reflectance[c] = most;
    lowered = true;
  }
  if (lowered) log_.Add(Repair::kReflectance, where);
  material.gloss = GlossOf(from, metallic, material);
  return material;
}

Glass MaterialMaker::MakeGlass(const FileMaterial& from) {
  Glass glass;
  Rgb left = from.clear;
  if (from.tinted && !from.diffuse_map.name.empty()) {
    const LinearImage* image = Image(from.diffuse_map, Encoding::kSrgb);
    log_.Add(image != nullptr ? Repair::kMap : Repair::kNoMap, [&] { return from.where; });
    if (image != nullptr) left *= image->Mean();
  }
  for (int c = 0; c < 3; ++c) glass.optical_depth[c] = OpticalDepthOf(left[c]);
  glass.index = from.index_of_refraction;
  return glass;
}

}  // namespace

std::vector<Glass> MakeMaterials(const SceneFile& file, Scene* scene, RepairLog* log) {
  std::vector<bool> used(file.materials.size(), false);
  for (const FileFace& face : file.faces) {
    if (face.material != kNoMaterial) used[face.material] = true;
  }
  MaterialMaker maker(file, scene, log);
  std::vector<Glass> glasses(file.materials.size());
  scene->materials.resize(file.materials.size() + 1);
  for (size_t m = 0; m < used.size(); ++m) {
    if (!used[m]) continue;
    if (IsPane(file.materials[m])) {
      glasses[m] = maker.MakeGlass(file.materials[m]);
    } else {
      scene->materials[m] = maker.Make(file.materials[m]);
    }
  }
  scene->materials.back().reflectance = Rgb(kGrey);
  return glasses;
}

}  // namespace isolux
