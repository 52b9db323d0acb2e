#include "common/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/util/random.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void ExpectRefused(const Scene& scene, const std::string& words) {
  const Status status = Validate(scene);
  EXPECT_FALSE(status.ok()) << "expected: " << words;
  EXPECT_NE(status.message().find(words), std::string::npos) << status.message();
}

TEST(SceneBytes, RoundTrip) {
  Scene scene = testing::CornellBox(true);
  scene.origin_m = {1, -2, 3.5};
  const std::string bytes = Encode(scene);
  const Result<Scene> back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(Encode(*back), bytes);
  EXPECT_EQ(back->unit, "mm");
  EXPECT_EQ(back->materials[3].name, "light");
  EXPECT_EQ(back->materials[3].exitance, scene.materials[3].exitance);
  EXPECT_EQ(back->vertices, scene.vertices);
  EXPECT_EQ(back->polygons[4].vertices, scene.polygons[4].vertices);
  EXPECT_EQ(back->polygons[4].file_polygon, 4U);
  EXPECT_EQ(back->origin_m, scene.origin_m);
  EXPECT_EQ(back->file_polygon_count, 24U);
}

// Lights follow all else, and scenes without are encoded as if there were none.
TEST(SceneBytes, LightsFollow) {
  Scene scene = testing::CornellBox(true);
  const std::string dark = Encode(scene);
  scene.lights.resize(2);
  scene.lights[0].name = "bulb";
  scene.lights[0].position_m = {1, 2, 3};
  scene.lights[0].intensity = {4, 5, 6};
  scene.lights[1].kind = LightKind::kSpot;
  scene.lights[1].direction = {0, 0.6, 0.8};
  scene.lights[1].cosine_full = 0.75;
  scene.lights[1].cosine_none = 0.5;
  EXPECT_TRUE(Validate(scene).ok());
  const std::string bytes = Encode(scene);
  EXPECT_EQ(bytes.substr(0, dark.size()), dark);
  const Result<Scene> back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(back->lights, scene.lights);
  EXPECT_EQ(Encode(*back), bytes);
  for (size_t length = dark.size() + 1; length < bytes.size(); ++length) {
    EXPECT_FALSE(Decode(bytes.substr(0, length)).has_value()) << length;
  }
  EXPECT_FALSE(Decode(bytes + '\0').has_value());
  SceneLimits limits;
  limits.lights = 1;
  EXPECT_EQ(Decode(bytes, limits).error().code(), StatusCode::kResourceExhausted);
  std::string many = bytes;  // a count that nothing follows
  many.replace(dark.size() + 8, 8, std::string("\0\x10\0\0\0\0\0\0", 8));
  EXPECT_EQ(Decode(many).error().code(), StatusCode::kDataLoss);
}

TEST(SceneBytes, TheSkyFollows) {
  Scene scene = testing::CornellBox(true);
  const std::string dark = Encode(scene);
  scene.lights.resize(1);
  const std::string lit = Encode(scene);
  scene.sky.columns = 2;
  scene.sky.rows = 1;
  scene.sky.texels = {1, 2, 3, 4, 5, 6};
  EXPECT_TRUE(Validate(scene).ok());
  for (const bool lights : {true, false}) {
    if (!lights) scene.lights.clear();
    const std::string bytes = Encode(scene);
    const std::string& before = lights ? lit : dark;
    EXPECT_EQ(bytes.substr(0, before.size()), before);
    const Result<Scene> back = Decode(bytes);
    ASSERT_TRUE(back.has_value()) << back.error().message();
    EXPECT_EQ(back->sky, scene.sky);
    EXPECT_EQ(Encode(*back), bytes);
    for (size_t length = before.size() + 1; length < bytes.size(); ++length) {
      EXPECT_FALSE(Decode(bytes.substr(0, length)).has_value()) << length;
    }
  }
  scene.sky.texels[3] = -1;
  ExpectRefused(scene, "sky: a radiance is negative");
  scene.sky.texels.pop_back();
  ExpectRefused(scene, "sky: not as many texels");
}

