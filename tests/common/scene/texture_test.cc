// Means of textures over polygons: against clipping at every texel, against each other, and where
// they are known.
#include "common/scene/texture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/hierarchy/element.h"
#include "common/scene/surface_maps.h"
#include "common/util/random.h"

namespace isolux {
namespace {

using Polygon2 = std::vector<TexturePoint>;

Texture RandomTexture(Random& random, uint32_t width, uint32_t height) {
  Texture texture{width,
                  height,
                  static_cast<Wrap>(random.Bits() % 3),
                  static_cast<Wrap>(random.Bits() % 3),
                  {}};
  for (uint32_t i = 0; i < 3 * width * height; ++i) {
    texture.texels.push_back(static_cast<float>(random.Unit()));
  }
  return texture;
}

double AreaOf(const Polygon2& polygon) {
  double area = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const TexturePoint &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    area += 0.5 * (a.x * b.y - b.x * a.y);
  }
  return std::abs(area);
}

// What of a convex polygon lies where sign · (axis − at) is not above 0 (Sutherland and Hodgman).
Polygon2 Clip(const Polygon2& polygon, bool axis_x, double sign, double at) {
  const auto distance = [&](const TexturePoint& p) { return sign * ((axis_x ? p.x : p.y) - at); };
  Polygon2 kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const TexturePoint &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = distance(a), db = distance(b);
    if (da <= 0) kept.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      const double t = da / (da - db);
      kept.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
    }
  }
  return kept;
}

int Wrapped(int i, int size, Wrap wrap) {
  if (wrap == Wrap::kClamp) return std::min(std::max(i, 0), size - 1);
  while (i < 0) i += 2 * size;
  i %= 2 * size;
  if (wrap == Wrap::kMirror) return i < size ? i : 2 * size - 1 - i;
  return i % size;
}

// Mean of the first channel and of its square, texel by texel.
std::array<double, 2> ByClipping(const Texture& texture, const Polygon2& polygon) {
  double low_x = 1e9, high_x = -1e9, low_y = 1e9, high_y = -1e9;
  for (const TexturePoint& p : polygon) {
    low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x);
    low_y = std::min(low_y, p.y), high_y = std::max(high_y, p.y);
  }
  double area = 0, sum = 0, square = 0;
  for (int y = static_cast<int>(std::floor(low_y)); y < high_y; ++y) {
    const Polygon2 row = Clip(Clip(polygon, false, -1, y), false, 1, y + 1);
    for (int x = static_cast<int>(std::floor(low_x)); x < high_x; ++x) {
      const double part = AreaOf(Clip(Clip(row, true, -1, x), true, 1, x + 1));
      const int at = Wrapped(y, static_cast<int>(texture.height), texture.wrap_v) *
                         static_cast<int>(texture.width) +
                     Wrapped(x, static_cast<int>(texture.width), texture.wrap_u);
      const double value = texture.texels[3 * static_cast<size_t>(at)];
      area += part;
      sum += part * value;
      square += part * value * value;
    }
  }
  return {sum / area, square / area};
}

TEST(TextureIntegral, IsThatOfEveryTexel) {
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(Mix(seed));
    const auto width = static_cast<uint32_t>(1 + random.Bits() % 7);
    const auto height = static_cast<uint32_t>(1 + random.Bits() % 7);
    const Texture texture = RandomTexture(random, width, height);
    const TextureIntegral integral(texture);
    // A convex polygon about a random place, of either winding, some with corners on the borders.
    const double size = std::exp2(4 * random.Unit() - 2), turn = 7 * random.Unit();
    const int corners = 3 + static_cast<int>(random.Bits() % 2);
    const double x = 40 * random.Unit() - 20, y = 40 * random.Unit() - 20;
    Polygon2 polygon;
    for (int i = 0; i < corners; ++i) {
      const double angle = turn + 2 * M_PI * i / corners;
      polygon.push_back({x + size * std::cos(angle), y + 0.7 * size * std::sin(angle)});
      if (seed % 3 == 0) polygon[i] = {std::round(polygon[i].x), std::round(polygon[i].y)};
    }
    if (AreaOf(polygon) < 1e-3) continue;
    if (seed % 2 == 0) std::reverse(polygon.begin(), polygon.end());
    const TextureMoments have = integral.Over(polygon);
    const auto [mean, square] = ByClipping(texture, polygon);
    EXPECT_NEAR(have.mean.x, mean, 1e-11) << "seed " << seed;
    EXPECT_NEAR(have.square.x, square, 1e-11) << "seed " << seed;
  }
}

