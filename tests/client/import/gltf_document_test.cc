#include "client/import/gltf_document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <filesystem>

#include "client/import/gltf_reader.h"
#include "client/import/import.h"
#include "common/util/random.h"
#include "tests/support/gltf_file.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

using testing::GltfFile;
using ::testing::HasSubstr;
using testing::TempDir;
using Json = GltfFile::Json;

// A lamp over a floor.
GltfFile Lit() {
  GltfFile file;
  const int lamp = file.Material({{"name", "lamp"}, {"emissiveFactor", {1, 1, 1}}});
  const int white = file.Material(
      {{"pbrMetallicRoughness", {{"baseColorFactor", {0.7, 0.7, 0.7, 1}}, {"metallicFactor", 0}}}});
  file.Node(
      {{"mesh", file.Square(lamp, 2)}, {"rotation", {1, 0, 0, 0}}, {"translation", {0, 0, 4}}});
  file.Node({{"mesh", file.Square(white)}});
  return file;
}

std::string ErrorOf(const std::string& path) {
  const Result<Scene> scene = ImportScene(path, {});
  EXPECT_FALSE(scene.has_value());
  if (scene.has_value()) return "";
  EXPECT_THAT(scene.error().message(), HasSubstr(fs::path(path).filename().string()));
  return scene.error().message();
}

TEST(GltfDocument, ReadsFilesBesideTheScene) {
  const TempDir dir;
  const GltfFile file = Lit();
  dir.Write("data/a b.bin", file.buffer);
  const Result<Scene> scene = ImportScene(dir.Write("test.gltf", file.Text("data/a%20b.bin")), {});
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  EXPECT_EQ(scene->polygons.size(), 2U);
  EXPECT_THAT(ErrorOf(dir.Write("none.gltf", file.Text("none.bin"))), HasSubstr("none.bin"));
  dir.Write("data/short.bin", "abc");
  EXPECT_THAT(ErrorOf(dir.Write("short.gltf", file.Text("data/short.bin"))),
              HasSubstr("short.bin"));
}

TEST(GltfDocument, NeverLeavesItsFolder) {
  const TempDir dir;
  const GltfFile file = Lit();
  const std::string outside = dir.Write("outside.bin", file.buffer);
  dir.Write("scene/sub/inside.bin", file.buffer);
  fs::create_symlink(outside, dir.path() + "/scene/link.bin");
  fs::create_symlink(dir.path(), dir.path() + "/scene/up");
  fs::create_symlink("sub/inside.bin", dir.path() + "/scene/good.bin");
  for (const std::string uri :
       {"../outside.bin", "sub/../../outside.bin", "%2e%2e/outside.bin", "link.bin",
        "up/outside.bin", "file:outside.bin", "file:///etc/passwd", "/etc/passwd",
        "http://localhost/x.bin", "sub/../sub/inside.bin"}) {
    SCOPED_TRACE(uri);
    EXPECT_THAT(ErrorOf(dir.Write("scene/test.gltf", file.Text(uri))), HasSubstr("leads out of"));
  }
  EXPECT_THAT(ErrorOf(dir.Write("scene/test.gltf", file.Text(outside))), HasSubstr("leads out of"));
  // An image would only be missing, but a scene that reaches for one outside is refused whole.
  GltfFile image = Lit();
  image.json["images"] = Json::array({{{"uri", "../outside.bin"}}});
  EXPECT_THAT(ErrorOf(dir.Write("scene/test.gltf", image.Text())), HasSubstr("leads out of"));
  for (const char* uri : {"good.bin", "sub/inside.bin", "./sub/inside.bin"}) {
    EXPECT_TRUE(ImportScene(dir.Write("scene/test.gltf", file.Text(uri)), {}).has_value()) << uri;
  }
}

TEST(GltfDocument, RefusesExtensionsAndVersionsItDoesNotKnow) {
  const TempDir dir;
  GltfFile file = Lit();
  file.json["extensionsRequired"] = Json::array({"KHR_draco_mesh_compression"});
  EXPECT_THAT(ErrorOf(dir.Write("a.gltf", file.Text())),
              HasSubstr("'KHR_draco_mesh_compression' is not read; export the scene without it"));
  file = Lit();
  file.json["extensionsUsed"] = Json::array({"FB_ngon_encoding", "ACME_unknown"});
  EXPECT_TRUE(ImportScene(dir.Write("a.gltf", file.Text()), {}).has_value());
  file.json["asset"]["version"] = "1.0";
  EXPECT_THAT(ErrorOf(dir.Write("a.gltf", file.Text())), HasSubstr("export the scene as glTF 2.0"));
  file.json["asset"] = {{"version", "2.1"}, {"minVersion", "2.1"}};
  EXPECT_THAT(ErrorOf(dir.Write("a.gltf", file.Text())), HasSubstr("asset.minVersion '2.1'"));
  file.json.erase("asset");
  EXPECT_THAT(ErrorOf(dir.Write("a.gltf", file.Text())), HasSubstr("asset"));
}

