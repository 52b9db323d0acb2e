// The project's own scenes, and larger ones from elsewhere where a collection of them is at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <utility>

#include "client/import/import.h"
#include "tests/support/shared_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

// Of the collection; empty where there is none.
std::string SharedScenes() {
  const fs::path folder = fs::path(testing::SharedFolder()) / "scenes";
  return fs::is_directory(folder) ? folder.string() : std::string();
}

Scene ImportOwn(const std::string& name, const std::string& unit) {
  ImportOptions options;
  options.unit = unit;
  options.strict = true;
  const Result<Scene> scene =
      ImportScene(std::string(ISOLUX_SOURCE_DIR) + "/scenes/" + name, options);
  EXPECT_TRUE(scene.has_value()) << scene.error().message();
  return scene.has_value() ? *scene : Scene();
}

TEST(OwnScenes, CornellBox) {
  const Scene scene = ImportOwn("cornell_box/cornell_box.obj", "mm");
  EXPECT_EQ(scene.file_polygon_count, 24U);
  EXPECT_EQ(scene.polygons.size(), 28U);  // the floor is cut along the outlines of the blocks
  EXPECT_EQ(scene.materials.size(), 4U);
  EXPECT_NEAR(scene.origin_m.x, 0.278, 1e-12);
}

TEST(OwnScenes, FurnaceCubeLooksInwards) {
  const Scene scene = ImportOwn("furnace_cube.obj", "m");
  ASSERT_EQ(scene.polygons.size(), 6U);
  for (uint32_t p = 0; p < 6; ++p) {
    const ConvexPolygon face = SideGeometry(scene, p, Side::kFront);
    EXPECT_LT(glm::dot(face.Normal(), face.Centroid()), 0);
  }
}

TEST(OwnScenes, RoomLooksInwards) {
  const Scene scene = ImportOwn("room.obj", "m");
  EXPECT_GT(scene.polygons.size(), 200U);
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    if (scene.polygons[p].file_polygon >= 6) continue;
    const ConvexPolygon wall = SideGeometry(scene, p, Side::kFront);
    EXPECT_LT(glm::dot(wall.Normal(), wall.v[0]), -1);
  }
  uint32_t lamp = 0;
  while (scene.polygons[lamp].file_polygon != 6) ++lamp;
  EXPECT_EQ(SideGeometry(scene, lamp, Side::kFront).Normal(), Vec3(0, 0, -1));
  EXPECT_EQ(scene.polygons[lamp].sides & kFrontEmits, kFrontEmits);
}

TEST(OwnScenes, TextureHasMapsOfBothKinds) {
  const Scene scene = ImportOwn("effects/texture/texture.obj", "m");
  EXPECT_EQ(scene.file_polygon_count, 12U);
  ASSERT_EQ(scene.textures.size(), 2U);
  for (const Polygon& polygon : scene.polygons) {
    const std::string& name = scene.materials[polygon.material].name;
    EXPECT_EQ(polygon.coordinates != kNoCoordinates, name == "tiles" || name == "panel") << name;
  }
}

TEST(OwnScenes, LightsStandBeside) {
  const Scene scene = ImportOwn("effects/lights/lights.obj", "m");
  ASSERT_EQ(scene.lights.size(), 4U);
  EXPECT_EQ(scene.lights[1].kind, LightKind::kSpot);
  EXPECT_EQ(scene.lights[3].kind, LightKind::kDirectional);
  Bounds3 bounds;
  for (const Vec3& v : scene.vertices) bounds.Add(v);
  for (int i = 0; i < 3; ++i) {
    const Vec3& at = scene.lights[i].position_m;
    EXPECT_EQ(glm::clamp(at, bounds.low, bounds.high), at);
  }
}