TEST(TextureIntegral, OfTheWholeImageIsItsMean) {
  Random random(1);
  const Texture texture = RandomTexture(random, 37, 23);
  double mean = 0;
  for (size_t i = 0; i < texture.texels.size(); i += 3) mean += texture.texels[i] / (37.0 * 23);
  const TextureIntegral integral(texture);
  EXPECT_NEAR(integral.Over(Polygon2{{0, 0}, {37, 0}, {37, 23}, {0, 23}}).mean.x, mean, 1e-13);
  if (texture.wrap_u != Wrap::kClamp && texture.wrap_v != Wrap::kClamp) {
    EXPECT_NEAR(integral.Over(Polygon2{{-74, 0}, {74, 0}, {74, 46}, {-74, 46}}).mean.x, mean,
                1e-13);
  }
}

Texture Checkerboard(float dark, float light) {
  Texture board{8, 8, Wrap::kRepeat, Wrap::kRepeat, {}};
  for (int i = 0; i < 64; ++i) {
    for (int c = 0; c < 3; ++c) board.texels.push_back((i + i / 8) % 2 == 0 ? dark : light);
  }
  return board;
}

TEST(TextureIntegral, KnowsTheCheckerboard) {
  const TextureIntegral board(Checkerboard(0.5F, 1.5F));
  const auto mean = [&](const Polygon2& p) { return board.Over(p).mean.y; };
  EXPECT_EQ(mean({{0.1, 0.1}, {0.9, 0.1}, {0.9, 0.9}}), 0.5);
  EXPECT_EQ(mean({{1.1, 0.1}, {1.9, 0.1}, {1.9, 0.9}}), 1.5);
  EXPECT_NEAR(mean({{0, 0}, {2, 0}, {2, 1}, {0, 1}}), 1, 1e-14);
  EXPECT_NEAR(mean({{0, 0}, {1.5, 0}, {1.5, 1}, {0, 1}}), (0.5 + 0.75) / 1.5, 1e-14);
  // A triangle's half lies in its first texel's column: 3/4 dark at the wide end.
  EXPECT_NEAR(mean({{0, 0}, {2, 0}, {0, 1}}), 0.75 * 0.5 + 0.25 * 1.5, 1e-14);
  EXPECT_NEAR(mean({{-3, -5}, {5, -5}, {5, 3}, {-3, 3}}), 1, 1e-13);
  EXPECT_EQ(mean({{1.5, 0.5}, {1.5, 0.5}, {1.5, 0.5}}), 1.5);  // no area
  EXPECT_NEAR(board.Over(Polygon2{{0, 0}, {8, 0}, {8, 8}, {0, 8}}).square.z, 1.25, 1e-13);
}

// A scene of one square over the whole image, skewed.
Scene Square(Random& random) {
  Scene scene;
  scene.vertices = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {0, 2, 0}};
  scene.materials.resize(1);
  Material& material = scene.materials[0];
  material.reflectance = {0.25, 0.3, 0.2};
  material.exitance = {1, 2, 3};
  scene.textures.push_back(RandomTexture(random, 16, 9));
  material.reflectance_map = {0, {1.1, 0.2, 0.1, -0.3, 0.9, 4}};
  material.exitance_map = {0, {0, 1, 0, 2, 0, 0}};
  scene.coordinates = {{{0.5, 0.1, 0, 0}, {0.2, 0.7, 0, -1}}};
  Polygon polygon;
  polygon.vertices = {0, 1, 2, 3};
  polygon.coordinates = 0;
  polygon.sides = kFrontTakesPart | kFrontEmits | kBackTakesPart;
  polygon.file_polygon = 0;
  scene.polygons = {polygon};
  return scene;
}

TEST(SurfaceMaps, PartsAddUpToTheWhole) {
  Random random(5);
  const Scene scene = Square(random);
  const SurfaceMaps maps(scene);
  for (const Surface& surface : MakeSurfaces(scene)) {
    const ConvexPolygon whole = SideGeometry(scene, 0, surface.side);
    const Optics mean = maps.Over(surface, whole);
    EXPECT_LT(glm::length(mean.reflectance - surface.reflectance), 1e-15);
    EXPECT_EQ(Sum(surface.exitance) > 0, surface.side == Side::kFront);
    for (const int levels : {1, 4, 9, 12}) {
      Rgb reflectance(0.0), exitance(0.0);
      const uint64_t count = 1ULL << levels;
      for (uint64_t i = 0; i < count; ++i) {
        const Optics part = maps.Over(surface, ElementGeometry(whole, count + i));
        reflectance += part.reflectance / static_cast<double>(count);
        exitance += part.exitance / static_cast<double>(count);
      }
      EXPECT_LT(glm::length(reflectance - mean.reflectance), 1e-12) << levels;
      EXPECT_LT(glm::length(exitance - mean.exitance), 1e-12) << levels;
    }
  }
}