TEST(GltfDocument, RefusesContainersThatLie) {
  const TempDir dir;
  const std::string whole = Lit().Binary();
  const auto with_word = [&](size_t at, uint32_t value) {
    std::string bytes = whole;
    for (int i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(value >> (8 * i) & 255);
    return ErrorOf(dir.Write("a.glb", bytes));
  };
  const auto word = [&](size_t at) {
    uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
      value |= static_cast<uint32_t>(static_cast<uint8_t>(whole[at + i])) << 8 * i;
    return value;
  };
  EXPECT_TRUE(ImportScene(dir.Write("a.glb", whole), {}).has_value());
  EXPECT_THAT(with_word(4, 1), HasSubstr("version 1; export it as glTF 2.0"));
  EXPECT_THAT(with_word(8, word(8) + 4), HasSubstr("is the file whole?"));
  EXPECT_THAT(with_word(12, word(12) + 4096), HasSubstr("no whole JSON chunk"));
  EXPECT_THAT(with_word(12, ~0U), HasSubstr("no whole JSON chunk"));
  const size_t binary = 20 + word(12);
  // Eight bytes too many: within the file by the length of the chunk, beyond it by its head.
  EXPECT_THAT(with_word(binary, word(binary) + 8), HasSubstr("longer than the file"));
  EXPECT_THAT(with_word(binary, ~0U), HasSubstr("longer than the file"));
  EXPECT_THAT(ErrorOf(dir.Write("a.glb", whole.substr(0, 19))), HasSubstr("too short"));
  EXPECT_THAT(ErrorOf(dir.Write("a.glb", "")), HasSubstr("a.glb"));
}

TEST(GltfDocument, RefusesJsonBombs) {
  const TempDir dir;
  const std::string head = R"({"asset":{"version":"2.0"},"extras":)";
  const std::string deep = head + std::string(100'000, '[') + std::string(100'000, ']') + "}";
  EXPECT_THAT(ErrorOf(dir.Write("a.gltf", deep)), HasSubstr("more than 64 levels"));
  std::string wide = head + "[0";
  for (int i = 0; i < 4'000'001; ++i) wide += ",0";
  EXPECT_THAT(ErrorOf(dir.Write("a.gltf", wide + "]}")), HasSubstr("4000000 values"));
  EXPECT_THAT(ErrorOf(dir.Write("a.gltf", head + R"("[[[\"[[[")")), HasSubstr("a.gltf"));
}

// Random damage to text and binary files: a scene that the solver takes, or an error that says
// something.
TEST(GltfDocument, DamagedFilesGiveAnErrorOrAScene) {
  const TempDir dir;
  GltfFile file = Lit();
  file.Material({{"extensions",
                  {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseTexture", {{"index", 0}}}}},
                   {"KHR_materials_emissive_strength", {{"emissiveStrength", 3}}},
                   {"KHR_materials_transmission", {{"transmissionFactor", 0.5}}}}}});
  file.json["textures"] = Json::array({{{"source", 0}}});
  const std::vector<uint8_t> pixels(48, 128);
  const std::string png = dir.path() + "/grey.png";
  ASSERT_NE(stbi_write_png(png.c_str(), 4, 4, 3, pixels.data(), 12), 0);
  const std::string image = *ReadFile(png);
  const int view = file.View(std::vector<uint8_t>(image.begin(), image.end()));
  file.json["images"] = Json::array({{{"bufferView", view}, {"mimeType", "image/png"}}});
  const int strip = file.Mesh(file.Points({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}), -1, 2, 5);
  file.Node({{"mesh", strip}, {"scale", {1, -1, 1}}, {"children", {3}}});
  file.Node({{"mesh", strip}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 1}}}, false);
  const int sparse = file.View(std::vector<uint16_t>{1, 3});
  const int moved = file.View(std::vector<float>{1, 0, 1.5, 1, 1, 1.5});
  file.json["accessors"].back()["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", sparse}, {"componentType", 5123}}},
      {"values", {{"bufferView", moved}}}};
  const std::string whole[] = {file.Text(), file.Binary()};
  ASSERT_TRUE(ImportScene(dir.Write("test.gltf", whole[0]), {}).has_value());
  const char interesting[] = "0123456789-+.eE{}[]\",: \0\x01\x7f\x80\xff";
  int scenes = 0;
  for (uint64_t seed = 1; seed <= 8000; ++seed) {
    Random random(Mix(seed));
    const bool binary = random.Bits() % 2 == 0;
    std::string bytes = whole[binary ? 1 : 0];
    for (int i = 1 + static_cast<int>(random.Bits() % 4); i > 0 && !bytes.empty(); --i) {
      const size_t at = random.Bits() % bytes.size();
      const size_t digit = bytes.find_first_of("0123456789", at);
      switch (random.Bits() % 16) {
        case 0:
          bytes.resize(at);
          break;
        case 1:
          bytes.erase(at, 1 + random.Bits() % 8);
          break;
        case 2:
          bytes.insert(at, bytes.substr(random.Bits() % bytes.size(), random.Bits() % 40));
          break;
        case 3:
        case 4:
          bytes[at] = interesting[random.Bits() % (sizeof interesting - 1)];
          break;
        default:  // what keeps the syntax
          if (digit != std::string::npos)
            bytes[digit] = static_cast<char>('0' + random.Bits() % 10);
      }
    }
    const std::string name = binary ? "test.glb" : "test.gltf";
    const Result<SceneFile> file_scene = ParseGltf(bytes, name);
    if (!file_scene.has_value()) {
      EXPECT_THAT(file_scene.error().message(), HasSubstr(name)) << "seed " << seed;
      continue;
    }
    ++scenes;
    if (scenes % 8 != 0) continue;
    const Result<Scene> scene = ImportScene(dir.Write(name, bytes), {});
    if (!scene.has_value()) {
      EXPECT_THAT(scene.error().message(), HasSubstr(name)) << "seed " << seed;
      continue;
    }
    const Status status = Validate(*scene);
    EXPECT_TRUE(status.ok()) << "seed " << seed << ": " << status.message();
  }
  EXPECT_GT(scenes, 1000);
  EXPECT_LT(scenes, 7000);
}

}  // namespace
}  // namespace isolux