TEST(OwnScenes, DaylightHasSunAndSky) {
  const Scene scene = ImportOwn("effects/daylight/daylight.obj", "m");
  ASSERT_EQ(scene.lights.size(), 1U);
  EXPECT_TRUE(scene.lights[0].is_sun());
  EXPECT_EQ(scene.sky.name, "cie_clear");
  EXPECT_EQ(scene.sky.up, Vec3(0, 0, 1));
  // The sky is brightest where the sun stands.
  const Rgb about_the_sun = scene.sky.RadianceFrom(-scene.lights[0].direction);
  EXPECT_GT(about_the_sun.x, scene.sky.RadianceFrom({0, 0, 1}).x);
}

TEST(OwnScenes, DownlightsShareTheirTable) {
  const Scene scene = ImportOwn("effects/ies/ies.obj", "m");
  ASSERT_EQ(scene.lights.size(), 3U);
  ASSERT_EQ(scene.photometries.size(), 1U);
  EXPECT_EQ(scene.lights[2].kind, LightKind::kPhotometric);
  // A beam and a ring.
  const Photometry& table = scene.photometries[0];
  EXPECT_GT(table.intensity[0], 2 * table.intensity[4]);
  EXPECT_GT(table.intensity[7], 1.5 * table.intensity[4]);
}

TEST(OwnScenes, WindowsAreOfGlass) {
  const Scene scene = ImportOwn("effects/glass/glass.obj", "m");
  ASSERT_EQ(scene.glazing.panes.size(), 5U);
  EXPECT_EQ(scene.glazing.glasses.size(), 5U);
  EXPECT_FALSE(scene.glazing.is_grey());
  EXPECT_TRUE(scene.lights[0].is_sun());
}

TEST(OwnScenes, CardsDifferInBandsAlone) {
  const Scene scene = ImportOwn("effects/bands/bands.obj", "m");
  ASSERT_EQ(scene.bands.size(), 9U);
  const auto material = [&](const char* name) {
    return *std::ranges::find(scene.materials, name, &Material::name);
  };
  for (const auto& [flat, steep] : {std::pair("flat1", "steep1"), std::pair("flat2", "steep2")}) {
    const Rgb off = material(flat).reflectance - material(steep).reflectance;
    EXPECT_LT(glm::length(off), 1e-9) << flat;
    EXPECT_FALSE(material(flat).spectrum.exists());
    EXPECT_EQ(material(steep).spectrum.reflectance.size(), 9U);
  }
  const Rgb off = material("even").exitance - material("lines").exitance;
  EXPECT_LT(glm::length(off), 1e-9);
}

TEST(OwnScenes, CardsShineInLongerBandsThanTheLamp) {
  const Scene scene = ImportOwn("effects/phosphor/phosphor.obj", "m");
  ASSERT_EQ(scene.bands.size(), 6U);
  const auto glows = [](const Material& m) { return m.spectrum.reradiation.exists(); };
  EXPECT_EQ(std::ranges::count_if(scene.materials, glows), 4);
  const Material red = *std::ranges::find(scene.materials, "red", &Material::name);
  EXPECT_NEAR(red.spectrum.reradiation.Taken(0), 0.75, 1e-12);
  EXPECT_GT(red.reradiation.blue_to_red, 0.7);
}

struct Expected {
  const char* name;
  uint32_t file_polygons;
};

class SharedScene : public ::testing::TestWithParam<Expected> {};

