#include "client/import/gltf_materials.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "client/import/gltf_accessors.h"

namespace isolux {
namespace {

using tinygltf::Value;

// Smoother metals are seen as mirrors; coats as smooth as the second show lamps.
constexpr double kMirrorRoughness = 0.25;
constexpr double kGlossyRoughness = 0.5;
constexpr double kIndexOfRefraction = 1.5;    // where a material names none
constexpr double kDielectricSpecular = 0.04;  // straight on, of that index

// What a coat reflects of even light that reflects so much straight on, by Schlick's formula.
Rgb CoatOf(const Rgb& specular) { return specular + (Rgb(1.0) - specular) / 21.0; }

double LargestOf(const Rgb& c) { return std::max({c.x, c.y, c.z}); }

// Reads one material. Errors name it and the key.
class MaterialReader {
 public:
  MaterialReader(const GltfDocument& document, size_t number, std::vector<std::string>* images)
      : document_(document),
        from_(document.model.materials[number]),
        images_(*images),
        element_(fmt::format("materials[{}]", number)) {}

  Result<FileMaterial> Read();

 private:
  Status ReadMetallicRoughness();
  Status ReadSpecularGlossiness(const Value& extension);
  Status ReadEmission();
  Status ReadTransparency();
  Status ReadDiffuseTransmission();
  Status ReadTransmission(double share);

  const Value* Extension(const char* name) const {
    const auto found = from_.extensions.find(name);
    return found == from_.extensions.end() ? nullptr : &found->second;
  }
  // `missing` where the key is not there.
  Result<double> Number(const Value& object, const char* key, double missing) const;
  Result<Rgb> Colour(const Value& object, const char* key, Rgb missing) const;
  Result<Rgb> Colour(const std::vector<double>& numbers, const char* key, Rgb missing) const;
  // Empty for a texture of number −1.
  Result<FileMap> MapOf(const tinygltf::TextureInfo& info, const char* key);
  Status ReadTransform(const Value& extension, FileMap* map) const;
  void ReadWrap(int sampler, FileMap* map) const;
  Status KeepImage(size_t image);

  internal::Failure Fail(const char* key, const char* what) const {
    return document_.Error(StatusCode::kInvalidArgument, element_, "{} {}", key, what);
  }

