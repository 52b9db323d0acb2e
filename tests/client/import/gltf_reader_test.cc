#include "client/import/gltf_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "common/util/random.h"
#include "tests/support/gltf_file.h"

namespace isolux {
namespace {

using ::testing::ElementsAre;
using testing::GltfFile;
using ::testing::HasSubstr;
using Json = GltfFile::Json;

SceneFile Read(const GltfFile& file) {
  const Result<SceneFile> scene = ParseGltf(file.Text(), "test.gltf");
  EXPECT_TRUE(scene.has_value()) << scene.error().message();
  return scene.has_value() ? *scene : SceneFile();
}

std::string ErrorOf(const GltfFile& file, const SceneLimits& limits = {}) {
  const Result<SceneFile> scene = ParseGltf(file.Text(), "test.gltf", limits);
  EXPECT_FALSE(scene.has_value());
  if (scene.has_value()) return "";
  EXPECT_THAT(scene.error().message(), HasSubstr("test.gltf: "));
  return scene.error().message();
}

// The points of a face in turn.
std::vector<Vec3> CornersOf(const SceneFile& scene, size_t face) {
  std::vector<Vec3> corners;
  for (uint32_t i = 0; i < scene.faces[face].count; ++i) {
    corners.push_back(scene.points[scene.corners[scene.faces[face].first + i]]);
  }
  return corners;
}

Vec3 AreaOf(const std::vector<Vec3>& t) { return 0.5 * glm::cross(t[1] - t[0], t[2] - t[0]); }

GltfFile Square() {
  GltfFile file;
  file.Node({{"mesh", file.Square(-1)}, {"name", "floor"}});
  return file;
}

TEST(GltfReader, ReadsTextAndBinaryAlike) {
  const GltfFile file = Square();
  const Result<SceneFile> binary = ParseGltf(file.Binary(), "test.glb");
  ASSERT_TRUE(binary.has_value()) << binary.error().message();
  for (const SceneFile& scene : {Read(file), *binary}) {
    EXPECT_EQ(scene.points.size(), 4U);
    ASSERT_EQ(scene.faces.size(), 2U);
    EXPECT_THAT(scene.corners, ElementsAre(0, 1, 2, 0, 2, 3));
    EXPECT_EQ(scene.points[2], Vec3(1, 1, 0));
    EXPECT_EQ(scene.faces[1].material, kNoMaterial);
    EXPECT_THAT(scene.Where(scene.faces[1]),
                HasSubstr(": nodes[0] 'floor', meshes[0].primitives[0]"));
  }
}

TEST(GltfReader, ReadsListsStripsAndFansWithAndWithoutIndices) {
  const std::vector<Vec3> fan{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  const std::vector<Vec3> strip{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}, {1, 2, 0}};
  for (const bool indexed : {false, true}) {
    GltfFile file;
    const auto mesh = [&](const std::vector<Vec3>& points, int mode) {
      std::vector<uint32_t> order(points.size());
      for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
      const int positions = file.Points(points);
      file.Node({{"mesh", file.Mesh(positions, indexed ? file.Accessor(order, 1) : -1, -1, mode)}});
    };
    mesh(fan, 6);
    mesh(strip, 5);
    mesh({fan[0], fan[1], fan[2], fan[0], fan[2], fan[3]}, 4);
    const SceneFile scene = Read(file);
    ASSERT_EQ(scene.faces.size(), 3U + 4U + 2U);
    double area = 0;
    for (size_t f = 0; f < scene.faces.size(); ++f) {
      const Vec3 vector = AreaOf(CornersOf(scene, f));
      EXPECT_GT(vector.z, 0) << f;
      area += vector.z;
    }
    EXPECT_NEAR(area, 3.5 + 2.0 + 2.5, 1e-15);
  }
}

TEST(GltfReader, LeavesOutWhereStripsJump) {
  GltfFile file;
  const int points =
      file.Points({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  const std::vector<uint8_t> order{0, 1, 2, 2, 2, 3, 3, 4, 5};
  file.Node({{"mesh", file.Mesh(points, file.Accessor(order, 1), -1, 5)}});
  const SceneFile scene = Read(file);
  ASSERT_EQ(scene.faces.size(), 2U);
  EXPECT_GT(AreaOf(CornersOf(scene, 0)).z, 0);
  EXPECT_GT(AreaOf(CornersOf(scene, 1)).z, 0);
}

TEST(GltfReader, ReadsQuantisedPoints) {
  GltfFile file;
  file.json["extensionsRequired"] = Json::array({"KHR_mesh_quantization"});
  const auto node = [&](int accessor) { file.Node({{"mesh", file.Mesh(accessor)}}); };
  node(file.Accessor(std::vector<int16_t>{-32768, 32767, 0, 1, 2, 3, 4, 5, 7}, 3, true));
  node(file.Accessor(std::vector<uint16_t>{65535, 0, 13107, 1, 2, 3, 4, 5, 7}, 3, true));
  node(file.Accessor(std::vector<int8_t>{-128, 127, 0, 1, 2, 3, 4, 5, 7}, 3, true));
  node(file.Accessor(std::vector<uint8_t>{255, 0, 51, 1, 2, 3, 4, 5, 7}, 3, true));
  node(file.Accessor(std::vector<int16_t>{-32768, 32767, 0, 1, 2, 3, 4, 5, 7}, 3));
  const SceneFile scene = Read(file);
  ASSERT_EQ(scene.points.size(), 15U);
  EXPECT_EQ(scene.points[0], Vec3(-1, 1, 0));
  EXPECT_EQ(scene.points[3], Vec3(1, 0, 0.2));
  EXPECT_EQ(scene.points[6], Vec3(-1, 1, 0));
  EXPECT_EQ(scene.points[9], Vec3(1, 0, 0.2));
  EXPECT_EQ(scene.points[12], Vec3(-32768, 32767, 0));
}

TEST(GltfReader, ReadsInterleavedAndSparseAccessors) {
  GltfFile file;
  // A point and a normal in turn, behind one unused float.
  const int view = file.View(std::vector<float>{9, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 1,  //
                                                2, 2, 0, 0, 0, 1});
  file.json["bufferViews"][view]["byteStride"] = 24;
  file.json["accessors"].push_back({{"bufferView", view},
                                    {"byteOffset", 4},
                                    {"componentType", 5126},
                                    {"count", 3},
                                    {"type", "VEC3"}});
  const int indices = file.View(std::vector<uint16_t>{1, 2});
  const int values = file.View(std::vector<float>{3, 0, 0, 3, 4, 0});
  file.json["accessors"].push_back(
      {{"componentType", 5126},
       {"count", 3},
       {"type", "VEC3"},
       {"sparse",
        {{"count", 2},
         {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
         {"values", {{"bufferView", values}}}}}});
  file.Node({{"mesh", file.Mesh(0)}});
  file.Node({{"mesh", file.Mesh(1)}});
  const SceneFile scene = Read(file);
  ASSERT_EQ(scene.faces.size(), 2U);
  EXPECT_THAT(CornersOf(scene, 0), ElementsAre(Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(2, 2, 0)));
  EXPECT_THAT(CornersOf(scene, 1), ElementsAre(Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(3, 4, 0)));
}

// Random chains of nodes, each a matrix or a translation, rotation and scale (mirroring ones too):
// points are where the product of all puts them, and fronts stay fronts.
TEST(GltfReader, NodesTransformPointsAndKeepFronts) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(Mix(seed));
    const auto number = [&](double low, double high) { return low + (high - low) * random.Unit(); };
    GltfFile file;
    const std::vector<Vec3> points{{0, 0, 0}, {1, 0.25, 0}, {0.5, 2, -1}};
    glm::dmat4 expected(1.0);
    int child = file.Node({{"mesh", file.Mesh(file.Points(points))}}, false);
    const int depth = 1 + static_cast<int>(random.Bits() % 4);
    for (int d = 0; d < depth; ++d) {
      const Vec3 move(number(-5, 5), number(-5, 5), number(-5, 5));
      const Vec3 axis = glm::normalize(Vec3(number(-1, 1), number(-1, 1), number(0.1, 1)));
      const double angle = number(-3, 3);
      Vec3 scale(number(0.5, 2), number(0.5, 2), number(0.5, 2));
      for (int c = 0; c < 3; ++c) {
        if (random.Bits() % 2 == 0) scale[c] = -scale[c];
      }
      const glm::dmat4 own =
          glm::scale(glm::rotate(glm::translate(glm::dmat4(1.0), move), angle, axis), scale);
      Json node{{"children", {child}}};
      if (random.Bits() % 2 == 0) {
        for (int i = 0; i < 16; ++i) node["matrix"].push_back(own[i / 4][i % 4]);
      } else {
        const glm::dquat q = glm::angleAxis(angle, axis);
        node["translation"] = {move.x, move.y, move.z};
        node["rotation"] = {q.x, q.y, q.z, q.w};
        node["scale"] = {scale.x, scale.y, scale.z};
      }
      child = file.Node(node, d + 1 == depth);
      expected = own * expected;
    }
    const SceneFile scene = Read(file);
    ASSERT_EQ(scene.faces.size(), 1U);
    ASSERT_EQ(scene.points.size(), 3U);
    for (size_t i = 0; i < 3; ++i) {
      const Vec3 want(expected * glm::dvec4(points[i], 1));
      double nearest = 1e9;
      for (const Vec3& p : scene.points) nearest = std::min(nearest, glm::length(p - want));
      EXPECT_LT(nearest, 1e-12 * (1 + glm::length(want)));
    }
    // Fronts go with the inverse transpose.
    const Vec3 front = glm::transpose(glm::inverse(glm::dmat3(expected))) * AreaOf(points);
    EXPECT_GT(glm::dot(AreaOf(CornersOf(scene, 0)), front), 0);
  }
}

TEST(GltfReader, OneMeshMayStandInManyPlaces) {
  GltfFile file;
  const int mesh = file.Square(-1);
  for (int i = 0; i < 5; ++i) file.Node({{"mesh", mesh}, {"translation", {3 * i, 0, 0}}});
  const SceneFile scene = Read(file);
  EXPECT_EQ(scene.faces.size(), 10U);
  ASSERT_EQ(scene.points.size(), 20U);
  EXPECT_EQ(scene.points[16], Vec3(11, -1, 0));
  EXPECT_THAT(scene.Where(scene.faces[9]), HasSubstr("nodes[4], meshes[0].primitives[0]"));
}

TEST(GltfReader, TakesTheSceneThatTheFileNames) {
  GltfFile file;
  const int mesh = file.Square(-1);
  file.Node({{"mesh", mesh}});
  file.Node({{"mesh", mesh}, {"translation", {0, 0, 7}}}, false);
  file.json["scenes"].push_back({{"nodes", {1}}});
  file.json["scene"] = 1;
  SceneFile scene = Read(file);
  ASSERT_EQ(scene.points.size(), 4U);
  EXPECT_EQ(scene.points[0].z, 7);
  file.json["scene"] = 2;
  EXPECT_THAT(ErrorOf(file), HasSubstr("scene: scenes[2] does not exist, the file has 2"));
  file.json.erase("scene");
  file.json.erase("scenes");  // all nodes without parents
  EXPECT_EQ(Read(file).points.size(), 8U);
}

TEST(GltfReader, RefusesWhatIsNoTree) {
  GltfFile file = Square();
  file.Node({{"children", {0}}});
  EXPECT_THAT(ErrorOf(file), HasSubstr("nodes[0] 'floor': reached twice"));
  file = Square();
  file.json["nodes"][0]["children"] = {0};
  EXPECT_THAT(ErrorOf(file), HasSubstr("reached twice"));
  file = Square();
  file.json["nodes"][0]["children"] = {1};
  EXPECT_THAT(ErrorOf(file), HasSubstr("nodes[1]: no such node"));
  GltfFile deep;
  int child = deep.Node({{"mesh", deep.Square(-1)}}, false);
  for (int i = 0; i < 600; ++i) child = deep.Node({{"children", {child}}}, i == 599);
  EXPECT_THAT(ErrorOf(deep), HasSubstr("deeper than 512 nodes"));
  file = Square();
  file.json["nodes"][0]["scale"] = {1e300, 1e300, 1e300};
  file.Node({{"scale", {1e300, 1, 1}}, {"children", {0}}}, false);
  file.json["scenes"][0]["nodes"] = {1};
  EXPECT_THAT(ErrorOf(file), HasSubstr("nodes[0] 'floor': its transform overflows"));
  file.json["nodes"][1]["scale"] = {1, 1};
  EXPECT_THAT(ErrorOf(file), HasSubstr("nodes[1]: matrix, translation, rotation or scale"));
}

TEST(GltfReader, RefusesNumbersOutOfRange) {
  const auto broken = [](const char* list, const char* key, const Json& value) {
    GltfFile file = Square();
    file.json[list][0][key] = value;
    return ErrorOf(file);
  };
  EXPECT_THAT(broken("accessors", "count", 5), HasSubstr("accessors[0]: 5 elements"));
  EXPECT_THAT(broken("accessors", "count", 1ULL << 62), HasSubstr("accessors[0]"));
  EXPECT_THAT(broken("accessors", "count", 2), HasSubstr("index 2 names a point"));
  EXPECT_THAT(broken("accessors", "byteOffset", ~0ULL), HasSubstr("accessors[0]"));
  EXPECT_THAT(broken("accessors", "componentType", 5130), HasSubstr("accessors[0]"));
  EXPECT_THAT(broken("accessors", "type", "VEC2"), HasSubstr("accessors[0]"));
  EXPECT_THAT(broken("accessors", "bufferView", 7), HasSubstr("bufferViews[7]: no such"));
  EXPECT_THAT(broken("bufferViews", "byteOffset", ~0ULL), HasSubstr("bufferViews[0]"));
  EXPECT_THAT(broken("bufferViews", "byteLength", 1000), HasSubstr("bufferViews[0]"));
  EXPECT_THAT(broken("bufferViews", "byteStride", 4), HasSubstr("stride of 4"));
  EXPECT_THAT(broken("bufferViews", "buffer", 3), HasSubstr("buffers[3] does not exist"));
  EXPECT_THAT(broken("nodes", "mesh", 3), HasSubstr("meshes[3] does not exist, the file has 1"));
  const auto primitive = [](const char* key, const Json& value) {
    GltfFile file = Square();
    file.json["meshes"][0]["primitives"][0][key] = value;
    return ErrorOf(file);
  };
  EXPECT_THAT(primitive("material", 3), HasSubstr("materials[3] does not exist, the file has 0"));
  EXPECT_THAT(primitive("indices", 0), HasSubstr("accessors[0]: indices must be unsigned"));
  EXPECT_THAT(primitive("indices", 9), HasSubstr("indices"));
  EXPECT_THAT(primitive("mode", 7), HasSubstr("mode 7"));
  EXPECT_THAT(primitive("attributes", {{"NORMAL", 0}}), HasSubstr("no attribute POSITION"));
  EXPECT_THAT(primitive("attributes", {{"POSITION", 9}}), HasSubstr("accessors[9]: no such"));
  EXPECT_THAT(primitive("attributes", 5), HasSubstr("test.gltf"));
}

TEST(GltfReader, RefusesPointsThatAreNone) {
  GltfFile file;
  const float bad = std::numeric_limits<float>::quiet_NaN();
  file.Node(
      {{"mesh", file.Mesh(file.Accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 1, bad, 0}, 3))}});
  EXPECT_THAT(ErrorOf(file), HasSubstr("accessors[0]: element 2"));
}

TEST(GltfReader, HoldsItsLimits) {
  SceneLimits limits;
  limits.polygons = 1;
  EXPECT_THAT(ErrorOf(Square(), limits), HasSubstr("accessors[1]: 6 elements, more than 3"));
  GltfFile fan;
  fan.Node(
      {{"mesh", fan.Mesh(fan.Points({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}), -1, -1, 6)}});
  EXPECT_THAT(ErrorOf(fan, limits), HasSubstr("more than 1 triangles"));
  limits = {};
  limits.vertices = 3;
  EXPECT_THAT(ErrorOf(Square(), limits), HasSubstr("accessors[0]: 4 elements, more than 3"));
  GltfFile file;
  const int mesh = file.Square(-1);
  for (int i = 0; i < 3; ++i) file.Node({{"mesh", mesh}});
  limits.vertices = 9;
  EXPECT_THAT(ErrorOf(file, limits), HasSubstr("nodes[2], meshes[0].primitives[0]: more than 9"));
}

// A file with one light, turned about x by 90° and moved.
GltfFile WithLight(const Json& light, const Json& scale = {1, 1, 1}) {
  GltfFile file = Square();
  const double half = std::sqrt(0.5);
  file.Node({{"translation", {1, 2, 3}},
             {"rotation", {half, 0, 0, half}},
             {"scale", scale},
             {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({light});
  file.json["extensionsRequired"] = Json::array({"KHR_lights_punctual"});
  return file;
}

TEST(GltfReader, ReadsLightsWhereTheirNodesAre) {
  const SceneFile point = Read(WithLight({{"type", "point"}}));
  ASSERT_EQ(point.lights.size(), 1U);
  EXPECT_EQ(point.lights[0].kind, LightKind::kPoint);
  EXPECT_EQ(point.lights[0].position_m, Vec3(1, 2, 3));
  EXPECT_EQ(point.lights[0].intensity, Rgb(1.0));
  EXPECT_EQ(point.lights[0].name, "nodes[1]");

  const SceneFile sun = Read(WithLight(
      {{"type", "directional"}, {"name", "sun"}, {"color", {1, 0.5, 0.25}}, {"intensity", 8}},
      {2, 2, 2}));
  ASSERT_EQ(sun.lights.size(), 1U);
  EXPECT_EQ(sun.lights[0].kind, LightKind::kDirectional);
  EXPECT_EQ(sun.lights[0].intensity, Rgb(8, 4, 2));
  EXPECT_EQ(sun.lights[0].name, "sun");
  EXPECT_LT(glm::length(sun.lights[0].direction - Vec3(0, 1, 0)), 1e-12);  // −z, turned

  const SceneFile spot = Read(
      WithLight({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.2}}}}));
  ASSERT_EQ(spot.lights.size(), 1U);
  EXPECT_EQ(spot.lights[0].kind, LightKind::kSpot);
  EXPECT_DOUBLE_EQ(spot.lights[0].cosine_full, std::cos(0.1));
  EXPECT_DOUBLE_EQ(spot.lights[0].cosine_none, std::cos(0.2));
}

TEST(GltfReader, RefusesLightsThatMakeNoSense) {
  EXPECT_THAT(ErrorOf(WithLight({{"type", "area"}})), HasSubstr("lights[0]: its type is none of"));
  EXPECT_THAT(ErrorOf(WithLight({{"type", "point"}, {"intensity", -1}})), HasSubstr("negative"));
  EXPECT_THAT(ErrorOf(WithLight({{"type", "point"}, {"color", {1, 1}}})),
              HasSubstr("three numbers"));
  EXPECT_THAT(ErrorOf(WithLight({{"type", "spot"},
                                 {"spot", {{"innerConeAngle", 0.3}, {"outerConeAngle", 0.2}}}})),
              HasSubstr("angles must rise"));
  EXPECT_THAT(ErrorOf(WithLight({{"type", "directional"}}, {0, 0, 0})),
              HasSubstr("nodes[1]: its scale"));
  GltfFile file = WithLight({{"type", "point"}});
  file.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 7;
  EXPECT_THAT(ErrorOf(file), HasSubstr("nodes[1]: its light 7 does not exist, the file has 1"));
}

TEST(GltfReader, TellsWhatItLeavesOut) {
  GltfFile file = Square();
  file.Node({{"mesh", file.Mesh(0, -1, -1, 1)}, {"name", "wire"}});
  file.Node({{"camera", 0}});
  file.json["cameras"].push_back(
      {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
  file.json["meshes"][0]["primitives"][0]["targets"] = Json::array({{{"POSITION", 0}}});
  const SceneFile scene = Read(file);
  EXPECT_EQ(scene.faces.size(), 2U);
  EXPECT_THAT(scene.lines, ElementsAre("test.gltf: nodes[1] 'wire', meshes[1].primitives[0]"));
  EXPECT_THAT(scene.cameras, ElementsAre("test.gltf: nodes[2]"));
  EXPECT_THAT(scene.animated, ElementsAre("test.gltf: nodes[0] 'floor', meshes[0].primitives[0]"));
  GltfFile wires;
  wires.Node({{"mesh", wires.Mesh(wires.Points({{0, 0, 0}, {1, 0, 0}}), -1, -1, 1)}});
  EXPECT_THAT(ErrorOf(wires), HasSubstr("no triangles"));
}

}  // namespace
}  // namespace isolux