TEST(SceneBytes, MirrorsFollow) {
  Scene scene = testing::FurnaceCube(0.2, 1);
  const std::string without = Encode(scene);
  scene.materials.back().specular = 0.5;
  const std::string bytes = Encode(scene);
  ASSERT_TRUE(Decode(bytes).has_value());
  EXPECT_EQ(Decode(bytes)->materials.back().specular, 0.5);
  EXPECT_EQ(Encode(*Decode(bytes)), bytes);
  for (size_t length = without.size() + 1; length < bytes.size(); ++length) {
    EXPECT_FALSE(Decode(bytes.substr(0, length)).has_value()) << length;
  }
  EXPECT_FALSE(Decode(bytes + '\0').has_value());
  // Of a material that is not there; more than there are.
  std::string damaged = bytes;
  damaged[without.size() + 16] = 99;
  EXPECT_FALSE(Decode(damaged).has_value());
  damaged = bytes;
  damaged[without.size() + 15] = 127;
  EXPECT_FALSE(Decode(damaged).has_value());
  scene.materials.back().specular = 0.9;
  EXPECT_EQ(Validate(scene).code(), StatusCode::kInvalidArgument);
}

TEST(SceneBytes, GlossFollows) {
  Scene scene = testing::FurnaceCube(0.2, 1);
  scene.materials.back().specular = 0.1;
  const std::string without = Encode(scene);
  scene.materials.back().gloss = {{0.5, 0, 0.7}, true};
  scene.medium.extinction_per_m = Rgb(0.1);
  const std::string bytes = Encode(scene);
  const auto back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(back->materials.back().gloss, scene.materials.back().gloss);
  EXPECT_EQ(Encode(*back), bytes);
  for (size_t length = without.size() + 1; length < bytes.size(); ++length) {
    if (length == without.size() + 49) continue;  // all but the medium
    EXPECT_FALSE(Decode(bytes.substr(0, length)).has_value()) << length;
  }
  for (const size_t at :
       {16U, 15U, 48U}) {  // of no material; more than there are; neither kept nor not
    std::string damaged = bytes;
    damaged[without.size() + at] = 99;
    EXPECT_FALSE(Decode(damaged).has_value()) << at;
  }
  EXPECT_TRUE(Validate(scene).ok());
  scene.materials.back().gloss.kept = false;
  EXPECT_TRUE(Validate(scene).ok());  // 0.2 and 0.1 and 0.7
  scene.materials.back().gloss.share.y = 0.8;
  ExpectRefused(scene, "a lobe that reflects more than is left");
  scene.materials.back().gloss.share.y = -0.1;
  ExpectRefused(scene, "a lobe that reflects more than is left");
}

TEST(SceneCheck, RefusesLightsThatMakeNoSense) {
  Scene scene = testing::FurnaceCube(0.5, 1);
  scene.lights.resize(1);
  const Light good = scene.lights[0];
  EXPECT_TRUE(Validate(scene).ok());
  scene.lights[0].intensity.y = -1;
  ExpectRefused(scene, "light 0 '': its intensity is negative");
  scene.lights[0] = good;
  scene.lights[0].direction = {0, 0, 2};
  ExpectRefused(scene, "not of length 1");
  scene.lights[0] = good;
  scene.lights[0].position_m.x = kNan;
  ExpectRefused(scene, "not a point");
  scene.lights[0] = good;
  scene.lights[0].cosine_none = 1.5;
  ExpectRefused(scene, "inner angle");
  scene.lights[0] = good;
  scene.lights[0].kind = static_cast<LightKind>(9);
  ExpectRefused(scene, "unknown kind");
}

TEST(SceneBytes, EqualScenesHaveEqualBytes) {
  Scene a = testing::FurnaceCube(0.5, 1);
  Scene b = a;
  for (Vec3& v : b.vertices) {
    for (int i = 0; i < 3; ++i) v[i] = v[i] == 0 ? -0.0 : v[i];
  }
  b.repairs.entries.push_back({"zero-area faces dropped", 3, "a.obj:7"});
  EXPECT_EQ(Encode(a), Encode(b));
  b.vertices[0].x += 1e-15;
  EXPECT_NE(HashOf(Encode(a)), HashOf(Encode(b)));
}

TEST(SceneBytes, HashIs128BitsInHexadecimal) {
  // Published value of XXH3-128 of nothing.
  EXPECT_EQ(HashOf(""), "99aa06d3014798d86001c324468d497f");
}

TEST(SceneBytes, EveryTruncationIsAnError) {
  const std::string bytes = Encode(testing::FurnaceCube(0.5, 1));
  for (size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(Decode(bytes.substr(0, length)).has_value()) << length;
  }
  EXPECT_FALSE(Decode(bytes + "x").has_value());
}

