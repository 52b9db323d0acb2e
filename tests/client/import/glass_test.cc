// Materials that light passes: what becomes a pane of which glass, and what stays opaque.
#include "client/import/glass.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "client/import/import.h"
#include "tests/support/gltf_file.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using testing::GltfFile;
using ::testing::HasSubstr;
using testing::TempDir;
using Json = GltfFile::Json;

uint64_t CountOf(const Scene& scene, Repair kind) {
  for (const auto& entry : scene.repairs.entries) {
    if (entry.kind == ToText(kind)) return entry.count;
  }
  return 0;
}

// What the inside of the first pane's glass leaves.
Rgb InsideOf(const Scene& scene) {
  const Glass& glass = scene.glazing.glasses[scene.glazing.panes[0].glass];
  return glm::exp(-glass.optical_depth);
}

constexpr char kLamp[] =
    "mtllib test.mtl\nv 0 0 2\nv 0 1 2\nv 1 1 2\nv 1 0 2\nusemtl lamp\nf 1 2 3 4\n";
constexpr char kPane[] = "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl glass\nf 5 6 7 8\n";

class MtlGlass : public ::testing::Test {
 protected:
  Result<Scene> TryRead(const std::string& glass, const std::string& faces = kPane) {
    dir_.Write("test.mtl", "newmtl lamp\nKe 1 1 1\nnewmtl glass\n" + glass);
    return ImportScene(dir_.Write("test.obj", kLamp + faces), {});
  }
  Scene Read(const std::string& glass, const std::string& faces = kPane) {
    Result<Scene> scene = TryRead(glass, faces);
    EXPECT_TRUE(scene.has_value()) << scene.error().message();
    if (!scene.has_value()) return {};
    EXPECT_TRUE(Validate(*scene).ok()) << Validate(*scene).message();
    return *std::move(scene);
  }
  TempDir dir_;
};

TEST_F(MtlGlass, NumbersTellWhatTheInsideLeaves) {
  const struct {
    const char* text;
    Rgb inside;
    double index;
  } cases[] = {
      {"Kd 0 0 0\nd 0\nNi 1.5\nillum 9\n", Rgb(1), 1.5},
      {"Kd 0 0 0\nTr 0.75\n", Rgb(0.75), 1},
      {"Kd 0 0 0\nd 0.5\nTf 0 0 0\n", Rgb(0.5), 1},
      {"Kd 0 0 0\nd 0.5\nTf 0.2 1 0.6\nNi 1.6\n", Rgb(0.1, 0.5, 0.3), 1.6},
      {"Kd 0 0 0\nTf 0.2 0.9 0.6\n", Rgb(0.2, 0.9, 0.6), 1},
      {"Kd 0 0 0\nTf 1 1 1\nillum 7\nNi 1.5\n", Rgb(1), 1.5},
  };
  for (const auto& c : cases) {
    const Scene scene = Read(c.text);
    ASSERT_EQ(scene.glazing.panes.size(), 1U) << c.text;
    EXPECT_EQ(scene.polygons.size(), 1U);  // the lamp
    EXPECT_LT(glm::length(InsideOf(scene) - c.inside), 1e-6) << c.text;
    EXPECT_NEAR(scene.glazing.glasses[0].index, c.index, 1e-6) << c.text;
    EXPECT_EQ(CountOf(scene, Repair::kGlass), 0U);
    EXPECT_FALSE(scene.glazing.panes[0].is_half);
  }
}

TEST_F(MtlGlass, WhatReflectsMoreOrEmitsStaysOpaque) {
  for (const char* text : {"Kd 0.8 0.8 0.8\nTf 1 1 1\nillum 4\n", "Kd 0.9 0.9 0.9\nd 0.7\n",
                           "Kd 0 0 0\nKe 1 1 1\nd 0.5\n", "Kd 0 0 0\nd 0.5\nmap_d a.png\n"}) {
    const Scene scene = Read(text);
    EXPECT_FALSE(scene.glazing.exists()) << text;
    EXPECT_EQ(scene.polygons.size(), 2U) << text;
    EXPECT_EQ(CountOf(scene, Repair::kGlass), 1U) << text;
  }
  const Scene shared = Read("Kd 0.5 0.5 0.5\nd 0.2\n");
  EXPECT_EQ(shared.glazing.panes.size(), 1U);
  EXPECT_EQ(CountOf(shared, Repair::kGlassShare), 1U);
}

// A sheet of 1 cm by its two faces, and two sheets that are 20 cm apart.
TEST_F(MtlGlass, FacesOfASlabAreHalves) {
  const auto two = [](double apart) {
    return std::string(kPane) +
           fmt::format("v 0 0 {0}\nv 1 0 {0}\nv 1 1 {0}\nv 0 1 {0}\nf 9 12 11 10\n", 1 + apart);
  };
  for (const bool near : {true, false}) {
    const Scene scene = Read("d 0\nNi 1.5\n", two(near ? 0.01 : 0.2));
    ASSERT_EQ(scene.glazing.panes.size(), 2U);
    for (const Pane& pane : scene.glazing.panes) EXPECT_EQ(pane.is_half, near);
  }
}

