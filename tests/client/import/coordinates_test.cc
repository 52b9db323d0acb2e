// Maps from scene files to scenes: where each texel comes to lie, and what is merged under it.
#include "client/import/coordinates.h"

#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include "client/import/import.h"
#include "client/import/repair.h"
#include "client/import/texture_image.h"
#include "common/scene/surface_maps.h"
#include "common/util/random.h"
#include "tests/support/gltf_file.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using testing::GltfFile;
using testing::TempDir;
using Json = GltfFile::Json;

// Codes of the upper left, upper right, lower left and lower right texel.
constexpr uint8_t kCodes[] = {60, 120, 180, 240};

double Light(int texel) { return FromSrgb(kCodes[texel] / 255.0); }

class Coordinates : public ::testing::Test {
 protected:
  Coordinates() {
    std::vector<uint8_t> pixels;
    for (const uint8_t code : kCodes) pixels.insert(pixels.end(), 3, code);
    EXPECT_NE(stbi_write_png((dir_.path() + "/four.png").c_str(), 2, 2, 3, pixels.data(), 6), 0);
  }

  // A floor of corners (0,0), (1,0), (1,1), (0,1) at z = 0 with the image, and a lamp.
  Scene Obj(const std::string& floor, const std::string& options = "") {
    dir_.Write("a.mtl", "newmtl lamp\nKe 1 1 1\nnewmtl floor\nmap_Kd " + options + "four.png\n");
    return Read(dir_.Write("a.obj",
                           "mtllib a.mtl\nv 0 0 2\nv 0 1 2\nv 1 1 2\nusemtl lamp\nf 1 2 3\n"
                           "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl floor\n" +
                               floor));
  }
  Scene Gltf(const Json& info, const std::vector<float>& uv, const Json& sampler) {
    GltfFile file;
    const int lamp = file.Material({{"emissiveFactor", {1, 1, 1}}});
    const int floor = file.Material(
        {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"baseColorTexture", info}}}});
    file.json["images"] = Json::array({{{"uri", "four.png"}}});
    file.json["samplers"] = Json::array({sampler});
    file.json["textures"] = Json::array({{{"source", 0}, {"sampler", 0}}});
    file.Node({{"mesh", file.Square(lamp, 5)}});
    const int points = file.Points({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
    const int mesh =
        file.Mesh(points, file.Accessor(std::vector<uint8_t>{0, 1, 2, 0, 2, 3}, 1), floor);
    const int coordinates = file.Accessor(uv, 2);
    file.json["meshes"][mesh]["primitives"][0]["attributes"]["TEXCOORD_1"] = coordinates;
    file.Node({{"mesh", mesh}});
    return Read(dir_.Write("a.gltf", file.Text()));
  }
  static Scene Read(const std::string& path) {
    Result<Scene> scene = ImportScene(path, {});
    EXPECT_TRUE(scene.has_value()) << scene.error().message();
    return scene.has_value() ? *std::move(scene) : Scene();
  }
  // Mean reflectance of the floor about a place of it.
  static double At(const Scene& scene, double x, double y) {
    const SurfaceMaps maps(scene);
    for (const Surface& surface : MakeSurfaces(scene)) {
      const ConvexPolygon whole = SideGeometry(scene, surface.polygon, Side::kFront);
      if (surface.side != Side::kFront || Sum(surface.exitance) > 0) continue;
      const Vec3 at = Vec3(x, y, 0) - scene.origin_m;
      bool inside = true;
      for (int i = 0; i < whole.count; ++i) {
        const Vec3 side = whole.v[(i + 1) % whole.count] - whole.v[i];
        inside = inside && glm::cross(side, at - whole.v[i]).z >= 0;
      }
      if (!inside) continue;
      const double d = 1e-3;
      const ConvexPolygon spot{
          4, {at + Vec3(-d, -d, 0), at + Vec3(d, -d, 0), at + Vec3(d, d, 0), at + Vec3(-d, d, 0)}};
      return maps.Over(surface, spot).reflectance.y;
    }
    ADD_FAILURE() << "no floor at " << x << " " << y;
    return 0;
  }
  static uint64_t CountOf(const Scene& scene, Repair kind) {
    for (const auto& entry : scene.repairs.entries) {
      if (entry.kind == ToText(kind)) return entry.count;
    }
    return 0;
  }
  // Of the four quarters of the floor: lower left, lower right, upper left, upper right.
  static void ExpectQuarters(const Scene& scene, const std::array<int, 4>& texels) {
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(At(scene, i % 2 == 0 ? 0.3 : 0.8, i < 2 ? 0.3 : 0.8), Light(texels[i]), 1e-6)
          << i;
    }
  }

  TempDir dir_;
};

constexpr char kCorners[] = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

TEST_F(Coordinates, OfObjGoUpwards) {
  const Scene scene = Obj(std::string(kCorners) + "f 4/1 5/2 6/3 7/4\n");
  ASSERT_EQ(scene.textures.size(), 1U);
  ExpectQuarters(scene, {2, 3, 0, 1});
  const double mean = (Light(0) + Light(1) + Light(2) + Light(3)) / 4;
  EXPECT_NEAR(scene.materials[scene.polygons[1].material].reflectance.x, mean, 1e-12);
  EXPECT_EQ(CountOf(scene, Repair::kMap), 0U);
}