  const GltfDocument& document_;
  const tinygltf::Material& from_;
  std::vector<std::string>& images_;
  std::string element_;
  FileMaterial to_;
  double alpha_ = 1;
};

constexpr char kNoNumber[] = "is not made of numbers of 0 or more; correct it";

Result<double> MaterialReader::Number(const Value& object, const char* key, double missing) const {
  if (!object.Has(key)) return missing;
  const Value& value = object.Get(key);
  const double number = value.GetNumberAsDouble();
  if (!value.IsNumber() || !(number >= 0) || !std::isfinite(number)) return Fail(key, kNoNumber);
  return number;
}

Result<Rgb> MaterialReader::Colour(const std::vector<double>& numbers, const char* key,
                                   Rgb missing) const {
  if (numbers.empty()) return missing;
  if (numbers.size() < 3) return Fail(key, kNoNumber);
  for (int c = 0; c < 3; ++c) {
    if (!(numbers[c] >= 0) || !std::isfinite(numbers[c])) return Fail(key, kNoNumber);
  }
  return Rgb(numbers[0], numbers[1], numbers[2]);
}

Result<Rgb> MaterialReader::Colour(const Value& object, const char* key, Rgb missing) const {
  if (!object.Has(key)) return missing;
  const Value& value = object.Get(key);
  std::vector<double> numbers;
  for (size_t i = 0; i < std::min<size_t>(value.ArrayLen(), 4); ++i) {
    const Value& number = value.Get(static_cast<int>(i));
    if (!number.IsNumber()) return Fail(key, kNoNumber);
    numbers.push_back(number.GetNumberAsDouble());
  }
  if (numbers.empty()) return Fail(key, kNoNumber);
  return Colour(numbers, key, missing);
}

Status MaterialReader::KeepImage(size_t image) {
  const tinygltf::Image& source = document_.model.images[image];
  if (!images_[image].empty()) return {};
  if (source.bufferView < 0) {
    images_[image].assign(source.image.begin(), source.image.end());
    return {};
  }
  ASSIGN_OR_RETURN(const std::span<const uint8_t> bytes, BytesOfView(document_, source.bufferView));
  images_[image].assign(bytes.begin(), bytes.end());
  return {};
}

// KHR_texture_transform: scaled, then turned, then moved.
Status MaterialReader::ReadTransform(const Value& extension, FileMap* map) const {
  const auto pair = [&](const char* key, double missing, std::array<double, 2>* numbers) {
    *numbers = {missing, missing};
    if (!extension.Has(key)) return true;
    const Value& value = extension.Get(key);
    for (int i = 0; i < 2; ++i) {
      if (value.ArrayLen() != 2 || !value.Get(i).IsNumber()) return false;
      (*numbers)[i] = value.Get(i).GetNumberAsDouble();
    }
    return true;
  };
  std::array<double, 2> offset, scale;
  double angle = 0;
  if (extension.Has("rotation")) angle = extension.Get("rotation").GetNumberAsDouble();
  if (!pair("offset", 0, &offset) || !pair("scale", 1, &scale) || !std::isfinite(angle)) {
    return Fail("KHR_texture_transform", "has an offset, scale or rotation that is none");
  }
  if (extension.Has("texCoord")) map->set = extension.Get("texCoord").GetNumberAsInt();
  const double c = std::cos(angle), s = std::sin(angle);
  map->transform = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
  return {};
}

void MaterialReader::ReadWrap(int sampler, FileMap* map) const {
  const auto& samplers = document_.model.samplers;
  if (sampler < 0 || static_cast<size_t>(sampler) >= samplers.size()) return;
  const auto wrap = [](int mode) {
    return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Wrap::kClamp
           : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::kMirror
                                                           : Wrap::kRepeat;
  };
  map->wrap_u = wrap(samplers[sampler].wrapS);
  map->wrap_v = wrap(samplers[sampler].wrapT);
}

Result<FileMap> MaterialReader::MapOf(const tinygltf::TextureInfo& info, const char* key) {
  FileMap map;
  if (info.index < 0) return map;
  const tinygltf::Model& model = document_.model;
  if (static_cast<size_t>(info.index) >= model.textures.size()) {
    return Fail(key, "names a texture that is not there; is the file whole?");
  }
  const tinygltf::Texture& texture = model.textures[info.index];
  map.set = info.texCoord;
  ReadWrap(texture.sampler, &map);
  const auto transform = info.extensions.find("KHR_texture_transform");
  if (transform != info.extensions.end()) RETURN_IF_ERROR(ReadTransform(transform->second, &map));
  if (texture.source < 0) {  // its image is in a format of an extension
    map.name = fmt::format("textures[{}]", info.index);
    map.embedded = static_cast<uint32_t>(model.images.size());
    return map;
  }
  if (static_cast<size_t>(texture.source) >= model.images.size()) {
    return Fail(key, "names an image that is not there; is the file whole?");
  }
  RETURN_IF_ERROR(KeepImage(texture.source));
  map.name = fmt::format("images[{}]", texture.source);
  map.embedded = static_cast<uint32_t>(texture.source);
  return map;
}

Status MaterialReader::ReadMetallicRoughness() {
  const tinygltf::PbrMetallicRoughness& pbr = from_.pbrMetallicRoughness;
  ASSIGN_OR_RETURN(to_.diffuse, Colour(pbr.baseColorFactor, "baseColorFactor", Rgb(1.0)));
  if (pbr.baseColorFactor.size() > 3) alpha_ = pbr.baseColorFactor[3];
  ASSIGN_OR_RETURN(to_.diffuse_map, MapOf(pbr.baseColorTexture, "baseColorTexture"));
  if (!(pbr.metallicFactor >= 0 && pbr.metallicFactor <= 1)) {
    return Fail("metallicFactor", "is outside [0, 1]; correct it");
  }
  to_.metallic = pbr.metallicFactor;
  if (to_.metallic > 0) {
    ASSIGN_OR_RETURN(to_.metallic_map,
                     MapOf(pbr.metallicRoughnessTexture, "metallicRoughnessTexture"));
  }
  to_.mirror = to_.metallic > 0 && pbr.roughnessFactor <= kMirrorRoughness;
  if (to_.mirror) to_.specular = to_.diffuse;
  to_.glossy = !to_.mirror && (to_.metallic > 0 || pbr.roughnessFactor <= kGlossyRoughness);
  if (to_.glossy && pbr.roughnessFactor <= kGlossyRoughness) {
    to_.lobe = (1 - to_.metallic) * CoatOf(Rgb(kDielectricSpecular));
  }
  return {};
}

Status MaterialReader::ReadSpecularGlossiness(const Value& extension) {
  ASSIGN_OR_RETURN(to_.diffuse, Colour(extension, "diffuseFactor", Rgb(1.0)));
  tinygltf::TextureInfo texture;
  if (extension.Has("diffuseTexture")) {
    const Value& info = extension.Get("diffuseTexture");
    if (!info.Has("index") || !info.Get("index").IsInt()) {
      return Fail("diffuseTexture", "has no index; correct it");
    }
    texture.index = info.Get("index").GetNumberAsInt();
    if (info.Has("texCoord")) texture.texCoord = info.Get("texCoord").GetNumberAsInt();
    if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform")) {
      texture.extensions["KHR_texture_transform"] =
          info.Get("extensions").Get("KHR_texture_transform");
    }
  }
  ASSIGN_OR_RETURN(to_.diffuse_map, MapOf(texture, "diffuseTexture"));
  ASSIGN_OR_RETURN(const Rgb specular, Colour(extension, "specularFactor", Rgb(1.0)));
  ASSIGN_OR_RETURN(const double glossiness, Number(extension, "glossinessFactor", 1));
  const bool metal = to_.diffuse_map.name.empty() && LargestOf(to_.diffuse) == 0;
  to_.metallic = 0;
  to_.metallic_map = {};
  to_.mirror = metal && LargestOf(specular) > 0 && 1 - glossiness <= kMirrorRoughness;
  to_.specular = to_.mirror ? specular : Rgb(0.0);
  to_.glossy = !to_.mirror && LargestOf(specular) > 0;
  to_.lobe = to_.glossy ? CoatOf(specular) : Rgb(0.0);
  return {};
}

Status MaterialReader::ReadEmission() {
  ASSIGN_OR_RETURN(to_.radiance, Colour(from_.emissiveFactor, "emissiveFactor", Rgb(0.0)));
  if (const Value* extension = Extension("KHR_materials_emissive_strength")) {
    ASSIGN_OR_RETURN(const double strength, Number(*extension, "emissiveStrength", 1));
    to_.radiance *= strength;
    if (!std::isfinite(Sum(to_.radiance))) return Fail("emissiveStrength", kNoNumber);
  }
  ASSIGN_OR_RETURN(to_.emission_map, MapOf(from_.emissiveTexture, "emissiveTexture"));
  return {};
}

Status MaterialReader::ReadTransparency() {
  const bool blends = from_.alphaMode == "BLEND";
  to_.opacity_map = (blends || from_.alphaMode == "MASK") && !to_.diffuse_map.name.empty();
  to_.glass = blends && alpha_ < 0.999;
  to_.clear = Rgb(1 - alpha_);
  to_.scattered = alpha_ * (1 - to_.metallic) * to_.diffuse;
  if (const Value* extension = Extension("KHR_materials_transmission")) {
    ASSIGN_OR_RETURN(const double share, Number(*extension, "transmissionFactor", 0));
    if (share > 1) return Fail("transmissionFactor", "is above 1; correct it");
    if (share > 0) RETURN_IF_ERROR(ReadTransmission(share));
    to_.diffuse *= 1 - share;
    to_.glass = to_.glass || share > 0;
  }
  if (to_.glass) to_.mirror = to_.glossy = false;
  if (to_.glass) to_.specular = Rgb(0.0);
  return {};
}

// The factor takes its share from what is reflected diffusely and gives it to what passes, in its
// own colour. A metal has neither.
Status MaterialReader::ReadDiffuseTransmission() {
  const Value* extension = Extension("KHR_materials_diffuse_transmission");
  if (extension == nullptr) return {};
  ASSIGN_OR_RETURN(const double share, Number(*extension, "diffuseTransmissionFactor", 0));
  if (share > 1) return Fail("diffuseTransmissionFactor", "is above 1; correct it");
  ASSIGN_OR_RETURN(const Rgb colour,
                   Colour(*extension, "diffuseTransmissionColorFactor", Rgb(1.0)));
  if (LargestOf(colour) > 1)
    return Fail("diffuseTransmissionColorFactor", "is above 1; correct it");
  to_.transmittance = share * (1 - to_.metallic) * colour;
  to_.diffuse *= 1 - share;
  to_.sheet_maps = share > 0 && (extension->Has("diffuseTransmissionTexture") ||
                                 extension->Has("diffuseTransmissionColorTexture"));
  return {};
}

// Of the dielectric part of a material; its interfaces reflect on top of that.
Status MaterialReader::ReadTransmission(double share) {
  to_.clear = share * (1 - to_.metallic) * to_.diffuse;
  to_.scattered = (1 - share) * (1 - to_.metallic) * to_.diffuse;
  to_.tinted = true;
  to_.index_of_refraction = kIndexOfRefraction;
  if (const Value* extension = Extension("KHR_materials_ior")) {
    ASSIGN_OR_RETURN(to_.index_of_refraction, Number(*extension, "ior", kIndexOfRefraction));
  }
  if (!(to_.index_of_refraction >= 1 && to_.index_of_refraction <= kLargestIndex)) {
    return Fail("ior", "of a material that transmits is not from 1 to 5; correct it");
  }
  const Value* volume = Extension("KHR_materials_volume");
  if (volume == nullptr || !volume->Has("attenuationDistance")) return {};
  ASSIGN_OR_RETURN(const double thickness_m, Number(*volume, "thicknessFactor", 0));
  ASSIGN_OR_RETURN(const double distance_m, Number(*volume, "attenuationDistance", 0));
  ASSIGN_OR_RETURN(const Rgb colour, Colour(*volume, "attenuationColor", Rgb(1.0)));
  if (!(distance_m > 0)) return Fail("attenuationDistance", "is not above 0; correct it");
  if (LargestOf(colour) > 1) return Fail("attenuationColor", "is above 1; correct it");
  for (int c = 0; c < 3; ++c) {
    to_.clear[c] *= std::pow(colour[c], thickness_m / distance_m);
  }
  return {};
}

Result<FileMaterial> MaterialReader::Read() {
  to_.name = from_.name.empty() ? element_ : from_.name;
  to_.where = fmt::format("{}: {}", document_.path, element_);
  RETURN_IF_ERROR(ReadMetallicRoughness());
  if (const Value* extension = Extension("KHR_materials_pbrSpecularGlossiness")) {
    RETURN_IF_ERROR(ReadSpecularGlossiness(*extension));
  }
  RETURN_IF_ERROR(ReadEmission());
  RETURN_IF_ERROR(ReadTransparency());
  RETURN_IF_ERROR(ReadDiffuseTransmission());
  to_.unlit = Extension("KHR_materials_unlit") != nullptr;
  to_.double_sided = from_.doubleSided;
  return std::move(to_);
}

}  // namespace

Result<std::vector<FileMaterial>> ReadGltfMaterials(const GltfDocument& document,
                                                    std::vector<std::string>* images) {
  const tinygltf::Model& model = document.model;
  images->assign(model.images.size() + 1, std::string());
  std::vector<FileMaterial> materials;
  for (size_t m = 0; m < model.materials.size(); ++m) {
    ASSIGN_OR_RETURN(FileMaterial material, MaterialReader(document, m, images).Read());
    materials.push_back(std::move(material));
  }
  return materials;
}

}  // namespace isolux