TEST_F(MtlGlass, ErrorsNameTheLine) {
  const auto error = [&](const char* text, const char* faces = kPane) {
    const Result<Scene> scene = TryRead(text, faces);
    EXPECT_FALSE(scene.has_value());
    return scene.has_value() ? std::string() : scene.error().message();
  };
  EXPECT_THAT(error("Tf 1 x 1\n"), HasSubstr("test.mtl:4: Tf 'x' is not a number"));
  EXPECT_THAT(error("Tf 1 1\n"), HasSubstr("test.mtl:4: Tf needs one or three numbers"));
  EXPECT_THAT(error("d 0\nNi 15\n"), HasSubstr("test.mtl:3: Ni 15 of glass is above 5"));
  dir_.Write("test.mtl", "newmtl glass\nd 0\n");
  const auto scene = ImportScene(dir_.Write("test.obj",
                                            "mtllib test.mtl\nv 0 0 1\nv 1 0 1\nv 1 1 1\n"
                                            "usemtl glass\nf 1 2 3\n"),
                                 {});
  ASSERT_FALSE(scene.has_value());
  EXPECT_THAT(scene.error().message(), HasSubstr("all faces are of clear glass"));
}

class GltfGlass : public ::testing::Test {
 protected:
  Result<Scene> TryRead(const Json& material) {
    GltfFile file;
    const Json lamp{{"emissiveFactor", {1, 1, 1}}};
    file.json["materials"] = Json::array({material, lamp});
    file.Node({{"mesh", file.Square(0)}});
    file.Node({{"mesh", file.Square(1, 3)}});
    return ImportScene(dir_.Write("test.glb", file.Binary()), {});
  }
  static Json Material(double transmission) {
    Json material{{"pbrMetallicRoughness",
                   {{"baseColorFactor", {0.8, 0.4, 1.0, 1.0}}, {"metallicFactor", 0}}}};
    material["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = transmission;
    return material;
  }
  TempDir dir_;
};

TEST_F(GltfGlass, FactorsTellWhatTheInsideLeaves) {
  Json material = Material(1);
  auto scene = TryRead(material);
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  ASSERT_TRUE(scene->glazing.exists());
  EXPECT_LT(glm::length(InsideOf(*scene) - Rgb(0.8, 0.4, 1.0)), 1e-12);
  EXPECT_EQ(scene->glazing.glasses[0].index, 1.5);
  material["extensions"]["KHR_materials_ior"]["ior"] = 1.3;
  material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 0.02},
                                                    {"attenuationDistance", 0.01},
                                                    {"attenuationColor", {0.5, 1, 0.1}}};
  scene = TryRead(material);
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  EXPECT_LT(glm::length(InsideOf(*scene) - Rgb(0.2, 0.4, 0.01)), 1e-12);
  EXPECT_EQ(scene->glazing.glasses[0].index, 1.3);
  scene = TryRead(Material(0.3));
  ASSERT_TRUE(scene.has_value());
  EXPECT_FALSE(scene->glazing.exists());
  EXPECT_EQ(CountOf(*scene, Repair::kGlass), 1U);
  // Coverage, without interfaces.
  material = Material(0);
  material["alphaMode"] = "BLEND";
  material["pbrMetallicRoughness"]["baseColorFactor"] = {0.2, 0.2, 0.2, 0.25};
  scene = TryRead(material);
  ASSERT_TRUE(scene.has_value());
  ASSERT_TRUE(scene->glazing.exists());
  EXPECT_LT(glm::length(InsideOf(*scene) - Rgb(0.75)), 1e-12);
  EXPECT_EQ(scene->glazing.glasses[0].index, 1);
}

TEST_F(GltfGlass, ErrorsNameTheMaterial) {
  const auto error = [&](const char* extension, const Json& value) {
    Json material = Material(1);
    material["extensions"][extension] = value;
    const Result<Scene> scene = TryRead(material);
    EXPECT_FALSE(scene.has_value());
    return scene.has_value() ? std::string() : scene.error().message();
  };
  EXPECT_THAT(error("KHR_materials_ior", {{"ior", 0.5}}),
              HasSubstr("materials[0]: ior of a material that transmits is not from 1 to 5"));
  EXPECT_THAT(error("KHR_materials_ior", {{"ior", "x"}}), HasSubstr("materials[0]: ior"));
  EXPECT_THAT(error("KHR_materials_volume", {{"attenuationDistance", 0}}),
              HasSubstr("attenuationDistance is not above 0"));
  EXPECT_THAT(
      error("KHR_materials_volume", {{"attenuationDistance", 1}, {"attenuationColor", {2, 1, 1}}}),
      HasSubstr("attenuationColor is above 1"));
}

}  // namespace
}  // namespace isolux
