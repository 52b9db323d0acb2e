#include "client/import/import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <numbers>

#include "client/import/repair.h"
#include "client/import/texture_image.h"
#include "common/util/random.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using ::testing::HasSubstr;
using testing::TempDir;

const char kMaterials[] =
    "newmtl white\nKd 0.7 0.7 0.7\n"
    "newmtl red\nKd 0.6 0.1 0.1\n"
    "newmtl lamp\nKd 0.5 0.5 0.5\nKe 10 20 30\n";
// A lamp above a floor, far from everything else.
const char kLamp[] =
    "mtllib test.mtl\n"
    "v 0 0 2\nv 0 1 2\nv 1 1 2\nv 1 0 2\nusemtl lamp\nf 1 2 3 4\n";

uint64_t CountOf(const Scene& scene, Repair kind) {
  for (const auto& entry : scene.repairs.entries) {
    if (entry.kind == ToText(kind)) return entry.count;
  }
  return 0;
}

class Import : public ::testing::Test {
 protected:
  Result<Scene> TryRead(const std::string& text, const ImportOptions& options = {}) {
    dir_.Write("test.mtl", materials_);
    return ImportScene(dir_.Write("test.obj", text), options);
  }
  Scene Read(const std::string& text, const ImportOptions& options = {}) {
    Result<Scene> scene = TryRead(text, options);
    EXPECT_TRUE(scene.has_value()) << scene.error().message();
    if (!scene.has_value()) return {};
    EXPECT_TRUE(Validate(*scene).ok()) << Validate(*scene).message();
    return *std::move(scene);
  }
  std::string ErrorOf(const std::string& text, const ImportOptions& options = {}) {
    const Result<Scene> scene = TryRead(text, options);
    EXPECT_FALSE(scene.has_value());
    return scene.has_value() ? "" : scene.error().message();
  }
  // The lamp and some faces over vertices 5 and up.
  static std::string WithLamp(const std::string& text) { return kLamp + text; }

  TempDir dir_;
  std::string materials_ = kMaterials;
};