TEST(SceneBytes, DamagedBytesGiveAnErrorOrAScene) {
  const std::string bytes = Encode(testing::CornellBox(false));
  for (uint64_t seed = 1; seed <= 20'000; ++seed) {
    Random random(Mix(seed));
    std::string damaged = bytes;
    const int changes = 1 + static_cast<int>(random.Bits() % 4);
    for (int i = 0; i < changes; ++i) {
      // Half of the damage goes where the counts are.
      const uint64_t span = random.Bits() % 2 == 0 ? 80 : damaged.size();
      damaged[random.Bits() % span] = static_cast<char>(random.Bits());
    }
    const Result<Scene> scene = Decode(damaged);
    if (!scene.has_value()) {
      EXPECT_FALSE(scene.error().message().empty());
      continue;
    }
    if (Validate(*scene).ok()) {
      EXPECT_FALSE(MakeSurfaces(*scene).empty()) << "seed " << seed;
    }
  }
}

TEST(SceneBytes, CountsAreCheckedBeforeMemoryIsTaken) {
  std::string bytes = Encode(testing::FurnaceCube(0.5, 1));
  for (int i = 0; i < 8; ++i) bytes[8 + i] = static_cast<char>(0xff);  // vertices
  EXPECT_EQ(Decode(bytes).error().code(), StatusCode::kResourceExhausted);
  SceneLimits few;
  few.polygons = 5;
  EXPECT_EQ(Decode(Encode(testing::FurnaceCube(0.5, 1)), few).error().code(),
            StatusCode::kResourceExhausted);
  few = {};
  few.bytes = 100;
  EXPECT_EQ(Decode(Encode(testing::FurnaceCube(0.5, 1)), few).error().code(),
            StatusCode::kResourceExhausted);
}

TEST(SceneValidate, NamesWhatIsWrongAndTheRemedy) {
  const Scene good = testing::FurnaceCube(0.5, 1);
  ASSERT_TRUE(Validate(good).ok());

  Scene scene = good;
  scene.polygons.clear();
  ExpectRefused(scene, "no polygons");

  scene = good;
  scene.vertices[2].y = kNan;
  ExpectRefused(scene, "vertex 2");
  scene.vertices[2].y = 1e30;
  ExpectRefused(scene, "is the unit right?");

  scene = good;
  scene.materials[1].reflectance.y = 1;
  ExpectRefused(scene, "material 1 'x high': reflectance outside [0, 1)");
  scene.materials[1].reflectance.y = kNan;
  ExpectRefused(scene, "reflectance");

  scene = good;
  scene.materials[1].exitance.z = -1;
  ExpectRefused(scene, "exitance");

  scene = good;
  scene.polygons[3].vertices[1] = 8;
  ExpectRefused(scene, "polygon 3: vertex 8 does not exist");
  scene = good;
  scene.polygons[3].material = 6;
  ExpectRefused(scene, "polygon 3: material 6 does not exist");
  scene = good;
  scene.polygons[3].sides = 64;
  ExpectRefused(scene, "side flags");

  scene = good;
  scene.metres_per_unit = 0;
  ExpectRefused(scene, "metres per unit");
  scene = good;
  scene.origin_m.x = kNan;
  ExpectRefused(scene, "origin");
}

TEST(SceneValidate, ChecksShapes) {
  Scene scene = testing::FurnaceCube(0.5, 1);
  scene.polygons[2].file_polygon = 17;
  std::swap(scene.polygons[2].vertices[1], scene.polygons[2].vertices[2]);
  ExpectRefused(scene, "polygon 17: no area");  // a bow tie whose halves cancel

  scene = testing::FurnaceCube(0.5, 1);
  scene.vertices.emplace_back(0.2, 0.0, 0.2);
  scene.polygons[2].vertices = {0, scene.polygons[2].vertices[1], 8, scene.polygons[2].vertices[3]};
  ExpectRefused(scene, "not convex");

  scene = testing::FurnaceCube(0.5, 1);
  scene.vertices[scene.polygons[2].vertices[2]].y += 1e-3;
  ExpectRefused(scene, "not in one plane");
  scene.vertices[scene.polygons[2].vertices[2]].y -= 1e-3 - 1e-6;
  EXPECT_TRUE(Validate(scene).ok()) << Validate(scene).message();
}

TEST(SceneValidate, RefusesDarkness) {
  Scene scene = testing::FurnaceCube(0.5, 0);
  ExpectRefused(scene, "nothing in the scene emits light");
  scene = testing::FurnaceCube(0.5, 1);
  for (Polygon& polygon : scene.polygons) polygon.sides = kFrontTakesPart;
  ExpectRefused(scene, "nothing in the scene emits light");
  scene.polygons[0].sides = kBackEmits;
  EXPECT_TRUE(Validate(scene).ok());
}

TEST(SceneValidate, KeepsLimits) {
  SceneLimits limits;
  limits.materials = 5;
  EXPECT_EQ(Validate(testing::FurnaceCube(0.5, 1), limits).code(), StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace isolux
