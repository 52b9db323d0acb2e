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

  const Value* Extension(const char* name) const {
    const auto found = from_.extensions.find(name);
    return found == from_.extensions.end() ? nullptr : &found->second;
  }
  // `missing` where the key is not there.
  Result<double> Number(const Value& object, const char* key, double missing) const;
  Result<Rgb> Colour(const Value& object, const char* key, Rgb missing) const;
  Result<Rgb> Colour(const std::vector<double>& numbers, const char* key, Rgb missing) const;
  // Empty for a texture of number −1.
  Result<FileMap> MapOf(int texture, const char* key);
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

Result<FileMap> MaterialReader::MapOf(int texture, const char* key) {
  if (texture < 0) return FileMap{};
  const tinygltf::Model& model = document_.model;
  if (static_cast<size_t>(texture) >= model.textures.size()) {
    return Fail(key, "names a texture that is not there; is the file whole?");
  }
  const int source = model.textures[texture].source;
  if (source < 0) {  // its image is in a format of an extension
    return FileMap{fmt::format("textures[{}]", texture), "",
                   static_cast<uint32_t>(model.images.size())};
  }
  if (static_cast<size_t>(source) >= model.images.size()) {
    return Fail(key, "names an image that is not there; is the file whole?");
  }
  RETURN_IF_ERROR(KeepImage(source));
  return FileMap{fmt::format("images[{}]", source), "", static_cast<uint32_t>(source)};
}

Status MaterialReader::ReadMetallicRoughness() {
  const tinygltf::PbrMetallicRoughness& pbr = from_.pbrMetallicRoughness;
  ASSIGN_OR_RETURN(to_.diffuse, Colour(pbr.baseColorFactor, "baseColorFactor", Rgb(1.0)));
  if (pbr.baseColorFactor.size() > 3) alpha_ = pbr.baseColorFactor[3];
  ASSIGN_OR_RETURN(to_.diffuse_map, MapOf(pbr.baseColorTexture.index, "baseColorTexture"));
  if (!(pbr.metallicFactor >= 0 && pbr.metallicFactor <= 1)) {
    return Fail("metallicFactor", "is outside [0, 1]; correct it");
  }
  to_.metallic = pbr.metallicFactor;
  if (to_.metallic > 0) {
    ASSIGN_OR_RETURN(to_.metallic_map,
                     MapOf(pbr.metallicRoughnessTexture.index, "metallicRoughnessTexture"));
  }
  to_.mirror = to_.metallic > 0 && pbr.roughnessFactor <= kMirrorRoughness;
  to_.glossy = !to_.mirror && (to_.metallic > 0 || pbr.roughnessFactor <= kGlossyRoughness);
  return {};
}

Status MaterialReader::ReadSpecularGlossiness(const Value& extension) {
  ASSIGN_OR_RETURN(to_.diffuse, Colour(extension, "diffuseFactor", Rgb(1.0)));
  int texture = -1;
  if (extension.Has("diffuseTexture")) {
    const Value& info = extension.Get("diffuseTexture");
    if (!info.Has("index") || !info.Get("index").IsInt()) {
      return Fail("diffuseTexture", "has no index; correct it");
    }
    texture = info.Get("index").GetNumberAsInt();
  }
  ASSIGN_OR_RETURN(to_.diffuse_map, MapOf(texture, "diffuseTexture"));
  ASSIGN_OR_RETURN(const Rgb specular, Colour(extension, "specularFactor", Rgb(1.0)));
  ASSIGN_OR_RETURN(const double glossiness, Number(extension, "glossinessFactor", 1));
  const bool metal = to_.diffuse_map.name.empty() && LargestOf(to_.diffuse) == 0;
  to_.metallic = 0;
  to_.metallic_map = {};
  to_.mirror = metal && LargestOf(specular) > 0 && 1 - glossiness <= kMirrorRoughness;
  to_.glossy = !to_.mirror && LargestOf(specular) > 0;
  return {};
}

Status MaterialReader::ReadEmission() {
  ASSIGN_OR_RETURN(to_.radiance, Colour(from_.emissiveFactor, "emissiveFactor", Rgb(0.0)));
  if (const Value* extension = Extension("KHR_materials_emissive_strength")) {
    ASSIGN_OR_RETURN(const double strength, Number(*extension, "emissiveStrength", 1));
    to_.radiance *= strength;
    if (!std::isfinite(Sum(to_.radiance))) return Fail("emissiveStrength", kNoNumber);
  }
  ASSIGN_OR_RETURN(to_.emission_map, MapOf(from_.emissiveTexture.index, "emissiveTexture"));
  return {};
}

Status MaterialReader::ReadTransparency() {
  const bool blends = from_.alphaMode == "BLEND";
  to_.opacity_map = (blends || from_.alphaMode == "MASK") && !to_.diffuse_map.name.empty();
  to_.glass = blends && alpha_ < 0.999;
  if (const Value* extension = Extension("KHR_materials_transmission")) {
    ASSIGN_OR_RETURN(const double share, Number(*extension, "transmissionFactor", 0));
    if (share > 1) return Fail("transmissionFactor", "is above 1; correct it");
    to_.diffuse *= 1 - share;
    to_.glass = to_.glass || share > 0;
  }
  if (to_.glass) to_.mirror = to_.glossy = false;
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