const char kFloor[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl white\n";

TEST_F(Import, MakesASceneInMetresAboutItsCentre) {
  ImportOptions options;
  options.unit = "mm";
  const Scene scene = Read(
      "mtllib test.mtl\nv 1000 2000 3000\nv 2000 2000 3000\nv 2000 4000 3000\nv 1000 4000 3000\n"
      "usemtl lamp\nf 1 2 3 4\n",
      options);
  EXPECT_EQ(scene.unit, "mm");
  EXPECT_EQ(scene.metres_per_unit, 0.001);
  EXPECT_NEAR(glm::length(scene.origin_m - Vec3(1.5, 3, 3)), 0, 1e-15);
  EXPECT_EQ(scene.vertices[0], Vec3(-0.5, -1, 0));
  EXPECT_NEAR(SideGeometry(scene, 0, Side::kFront).Area(), 2.0, 1e-15);
  EXPECT_EQ(scene.file_polygon_count, 1U);
  EXPECT_TRUE(scene.repairs.entries.empty());
}

TEST_F(Import, LeavesThePolygonsOfTheFileAlone) {
  const std::string text = WithLamp(std::string(kFloor) + "f 5 6 7\nf 7 8 5\n");
  ImportOptions options;
  EXPECT_EQ(Read(text, options).polygons.size(), 2U);
  options.prepare_for_transport = false;
  const Scene scene = Read(text, options);
  ASSERT_EQ(scene.polygons.size(), 3U);
  for (uint32_t p = 0; p < 3; ++p) EXPECT_EQ(scene.polygons[p].file_polygon, p);
  EXPECT_TRUE(scene.repairs.entries.empty());
}

TEST_F(Import, KnowsItsUnits) {
  const std::pair<const char*, double> units[] = {
      {"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  for (const auto& [unit, metres] : units) {
    ImportOptions options;
    options.unit = unit;
    EXPECT_EQ(Read(kLamp, options).metres_per_unit, metres);
  }
  ImportOptions options;
  options.unit = "yd";
  EXPECT_THAT(ErrorOf(kLamp, options), HasSubstr("choose m, cm, mm, in or ft"));
}

TEST_F(Import, FarFromTheOriginNothingCancels) {
  const Scene scene = Read(
      "mtllib test.mtl\nv 1e6 1e6 0\nv 1000000.001 1e6 0\nv 1000000.001 1000000.001 0\n"
      "v 1e6 1000000.001 0\nusemtl lamp\nf 1 2 3 4\n");
  EXPECT_NEAR(SideGeometry(scene, 0, Side::kFront).Area() / 1e-6, 1, 1e-6);
}

TEST_F(Import, RadianceBecomesExitance) {
  const Scene scene = Read(kLamp);
  ASSERT_EQ(scene.materials.size(), 1U);
  EXPECT_EQ(scene.materials[0].name, "lamp");
  EXPECT_NEAR(scene.materials[0].exitance.y, 20 * std::numbers::pi, 1e-12);
  EXPECT_EQ(scene.materials[0].reflectance, Rgb(0.5));
}

TEST_F(Import, SidesFollowTheFlags) {
  const std::string text = WithLamp(std::string(kFloor) + "f 5 6 7 8\n");
  const auto sides = [&](bool emit_both, bool reflect_front) {
    ImportOptions options;
    options.emit_both = emit_both;
    options.reflect_front = reflect_front;
    const Scene scene = Read(text, options);
    return std::pair<int, int>(scene.polygons[0].sides, scene.polygons[1].sides);
  };
  const int both = kFrontTakesPart | kBackTakesPart;
  const int front = kFrontTakesPart;
  EXPECT_EQ(sides(false, false), std::pair(both | kFrontEmits, both));
  EXPECT_EQ(sides(true, false), std::pair(both | kFrontEmits | kBackEmits, both));
  EXPECT_EQ(sides(false, true), std::pair(front | kFrontEmits, front));
  EXPECT_EQ(sides(true, true), std::pair(both | kFrontEmits | kBackEmits, front));
}

TEST_F(Import, KeepsTrianglesAndConvexQuadsAndDividesTheRest) {
  const Scene scene = Read(
      WithLamp("v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\n"      // 5-8: a concave arrow
               "v 9 0 0\nv 10 0 0\nv 10 1 0.5\nv 9 1 0\n"  // 9-12: bent
               "v 20 0 0\nv 22 0 0\nv 23 1 0\nv 22 2 0\nv 20 2 0\nv 19 1 0\n"  // 13-18: a hexagon
               "usemtl white\nf 5 6 7 8\nf 9 10 11 12\nf 13 14 15 16 17 18\nf 5 6 7\n"));
  EXPECT_EQ(CountOf(scene, Repair::kDivided), 2U);
  EXPECT_EQ(CountOf(scene, Repair::kNonPlanar), 1U);
  EXPECT_EQ(scene.file_polygon_count, 5U);
  double area[5] = {};
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    area[scene.polygons[p].file_polygon] += SideGeometry(scene, p, Side::kFront).Area();
  }
  EXPECT_NEAR(area[0], 1, 1e-12);
  EXPECT_NEAR(area[1], 4, 1e-12);
  EXPECT_GT(area[2], 1.0);
  EXPECT_NEAR(area[3], 6, 1e-12);
  EXPECT_EQ(area[4], 0);  // the same as a part of the arrow
  EXPECT_EQ(CountOf(scene, Repair::kDuplicate), 1U);
}

TEST_F(Import, QuadsWithAStraightCornerAreTriangles) {
  const Scene scene =
      Read(WithLamp("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 2 0\nusemtl white\nf 5 6 7 8\nf 5 5 7 8\n"));
  EXPECT_EQ(scene.polygons[1].vertex_count(), 3);
  EXPECT_EQ(CountOf(scene, Repair::kDuplicate), 1U);  // without the needless corners they are equal
}

TEST_F(Import, DropsFacesWithoutAreaAndKeepsTheNumbers) {
  const Scene scene =
      Read(WithLamp(std::string(kFloor) + "f 5 6 6\nf 5 6 5\nv 0.5 0 0\nf 5 9 6\nf 5 6 7 8\n"));
  EXPECT_EQ(CountOf(scene, Repair::kZeroArea), 3U);
  ASSERT_EQ(scene.polygons.size(), 2U);
  EXPECT_EQ(scene.polygons[1].file_polygon, 4U);
  EXPECT_EQ(scene.file_polygon_count, 5U);
  EXPECT_THAT(scene.repairs.entries[0].example, HasSubstr("test.obj:13"));
}

TEST_F(Import, DropsDuplicatesWhateverCornerTheyStartAt) {
  // Welding finds them where each face has vertices of its own.
  const Scene scene =
      Read(WithLamp(std::string(kFloor) + "f 5 6 7 8\nf 7 8 5 6\n" +
                    "v 1 1 0\nv 0 1 0\nv 0 0 0\nv 1 0 0\nusemtl red\nf 9 10 11 12\n"));
  EXPECT_EQ(CountOf(scene, Repair::kDuplicate), 2U);
  EXPECT_EQ(scene.polygons.size(), 2U);
  EXPECT_EQ(scene.vertices.size(), 8U);
}

TEST_F(Import, ReversedTwinsAreTheBackOfTheFirst) {
  ImportOptions front;
  front.reflect_front = true;
  const std::string text =
      WithLamp(std::string(kFloor) + "f 5 6 7 8\nf 8 7 6 5\nf 5 8 7 6\nusemtl lamp\nf 4 3 2 1\n");
  const Scene scene = Read(text, front);
  ASSERT_EQ(scene.polygons.size(), 2U);
  EXPECT_EQ(CountOf(scene, Repair::kTwin), 2U);
  EXPECT_EQ(CountOf(scene, Repair::kDuplicate), 1U);  // of the twin
  EXPECT_EQ(scene.polygons[0].sides, kFrontTakesPart | kBackTakesPart | kFrontEmits | kBackEmits);
  EXPECT_EQ(scene.polygons[1].sides, kFrontTakesPart | kBackTakesPart);
}

TEST_F(Import, TwinsOfTwoMaterialsKeepTheirFronts) {
  const Scene scene = Read(WithLamp(std::string(kFloor) + "f 5 6 7 8\nusemtl red\nf 8 7 6 5\n"));
  ASSERT_EQ(scene.polygons.size(), 3U);
  EXPECT_EQ(CountOf(scene, Repair::kTwinOtherMaterial), 1U);
  EXPECT_EQ(scene.polygons[1].sides, kFrontTakesPart | kBackCovered);
  EXPECT_EQ(scene.polygons[2].sides, kFrontTakesPart | kBackCovered);
  EXPECT_EQ(scene.materials[scene.polygons[2].material].name, "red");
}

TEST_F(Import, UnpreparedKeepsTwinsAndTheirNumbers) {
  ImportOptions as_given;
  as_given.prepare_for_transport = false;
  const Scene scene =
      Read(WithLamp(std::string(kFloor) + "f 5 6 7 8\nf 8 7 6 5\nf 5 6 7 8\n"), as_given);
  ASSERT_EQ(scene.polygons.size(), 3U);
  EXPECT_EQ(CountOf(scene, Repair::kTwin), 0U);
  EXPECT_EQ(CountOf(scene, Repair::kDuplicate), 1U);
  EXPECT_EQ(scene.polygons[1].sides, kFrontTakesPart);
  EXPECT_EQ(scene.polygons[2].sides, kFrontTakesPart);
  EXPECT_EQ(scene.polygons[2].file_polygon, scene.polygons[1].file_polygon + 1);
}

TEST_F(Import, MergesTheTrianglesOfASquare) {
  const Scene scene = Read(WithLamp(std::string(kFloor) + "f 6 7 8\nf 5 6 8\n"));
  ASSERT_EQ(scene.polygons.size(), 2U);
  EXPECT_EQ(CountOf(scene, Repair::kMerged), 1U);
  EXPECT_EQ(scene.polygons[1].vertex_count(), 4);
  EXPECT_EQ(scene.polygons[1].file_polygon, 1U);
}

TEST_F(Import, SelfCrossingFacesAreCounted) {
  const Scene scene =
      Read(WithLamp("v 0 0 0\nv 3 0 0\nv 0 2 0\nv 2 2 0\nusemtl white\nf 5 6 7 8\n"));
  EXPECT_EQ(CountOf(scene, Repair::kSelfCrossing), 1U);
}

TEST_F(Import, LowersReflectanceOfOneOrMore) {
  materials_ += "newmtl bright\nKd 5.07 0 0.999\n";
  const Scene scene = Read(WithLamp("v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl bright\nf 5 6 7\n"));
  EXPECT_EQ(scene.materials[1].reflectance, Rgb(0.98, 0, 0.999));
  EXPECT_EQ(CountOf(scene, Repair::kReflectance), 1U);
}

TEST_F(Import, MapsMultiplyTheReflectance) {
  materials_ +=
      "newmtl wood\nKd 0.5 1 1\nmap_Kd wood.png\nnewmtl wood2\nKd 1 1 1\nmap_Kd sub\\WOOD.PNG\n"
      "newmtl lost\nKd 0.4 0.4 0.4\nmap_Kd gone.png\nnewmtl bad\nKd 1 1 1\nmap_Kd test.mtl\n";
  const std::vector<uint8_t> pixels(3 * 16, 188);
  dir_.Write("sub/x", "");
  for (const char* name : {"/wood.png", "/sub/wood.png"}) {
    ASSERT_NE(stbi_write_png((dir_.path() + name).c_str(), 4, 4, 3, pixels.data(), 12), 0);
  }
  const std::string text = WithLamp(std::string(kFloor) +
                                    "usemtl wood\nf 5 6 7\nusemtl wood2\nf 5 7 8\n"
                                    "usemtl lost\nf 5 6 8\nusemtl bad\nf 6 7 8\n");
  const Scene scene = Read(text);
  const double mean = FromSrgb(188 / 255.0);
  ASSERT_EQ(scene.materials.size(), 5U);
  EXPECT_NEAR(scene.materials[1].reflectance.x, 0.5 * mean, 1e-12);
  EXPECT_NEAR(scene.materials[2].reflectance.y, mean, 1e-12);
  EXPECT_EQ(scene.materials[3].reflectance, Rgb(0.4));
  EXPECT_TRUE(scene.textures.empty());  // even images are folded in
  EXPECT_EQ(CountOf(scene, Repair::kMap), 0U);
  EXPECT_EQ(CountOf(scene, Repair::kNoMap), 2U);
}

TEST_F(Import, CountsEffectsThatAreNotSimulated) {
  materials_ +=
      "newmtl chrome\nKd 0.1 0.1 0.1\nKs 0.8 0.8 0.8\nillum 3\n"
      "newmtl glass\nKd 0.9 0.9 0.9\nd 0.9\nillum 9\nnewmtl gloss\nKd 0.3 0.3 0.3\nKs 0.1 0.1 "
      "0.1\nillum "
      "2\n"
      "newmtl lacks_ks\nKd 0.3 0.3 0.3\nillum 3\nnewmtl unused\nillum 3\n";
  const Scene scene =
      Read(WithLamp(std::string(kFloor) + "usemtl chrome\nf 5 6 7\nusemtl glass\nf 5 7 8\n"
                                          "usemtl gloss\nf 5 6 8\nusemtl lacks_ks\nf 6 7 8\n"));
  EXPECT_EQ(CountOf(scene, Repair::kMirror), 1U);
  EXPECT_EQ(CountOf(scene, Repair::kGlass), 1U);
  EXPECT_EQ(CountOf(scene, Repair::kGlossy), 1U);
  EXPECT_EQ(scene.materials[1].reflectance, Rgb(0.1));
  EXPECT_EQ(scene.materials[1].specular, 0.8);
  EXPECT_EQ(scene.materials[3].specular, 0);
  EXPECT_EQ(scene.materials[3].gloss, (Gloss{Rgb(0.1), false}));
  EXPECT_FALSE(scene.materials[1].gloss.exists());
}

// Ks is no albedo: it is not added to Kd, and counts for what Kd leaves at most.
TEST_F(Import, LobesReflectNoMoreThanIsLeft) {
  materials_ += "newmtl varnish\nKd 0.3 0.6 1\nKs 1 0.2 0.5\nillum 2\n";
  const Scene scene = Read(WithLamp(std::string(kFloor) + "usemtl varnish\nf 5 6 7\n"));
  EXPECT_EQ(scene.materials[1].reflectance, Rgb(0.3, 0.6, 0.98));
  EXPECT_NEAR(glm::length(scene.materials[1].gloss.share - Rgb(0.68, 0.2, 0)), 0, 1e-12);
  EXPECT_TRUE(Validate(scene).ok());
}

TEST_F(Import, MirrorsReflectNoMoreThanArrives) {
  materials_ +=
      "newmtl perfect\nKs 1 1 1\nillum 3\nnewmtl bright\nKd 0.8 0.4 0.4\nKs 1.2 1.2 1.2\nillum 5\n"
      "newmtl gold\nKs 0.9 0.6 0.3\nillum 3\n";
  const std::string text = WithLamp(std::string(kFloor) +
                                    "usemtl perfect\nf 5 6 7\nusemtl bright\n"
                                    "f 5 7 8\nusemtl gold\nf 5 6 8\n");
  const Scene scene = Read(text);
  EXPECT_EQ(scene.materials[1].specular, 1);
  EXPECT_NEAR(scene.materials[2].specular, 0.98 * 0.6, 1e-12);
  EXPECT_NEAR(scene.materials[2].reflectance.x, 0.98 * 0.4, 1e-12);
  EXPECT_NEAR(scene.materials[2].reflectance.y, 0.98 * 0.2, 1e-12);
  EXPECT_NEAR(scene.materials[3].specular, 0.6, 1e-12);
  EXPECT_EQ(CountOf(scene, Repair::kMirrorShare), 1U);
  EXPECT_EQ(CountOf(scene, Repair::kMirrorColour), 1U);
  EXPECT_EQ(CountOf(scene, Repair::kMirror), 0U);
  EXPECT_EQ(Encode(Decode(Encode(scene)).value()), Encode(scene));
  ImportOptions strict;
  strict.strict = true;
  EXPECT_THAT(ErrorOf(text, strict), HasSubstr("mirrors that reflect more than arrives"));
}

TEST_F(Import, SheetsPassOnNoMoreThanIsLeft) {
  materials_ +=
      "newmtl paper\nKd 0.5 0.5 0.5\nTd 0.4 0.3 0.2\nnewmtl board\nKd 0.5 0.5 0.5\nTd 0\n"
      "newmtl film\nKd 0.6 0.6 0\nTd 1.4 0.2 0.2\n";
  const std::string text = WithLamp(
      std::string(kFloor) + "usemtl paper\nf 5 6 7\nusemtl board\nf 5 7 8\nusemtl film\nf 5 6 1\n");
  ImportOptions fronts;
  fronts.reflect_front = true;
  const Scene scene = Read(text, fronts);
  EXPECT_EQ(scene.materials[1].reflectance, Rgb(0.5));
  EXPECT_EQ(scene.materials[1].transmittance, Rgb(0.4, 0.3, 0.2));
  EXPECT_EQ(scene.materials[2].transmittance, Rgb(0.0));
  EXPECT_NEAR(scene.materials[3].transmittance.x, 0.98 * 0.7, 1e-12);
  EXPECT_NEAR(scene.materials[3].reflectance.x, 0.98 * 0.3, 1e-12);
  EXPECT_EQ(scene.materials[3].transmittance.y, 0.2);
  EXPECT_EQ(CountOf(scene, Repair::kSheetShare), 1U);
  // Both of their sides take part, whatever the rest does.
  for (const Polygon& polygon : scene.polygons) {
    const bool sheet = scene.materials[polygon.material].transmittance != Rgb(0.0);
    EXPECT_EQ((polygon.sides & kBackTakesPart) != 0, sheet) << polygon.file_polygon;
  }
  EXPECT_EQ(Encode(Decode(Encode(scene)).value()), Encode(scene));
  ImportOptions strict;
  strict.strict = true;
  EXPECT_THAT(ErrorOf(text, strict), HasSubstr("sheets that pass on more than is left"));
  materials_ += "newmtl torn\nTd -1\n";
  EXPECT_THAT(ErrorOf(text), HasSubstr("Td '-1' is not a number of 0 or more"));
  materials_ = "Td 0.5\n";
  EXPECT_THAT(ErrorOf(text), HasSubstr("Td before the first newmtl"));
}

TEST_F(Import, FluorescenceGivesOutNoMoreThanArrives) {
  materials_ += "newmtl dye\nKd 0.2 0.3 0.1\nTd 0.1\nFl 0.5 0.2 0.4\n";
  const std::string text = WithLamp(std::string(kFloor) + "usemtl dye\nf 5 6 7\n");
  const Scene scene = Read(text);
  EXPECT_EQ(scene.materials[1].reradiation, (Reradiation{0.5, 0.2, 0.4}));
  EXPECT_EQ(scene.materials[1].reflectance, Rgb(0.2, 0.3, 0.1));
  EXPECT_EQ(scene.materials[1].transmittance, Rgb(0.1));
  EXPECT_EQ(Encode(Decode(Encode(scene)).value()), Encode(scene));
  const std::string good = materials_;
  materials_ = good + "Kd 0.2 0.6 0.1\n";
  EXPECT_THAT(ErrorOf(text),
              HasSubstr("'dye' gives out 1.1 of what arrives of green by Kd, Td and"));
  materials_ = good + "Fl 0.3\n";
  EXPECT_THAT(ErrorOf(text), HasSubstr("Fl needs three numbers"));
  materials_ = good + "Fl 0.3 -1 0\n";
  EXPECT_THAT(ErrorOf(text), HasSubstr("Fl '-1' is not a number of 0 or more"));
}

TEST_F(Import, FacesWithoutAMaterialAreGrey) {
  const Scene scene = Read(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nmtllib test.mtl\n"
      "v 0 0 2\nv 0 1 2\nv 1 1 2\nusemtl lamp\nf 4 5 6\n");
  EXPECT_EQ(CountOf(scene, Repair::kMaterialless), 1U);
  EXPECT_EQ(scene.materials[scene.polygons[0].material].reflectance, Rgb(0.5));
}

TEST_F(Import, RefusesDarknessWithTheReason) {
  const std::string dark = std::string("mtllib test.mtl\n") + kFloor + "f 1 2 3 4\n";
  EXPECT_THAT(ErrorOf(dark), HasSubstr("nothing emits light"));
  EXPECT_THAT(ErrorOf(dark), HasSubstr("Ke"));
  ImportOptions options;
  options.require_emission = false;
  EXPECT_TRUE(TryRead(dark, options).has_value());
}

TEST_F(Import, StrictRefusesWhatWouldBeMended) {
  ImportOptions strict;
  strict.strict = true;
  EXPECT_TRUE(TryRead(kLamp, strict).has_value());
  EXPECT_TRUE(TryRead(WithLamp(std::string(kFloor) + "f 6 7 8\nf 5 6 8\n"), strict).has_value());
  EXPECT_THAT(ErrorOf(WithLamp(std::string(kFloor) + "f 5 6 6\n"), strict),
              HasSubstr("test.obj:13: zero-area faces dropped (1 in all)"));
  EXPECT_THAT(ErrorOf(WithLamp("f 2 3 4 1\n"), strict), HasSubstr("duplicate"));
  materials_ += "newmtl bright\nKd 1 1 1\n";
  EXPECT_THAT(ErrorOf(WithLamp("v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl bright\nf 5 6 7\n"), strict),
              HasSubstr("test.mtl:8: reflectances of 1 or more"));
}

TEST_F(Import, KnowsTheFormatByTheExtension) {
  dir_.Write("test.mtl", materials_);
  EXPECT_TRUE(ImportScene(dir_.Write("UPPER.OBJ", kLamp), {}).has_value());
  EXPECT_THAT(ImportScene(dir_.Write("scene.fbx", kLamp), {}).error().message(),
              HasSubstr("'.fbx' is not a scene format"));
  EXPECT_THAT(ImportScene(dir_.path() + "/gone.obj", {}).error().message(),
              HasSubstr("No such file"));
}

TEST_F(Import, AllFacesDegenerateIsAnError) {
  EXPECT_THAT(ErrorOf("mtllib test.mtl\nv 0 0 0\nv 1 0 0\nv 2 0 0\nusemtl lamp\nf 1 2 3\n"),
              HasSubstr("no face has any area"));
  EXPECT_THAT(ErrorOf("mtllib test.mtl\nv 0 0 0\nv 1e200 0 0\nv 0 1e200 0\nusemtl lamp\nf 1 2 3\n"),
              HasSubstr("test.obj"));
}

TEST_F(Import, IsTheSameEveryTime) {
  const std::string text =
      WithLamp(std::string(kFloor) + "f 6 7 8\nf 5 6 8\nusemtl red\nf 8 7 6\n");
  EXPECT_EQ(Encode(Read(text)), Encode(Read(text)));
}

// Random damage to both files: a scene that the solver takes, or an error that says something.
TEST_F(Import, DamagedFilesGiveAnErrorOrAScene) {
  const std::string obj = WithLamp(
      std::string(kFloor) +
      "f 5 6 7 8 # floor\no other\ng a b\nv 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nvn 0 0 1\nvt 0 0\n"
      "f 9/1/1 10/1/1 11/1/1 12/1/1\nusemtl red\nf -1 -2 -3\nf 8 7 6 5\nf 1 2 \\\n 3 9 10\n");
  const std::string mtl = materials_ + "newmtl wood\nKd 1 1 1\nmap_Kd -s 1 1 1 wood.png\nd 0.5\n";
  const char interesting[] = "0123456789-+.e/ \n\r\t#\\vfnamtlKd\0\xff";
  int scenes = 0;
  for (uint64_t seed = 1; seed <= 3000; ++seed) {
    Random random(Mix(seed));
    std::string damaged[] = {obj, mtl};
    for (int i = 1 + static_cast<int>(random.Bits() % 6); i > 0; --i) {
      std::string& text = damaged[random.Bits() % 3 == 0 ? 1 : 0];
      if (text.empty()) continue;
      const size_t at = random.Bits() % text.size();
      switch (random.Bits() % 5) {
        case 0:
          text.resize(at);
          break;
        case 1:
          text.erase(at, 1 + random.Bits() % 8);
          break;
        case 2:
          text.insert(at, text.substr(random.Bits() % text.size(), random.Bits() % 40));
          break;
        default:
          text[at] = interesting[random.Bits() % (sizeof interesting - 1)];
      }
    }
    dir_.Write("test.mtl", damaged[1]);
    const Result<Scene> scene = ImportScene(dir_.Write("test.obj", damaged[0]), {});
    if (!scene.has_value()) {
      EXPECT_THAT(scene.error().message(), HasSubstr("test.")) << "seed " << seed;
      continue;
    }
    ++scenes;
    const Status status = Validate(*scene);
    EXPECT_TRUE(status.ok()) << "seed " << seed << ": " << status.message();
  }
  EXPECT_GT(scenes, 100);
  EXPECT_LT(scenes, 2900);
}

}  // namespace
}  // namespace isolux
