#include "client/import/gltf_materials.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <numbers>

#include "client/import/import.h"
#include "client/import/repair.h"
#include "client/import/texture_image.h"
#include "tests/support/gltf_file.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using testing::GltfFile;
using ::testing::HasSubstr;
using testing::TempDir;
using Json = GltfFile::Json;

class GltfMaterials : public ::testing::Test {
 protected:
  // A scene of a square with this material and a lamp; the material comes first.
  Result<Scene> TryRead(const Json& material, const ImportOptions& options = {}) {
    GltfFile file = file_;
    const Json lamp{
        {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}}},
        {"emissiveFactor", {1, 1, 1}}};
    file.json["materials"] = Json::array({material, lamp});
    file.Node({{"mesh", file.Square(0)}});
    file.Node({{"mesh", file.Square(1, 3)}});
    return ImportScene(dir_.Write("test.glb", file.Binary()), options);
  }
  Scene Read(const Json& material, const ImportOptions& options = {}) {
    Result<Scene> scene = TryRead(material, options);
    EXPECT_TRUE(scene.has_value()) << scene.error().message();
    if (scene.has_value()) return *std::move(scene);
    Scene none;
    none.materials.emplace_back();
    none.polygons.emplace_back();
    return none;
  }
  std::string ErrorOf(const Json& material) {
    const Result<Scene> scene = TryRead(material);
    EXPECT_FALSE(scene.has_value());
    return scene.has_value() ? "" : scene.error().message();
  }
  static uint64_t CountOf(const Scene& scene, Repair kind) {
    for (const auto& entry : scene.repairs.entries) {
      if (entry.kind == ToText(kind)) return entry.count;
    }
    return 0;
  }
  static void ExpectNear(const Rgb& a, const Rgb& b, double most = 1e-12) {
    EXPECT_LT(glm::length(a - b), most) << a.x << " " << a.y << " " << a.z;
  }
  // Image `number` of two columns of these colours, as a file beside the scene or in it.
  std::string Image(const std::array<uint8_t, 3>& left, const std::array<uint8_t, 3>& right) {
    std::vector<uint8_t> pixels(left.begin(), left.end());
    pixels.insert(pixels.end(), right.begin(), right.end());
    const std::string path = dir_.path() + "/image.png";
    EXPECT_NE(stbi_write_png(path.c_str(), 2, 1, 3, pixels.data(), 6), 0);
    return *ReadFile(path);
  }
  void AddTexture(const Json& image) {
    file_.json["images"].push_back(image);
    file_.json["textures"].push_back({{"source", file_.json["images"].size() - 1}});
  }

  TempDir dir_;
  GltfFile file_;
};

TEST_F(GltfMaterials, MetallicRoughness) {
  const Json dielectric{
      {"name", "wall"},
      {"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0.6, 0.4, 1}}, {"metallicFactor", 0}}}};
  Scene scene = Read(dielectric);
  EXPECT_EQ(scene.materials[0].name, "wall");
  ExpectNear(scene.materials[0].reflectance, {0.8, 0.6, 0.4});
  EXPECT_EQ(CountOf(scene, Repair::kGlossy), 0U);
  Json metal = dielectric;
  metal["pbrMetallicRoughness"]["metallicFactor"] = 0.75;
  scene = Read(metal);
  // Of a rough metal the base colour is what its lobe reflects: kept as diffuse.
  ExpectNear(scene.materials[0].reflectance, {0.8, 0.6, 0.4});
  ExpectNear(scene.materials[0].gloss.share, {0.6, 0.45, 0.3});
  EXPECT_TRUE(scene.materials[0].gloss.kept);
  EXPECT_EQ(CountOf(scene, Repair::kGlossy), 1U);
  metal["pbrMetallicRoughness"]["roughnessFactor"] = 0.1;
  const Scene mirror = Read(metal);
  EXPECT_EQ(CountOf(mirror, Repair::kMirror), 0U);
  EXPECT_EQ(CountOf(mirror, Repair::kMirrorColour), 1U);
  ExpectNear(mirror.materials[0].reflectance, {0.2, 0.15, 0.1});
  EXPECT_NEAR(mirror.materials[0].specular, 0.75 * 0.6, 1e-12);
  // Smooth, with a coat.
  Json coated = dielectric;
  coated["pbrMetallicRoughness"]["roughnessFactor"] = 0.4;
  ExpectNear(Read(coated).materials[0].reflectance, {0.8, 0.6, 0.4});
  ExpectNear(Read(coated).materials[0].gloss.share, Rgb(0.04 + 0.96 / 21));
  EXPECT_FALSE(Read(coated).materials[0].gloss.kept);
  // By default a rough white metal.
  ExpectNear(Read(Json::object()).materials[0].reflectance, Rgb(0.98));
  metal["pbrMetallicRoughness"]["metallicFactor"] = 1.5;
  EXPECT_THAT(ErrorOf(metal), HasSubstr("materials[0]: metallicFactor is outside [0, 1]"));
}

TEST_F(GltfMaterials, SpecularGlossiness) {
  const auto material = [](const Json& extension) {
    return Json{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 0, 0, 1}}}},
                {"extensions", {{"KHR_materials_pbrSpecularGlossiness", extension}}}};
  };
  Scene scene =
      Read(material({{"diffuseFactor", {0.1, 0.2, 0.3, 1}}, {"specularFactor", {0, 0, 0}}}));
  ExpectNear(scene.materials[0].reflectance, {0.1, 0.2, 0.3});
  EXPECT_EQ(CountOf(scene, Repair::kGlossy), 0U);
  scene = Read(material({{"diffuseFactor", {0, 0, 0, 1}}, {"glossinessFactor", 0.9}}));
  EXPECT_EQ(CountOf(scene, Repair::kMirror), 0U);
  EXPECT_EQ(scene.materials[0].specular, 1);
  ExpectNear(Read(material(Json::object())).materials[0].reflectance, Rgb(0.98));
  EXPECT_THAT(ErrorOf(material({{"diffuseFactor", {0.1, "x", 0.3}}})), HasSubstr("diffuseFactor"));
  EXPECT_THAT(ErrorOf(material({{"diffuseFactor", {0.1, -1, 0.3}}})), HasSubstr("diffuseFactor"));
  EXPECT_THAT(ErrorOf(material({{"diffuseTexture", {{"index", 4}}}})), HasSubstr("diffuseTexture"));
}