TEST_P(SharedScene, Imports) {
  const std::string folder = SharedScenes();
  if (folder.empty()) GTEST_SKIP() << "no collection of scenes; name its folder in ISOLUX_SHARED";
  const std::string name = GetParam().name;
  const auto start = std::chrono::steady_clock::now();
  const Result<Scene> scene = ImportScene(folder + "/" + name + "/" + name + ".obj", {});
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  EXPECT_EQ(scene->file_polygon_count, GetParam().file_polygons);
  EXPECT_TRUE(Validate(*scene).ok()) << Validate(*scene).message();
  uint32_t last = 0;
  double area = 0;
  for (uint32_t p = 0; p < scene->polygons.size(); ++p) {
    EXPECT_LT(scene->polygons[p].file_polygon, scene->file_polygon_count);
    last = std::max(last, scene->polygons[p].file_polygon);
    area += SideGeometry(*scene, p, Side::kFront).Area();
  }
  std::printf("%s: %u polygons in the file, %zu in the scene, %zu vertices, %.6g m2, %.2f s\n",
              name.c_str(), scene->file_polygon_count, scene->polygons.size(),
              scene->vertices.size(), area, took.count());
  for (const auto& entry : scene->repairs.entries) {
    std::printf("  %s: %llu, for instance %s\n", entry.kind.c_str(),
                static_cast<unsigned long long>(entry.count),
                fs::path(entry.example).filename().c_str());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Collection, SharedScene,
    ::testing::Values(Expected{"cornell_box", 24}, Expected{"hospital", 11'215},
                      Expected{"modern_hall", 30'924}, Expected{"rp_corridor", 355},
                      Expected{"rp_cube", 66}, Expected{"simple_office", 422},
                      Expected{"sponza_dabrovic", 66'957}, Expected{"veach_lamp", 3'392},
                      Expected{"ward_office", 12'298}, Expected{"wooden_staircase", 262'662}),
    [](const auto& scene) { return std::string(scene.param.name); });

struct MaterialSums {
  double area_m2 = 0;      // of one side
  Rgb power_w{0.0};        // emitted
  Rgb reflecting_m2{0.0};  // reflectance times area
};

std::map<std::string, MaterialSums> SumsOf(const Scene& scene) {
  std::map<std::string, MaterialSums> sums;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    const Material& material = scene.materials[polygon.material];
    const double area = SideGeometry(scene, p, Side::kFront).Area();
    MaterialSums& sum = sums[material.name];
    sum.area_m2 += area;
    sum.reflecting_m2 += area * material.reflectance;
    for (const SideFlags side : {kFrontEmits, kBackEmits}) {
      if ((polygon.sides & side) != 0) sum.power_w += area * material.exitance;
    }
  }
  return sums;
}

// The hall as OBJ, and as binary glTF that another program made from it, with points and colours in
// single precision.
TEST(SharedScenes, HallIsTheSameFromObjAndGltf) {
  const std::string folder = SharedScenes();
  if (folder.empty()) GTEST_SKIP() << "no collection of scenes; name its folder in ISOLUX_SHARED";
  const Result<Scene> obj = ImportScene(folder + "/modern_hall/modern_hall.obj", {});
  const Result<Scene> gltf = ImportScene(folder + "/modern_hall/modern_hall.glb", {});
  ASSERT_TRUE(obj.has_value()) << obj.error().message();
  ASSERT_TRUE(gltf.has_value()) << gltf.error().message();
  EXPECT_LT(glm::length(obj->origin_m - gltf->origin_m), 1e-5);
  const auto obj_sums = SumsOf(*obj);
  const auto gltf_sums = SumsOf(*gltf);
  ASSERT_EQ(obj_sums.size(), gltf_sums.size());
  for (const auto& [name, want] : obj_sums) {
    SCOPED_TRACE(name);
    ASSERT_EQ(gltf_sums.count(name), 1U);
    const MaterialSums& have = gltf_sums.at(name);
    EXPECT_NEAR(have.area_m2, want.area_m2, 1e-5 * want.area_m2);
    EXPECT_LT(glm::length(have.power_w - want.power_w), 1e-5 * glm::length(want.power_w) + 1e-12);
    EXPECT_LT(glm::length(have.reflecting_m2 - want.reflecting_m2), 1e-5 * want.area_m2);
  }
}

TEST(SharedScenes, RoomWithoutLampsIsRefused) {
  const std::string folder = SharedScenes();
  if (folder.empty()) GTEST_SKIP() << "no collection of scenes; name its folder in ISOLUX_SHARED";
  const Result<Scene> scene = ImportScene(folder + "/grey_white_room/grey_white_room.obj", {});
  ASSERT_FALSE(scene.has_value());
  EXPECT_NE(scene.error().message().find("nothing emits light"), std::string::npos)
      << scene.error().message();
}

}  // namespace
}  // namespace isolux