TEST(SurfaceMaps, DeviationsAreThoseOfTheParts) {
  Random random(6);
  const Scene scene = Square(random);
  const SurfaceMaps maps(scene);
  const Surface surface = MakeSurfaces(scene)[0];
  const ConvexPolygon whole = SideGeometry(scene, 0, Side::kFront);
  const Optics mean = maps.Over(surface, whole);
  double square = 0;
  const uint64_t count = 1ULL << 14;
  for (uint64_t i = 0; i < count; ++i) {
    const Optics part = maps.Over(surface, ElementGeometry(whole, count + i));
    square += (part.reflectance.x * part.reflectance.x +
               part.reflectance_deviation.x * part.reflectance_deviation.x) /
              static_cast<double>(count);
  }
  const double deviation = std::sqrt(square - mean.reflectance.x * mean.reflectance.x);
  EXPECT_NEAR(mean.reflectance_deviation.x, deviation, 1e-11);
  EXPECT_GT(deviation, 0.02);
}

// Coordinates that vary in one direction alone, as of strips of a palette: the same as those that
// vary in the other too where the image does not.
TEST(SurfaceMaps, LinesInTheImageCountAsWhatLiesOnThem) {
  Random random(7);
  Scene lines = Square(random);
  lines.textures = {RandomTexture(random, 16, 1)};
  for (const std::array<double, 4>& u :
       {std::array<double, 4>{0.5, 0.1, 0, 0}, {0, 0.31, 0, 0.2}}) {
    lines.coordinates = {{u, {0, 0, 0, 0.5}}};
    Scene plane = lines;
    plane.coordinates[0].v = {0.3, -0.2, 0, 0.1};
    for (Scene* scene : {&lines, &plane}) {
      scene->materials[0].reflectance_map.transform = {1, 0, 0, 0, 1, 0};
      scene->materials[0].exitance_map = {};
    }
    const SurfaceMaps of_lines(lines), of_plane(plane);
    const Surface surface = MakeSurfaces(plane)[0];
    const ConvexPolygon whole = SideGeometry(lines, 0, Side::kFront);
    for (const uint64_t element : {1, 2, 3, 9, 77, 1234}) {
      const ConvexPolygon part = ElementGeometry(whole, element);
      const Optics found = of_lines.Over(surface, part), expected = of_plane.Over(surface, part);
      EXPECT_LT(glm::length(found.reflectance - expected.reflectance), 1e-7) << element;
      EXPECT_LT(glm::length(found.reflectance_deviation - expected.reflectance_deviation), 1e-5);
    }
    EXPECT_GT(of_lines.Over(surface, whole).reflectance_deviation.x, 0.01);
  }
}

TEST(SurfaceMaps, TravelWithTheScene) {
  Random random(7);
  const Scene scene = Square(random);
  ASSERT_TRUE(Validate(scene).ok()) << Validate(scene).message();
  const std::string bytes = Encode(scene);
  const Result<Scene> back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(Encode(*back), bytes);
  EXPECT_EQ(back->textures[0].texels, scene.textures[0].texels);
  EXPECT_EQ(back->polygons[0].coordinates, 0U);
  Scene even = scene;
  even.textures.clear();
  even.materials[0].reflectance_map = even.materials[0].exitance_map = {};
  even.coordinates.clear();
  even.polygons[0].coordinates = kNoCoordinates;
  EXPECT_LT(Encode(even).size() + 4 * scene.textures[0].texels.size(), bytes.size());
  int decoded = 0;
  for (uint64_t seed = 1; seed <= 3000; ++seed) {
    Random damage(Mix(seed));
    std::string damaged = bytes;
    const size_t at = Encode(even).size() + damage.Bits() % (bytes.size() - Encode(even).size());
    if (seed % 4 == 0) damaged.resize(at);
    if (seed % 4 != 0) damaged[at] = static_cast<char>(damage.Bits());
    const Result<Scene> result = Decode(damaged);
    if (!result.has_value()) continue;
    ++decoded;
    const SurfaceMaps maps(*result);  // whatever it says, it can be used
    for (const Surface& s : MakeSurfaces(*result)) {
      maps.Over(s, SideGeometry(*result, 0, s.side));
    }
  }
  EXPECT_GT(decoded, 100);
  EXPECT_LT(decoded, 2900);
}

TEST(SurfaceMaps, ValidateRefusesWhatTheyCannotBe) {
  Random random(8);
  const Scene good = Square(random);
  const auto message = [](const Scene& scene) { return Validate(scene).message(); };
  Scene scene = good;
  scene.materials[0].reflectance.x = 0.999;
  scene.textures[0].texels[0] = 1.5F;
  EXPECT_NE(message(scene).find("reaches a reflectance of 1"), std::string::npos) << message(scene);
  scene = good;
  scene.textures[0].texels[5] = -1;
  EXPECT_NE(message(scene).find("texture 0: texel"), std::string::npos);
  scene.textures[0].texels.pop_back();
  EXPECT_NE(message(scene).find("16 x 9 texels with 431 values"), std::string::npos);
  scene = good;
  scene.materials[0].exitance_map.texture = 1;
  EXPECT_NE(message(scene).find("no texture 1"), std::string::npos);
  scene = good;
  scene.polygons[0].coordinates = 3;
  EXPECT_NE(message(scene).find("no texture coordinates 3"), std::string::npos);
}

}  // namespace
}  // namespace isolux