TEST_F(Coordinates, OfGltfGoDownwards) {
  const std::vector<float> uv{0, 0, 1, 0, 1, 1, 0, 1};
  const Json info{{"index", 0}, {"texCoord", 1}};
  ExpectQuarters(Gltf(info, uv, Json::object()), {0, 1, 2, 3});
  // Another set has no coordinates: the mean counts.
  const Scene none = Gltf({{"index", 0}}, uv, Json::object());
  EXPECT_TRUE(none.textures.empty());
  EXPECT_GE(CountOf(none, Repair::kMap) + CountOf(none, Repair::kCoordinates), 1U);
}

TEST_F(Coordinates, AreScaledTurnedAndMoved) {
  const std::vector<float> uv{0, 0, 1, 0, 1, 1, 0, 1};
  const auto with = [&](const Json& transform) {
    return Json{
        {"index", 0}, {"texCoord", 7}, {"extensions", {{"KHR_texture_transform", transform}}}};
  };
  // By a half to the right, in the set that the extension names.
  ExpectQuarters(Gltf(with({{"offset", {0.5, 0}}, {"texCoord", 1}}), uv, Json::object()),
                 {1, 0, 3, 2});
  // A quarter turn takes (u, v) to (v, −u).
  ExpectQuarters(Gltf(with({{"rotation", M_PI / 2}, {"texCoord", 1}}), uv, Json::object()),
                 {2, 0, 3, 1});
  ExpectQuarters(Gltf(with({{"scale", {0.5, 0.5}}, {"texCoord", 1}}), uv, Json::object()),
                 {0, 0, 0, 0});
  // -o moves, -s scales; both upwards.
  ExpectQuarters(Obj(std::string(kCorners) + "f 4/1 5/2 6/3 7/4\n", "-o 0 0.5 0 "), {0, 1, 2, 3});
  ExpectQuarters(Obj(std::string(kCorners) + "f 4/1 5/2 6/3 7/4\n", "-s 0.5 0.5 1 "), {2, 2, 2, 2});
}

TEST_F(Coordinates, WrapAsTheSamplerSays) {
  const std::vector<float> uv{1, 0, 2, 0, 2, 1, 1, 1};  // one image to the right
  const Json info{{"index", 0}, {"texCoord", 1}};
  ExpectQuarters(Gltf(info, uv, {{"wrapS", 10497}}), {0, 1, 2, 3});
  ExpectQuarters(Gltf(info, uv, {{"wrapS", 33071}}), {1, 1, 3, 3});
  ExpectQuarters(Gltf(info, uv, {{"wrapS", 33648}}), {1, 0, 3, 2});
}

TEST_F(Coordinates, TrianglesMergeUnderOneMapAlone) {
  const Scene one = Obj(std::string(kCorners) + "f 4/1 5/2 6/3\nf 6/3 7/4 4/1\n");
  EXPECT_EQ(one.polygons.size(), 2U);
  EXPECT_EQ(one.coordinates.size(), 1U);
  ExpectQuarters(one, {2, 3, 0, 1});
  // The same corners, but the second triangle shows another part of the image.
  const Scene two = Obj(std::string(kCorners) + "vt 0.5 0.5\nf 4/1 5/2 6/3\nf 6/5 7/4 4/1\n");
  EXPECT_EQ(two.polygons.size(), 3U);
  EXPECT_EQ(two.coordinates.size(), 2U);
}

TEST_F(Coordinates, QuadsThatBendAreDivided) {
  const Scene scene = Obj("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.5\nf 4/1 5/2 6/3 7/4\n");
  EXPECT_EQ(scene.polygons.size(), 3U);
  EXPECT_EQ(scene.textures.size(), 1U);
  EXPECT_NEAR(At(scene, 0.3, 0.1), Light(2), 1e-6);
  EXPECT_NEAR(At(scene, 0.02, 0.9), Light(2), 1e-6);  // v is 0.45 there, and was 0.9
}

TEST_F(Coordinates, FacesWithoutTakeTheMean) {
  const Scene scene = Obj(std::string(kCorners) + "f 4/1 5/2 6/3\nf 6 7 4\n");
  EXPECT_EQ(CountOf(scene, Repair::kCoordinates), 1U);
  EXPECT_NEAR(At(scene, 0.1, 0.8), (Light(0) + Light(1) + Light(2) + Light(3)) / 4, 1e-9);
  const Scene often = Obj("vt 0 0\nvt 1000 0\nvt 1000 1\nf 4/1 5/2 6/3\n");
  EXPECT_EQ(CountOf(often, Repair::kCoordinates), 1U);
  EXPECT_TRUE(often.textures.empty());
  EXPECT_TRUE(Obj("f 4 5 6 7\n").textures.empty());
}

TEST(FitCoordinates, TakesCornersWhereTheyBelong) {
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(Mix(seed));
    ConvexPolygon shape{3, {}};
    std::vector<glm::dvec2> corners;
    for (int i = 0; i < 3; ++i) {
      shape.v[i] = {random.Unit(), random.Unit(), random.Unit()};
      // Some maps leave out a direction, or both.
      const double v = seed % 3 == 0 ? 0.5 : random.Unit();
      corners.emplace_back(seed % 6 == 0 ? 0.25 : 3 * random.Unit(), v);
    }
    if (shape.Area() < 0.01) continue;
    const auto fit = FitCoordinates(shape, corners);
    ASSERT_TRUE(fit.has_value());
    for (int i = 0; i < 3; ++i) {
      const auto at = [&](const std::array<double, 4>& row) {
        return row[0] * shape.v[i].x + row[1] * shape.v[i].y + row[2] * shape.v[i].z + row[3];
      };
      EXPECT_NEAR(at(fit->u), corners[i].x, 1e-4) << seed;
      EXPECT_NEAR(at(fit->v), corners[i].y, 1e-4) << seed;
    }
  }
}

}  // namespace
}  // namespace isolux