TEST_F(GltfMaterials, EmissionIsRadiance) {
  Json lamp{{"emissiveFactor", {1, 0.5, 0.25}}};
  const double pi = std::numbers::pi;
  ExpectNear(Read(lamp).materials[0].exitance, {pi, 0.5 * pi, 0.25 * pi});
  lamp["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 20;
  ExpectNear(Read(lamp).materials[0].exitance, {20 * pi, 10 * pi, 5 * pi});
  lamp["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = -1;
  EXPECT_THAT(ErrorOf(lamp), HasSubstr("materials[0]: emissiveStrength"));
  EXPECT_THAT(ErrorOf({{"emissiveFactor", {1, -1, 0}}}), HasSubstr("materials[0]: emissiveFactor"));
}

TEST_F(GltfMaterials, DoubleSidedLampsShineBothWays) {
  ImportOptions options;
  options.reflect_front = true;
  const Json lamp{{"emissiveFactor", {1, 1, 1}}};
  Json both = lamp;
  both["doubleSided"] = true;
  EXPECT_EQ(Read(lamp, options).polygons[0].sides, kFrontTakesPart | kFrontEmits);
  EXPECT_EQ(Read(both, options).polygons[0].sides,
            kFrontTakesPart | kFrontEmits | kBackTakesPart | kBackEmits);
  const Json white{{"doubleSided", true}};
  EXPECT_EQ(Read(white, options).polygons[0].sides, kFrontTakesPart | kBackTakesPart);
}

TEST_F(GltfMaterials, MapsCountByTheirMean) {
  const std::string image = Image({255, 0, 188}, {0, 0, 188});
  AddTexture({{"uri", "image.png"}});
  AddTexture({{"uri", "data:image/png;base64," + testing::Base64(image)}});
  AddTexture({{"bufferView", file_.View(std::vector<uint8_t>(image.begin(), image.end()))},
              {"mimeType", "image/png"}});
  const Rgb mean(0.5, 0, FromSrgb(188 / 255.0));
  for (int texture = 0; texture < 3; ++texture) {
    const Json material{{"pbrMetallicRoughness",
                         {{"baseColorFactor", {0.5, 1, 0.8, 1}},
                          {"baseColorTexture", {{"index", texture}}},
                          {"metallicFactor", 0.5},
                          {"metallicRoughnessTexture", {{"index", texture}}}}},
                        {"emissiveFactor", {2, 2, 2}},
                        {"emissiveTexture", {{"index", texture}}}};
    const Scene scene = Read(material);
    // The blue channel of the other map is linear.
    const double metallic = 0.5 * 188 / 255;
    ExpectNear(scene.materials[0].reflectance, Rgb(0.25, 0, 0.8 * mean.z));
    ExpectNear(scene.materials[0].gloss.share, metallic * Rgb(0.25, 0, 0.8 * mean.z));
    ExpectNear(scene.materials[0].exitance, 2 * std::numbers::pi * mean);
    EXPECT_EQ(CountOf(scene, Repair::kMap), 2U);
    EXPECT_EQ(CountOf(scene, Repair::kEmissionMap), 1U);
  }
}

TEST_F(GltfMaterials, MapsThatAreMissingAreReported) {
  AddTexture({{"uri", "none.png"}});
  AddTexture(
      {{"bufferView", file_.View(std::vector<uint8_t>{1, 2, 3, 4})}, {"mimeType", "image/png"}});
  file_.json["textures"].push_back({{"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}});
  for (int texture = 0; texture < 3; ++texture) {
    const Scene scene = Read({{"pbrMetallicRoughness",
                               {{"baseColorFactor", {0.5, 0.5, 0.5, 1}},
                                {"metallicFactor", 0},
                                {"baseColorTexture", {{"index", texture}}}}}});
    ExpectNear(scene.materials[0].reflectance, Rgb(0.5));
    EXPECT_EQ(CountOf(scene, Repair::kNoMap), 1U);
  }
  file_.json["textures"][0]["source"] = 9;
  EXPECT_THAT(ErrorOf({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}),
              HasSubstr("materials[0]: baseColorTexture names an image that is not there"));
}

TEST_F(GltfMaterials, SheetsReflectWhatDoesNotPass) {
  Json material{
      {"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0.6, 0.4, 1}}, {"metallicFactor", 0}}}};
  Json& extension = material["extensions"]["KHR_materials_diffuse_transmission"];
  extension = {{"diffuseTransmissionFactor", 0.25},
               {"diffuseTransmissionColorFactor", {1, 0.8, 0.4}}};
  file_.json["extensionsUsed"] = {"KHR_materials_diffuse_transmission"};
  file_.json["extensionsRequired"] = {"KHR_materials_diffuse_transmission"};
  const Scene scene = Read(material);
  ExpectNear(scene.materials[0].reflectance, {0.6, 0.45, 0.3});
  ExpectNear(scene.materials[0].transmittance, {0.25, 0.2, 0.1});
  EXPECT_EQ(CountOf(scene, Repair::kSheetMap), 0U);
  extension["diffuseTransmissionColorTexture"] = {{"index", 0}};
  EXPECT_EQ(CountOf(Read(material), Repair::kSheetMap), 1U);
  extension.erase("diffuseTransmissionColorTexture");
  // A metal has no diffuse part.
  material["pbrMetallicRoughness"]["metallicFactor"] = 1;
  ExpectNear(Read(material).materials[0].transmittance, Rgb(0.0));
  material["pbrMetallicRoughness"]["metallicFactor"] = 0;
  extension["diffuseTransmissionFactor"] = 0;
  ExpectNear(Read(material).materials[0].reflectance, {0.8, 0.6, 0.4});
  ExpectNear(Read(material).materials[0].transmittance, Rgb(0.0));
  extension["diffuseTransmissionFactor"] = 1.5;
  EXPECT_THAT(ErrorOf(material), HasSubstr("diffuseTransmissionFactor is above 1"));
  extension["diffuseTransmissionFactor"] = "half";
  EXPECT_THAT(ErrorOf(material), HasSubstr("materials[0]: diffuseTransmissionFactor"));
  extension["diffuseTransmissionFactor"] = 0.5;
  extension["diffuseTransmissionColorFactor"] = {1, 2, 1};
  EXPECT_THAT(ErrorOf(material), HasSubstr("diffuseTransmissionColorFactor is above 1"));
}

TEST_F(GltfMaterials, GlassAndUnlitAreReported) {
  Json material{
      {"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0.8, 0.8, 0.9}}, {"metallicFactor", 0}}}};
  EXPECT_EQ(CountOf(Read(material), Repair::kGlass), 0U);
  material["alphaMode"] = "BLEND";
  EXPECT_EQ(CountOf(Read(material), Repair::kGlass), 1U);
  material.erase("alphaMode");
  material["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = 0.25;
  const Scene scene = Read(material);
  EXPECT_EQ(CountOf(scene, Repair::kGlass), 1U);
  ExpectNear(scene.materials[0].reflectance, Rgb(0.6));
  material["extensions"] = {{"KHR_materials_unlit", Json::object()}};
  EXPECT_EQ(CountOf(Read(material), Repair::kUnlit), 1U);
}

}  // namespace
}  // namespace isolux
