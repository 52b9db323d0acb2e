#include "tests/support/scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/util/random.h"

namespace isolux::testing {
namespace {

constexpr double kMetresPerMillimetre = 1e-3;

// Adds polygons with corners and materials of their own.
class SceneBuilder {
 public:
  uint32_t AddMaterial(const std::string& name, const Rgb& reflectance, const Rgb& exitance) {
    scene_.materials.push_back({name, reflectance, exitance});
    return static_cast<uint32_t>(scene_.materials.size() - 1);
  }

  void Add(const std::vector<Vec3>& corners, uint32_t material, uint8_t sides) {
    Polygon polygon;
    for (size_t i = 0; i < corners.size(); ++i) polygon.vertices[i] = Vertex(corners[i]);
    polygon.material = material;
    polygon.file_polygon = scene_.file_polygon_count++;
    polygon.sides = sides;
    scene_.polygons.push_back(polygon);
  }

  Scene Take() { return std::move(scene_); }

 private:
  uint32_t Vertex(const Vec3& point) {
    auto& vertices = scene_.vertices;
    const auto number = std::find(vertices.begin(), vertices.end(), point) - vertices.begin();
    if (number == std::ssize(vertices)) vertices.push_back(point);
    return static_cast<uint32_t>(number);
  }

  Scene scene_;
};

// The six quads of a box from `low` to `high`, fronts inwards: x low, x high, y low, ...
std::array<std::vector<Vec3>, 6> BoxInside(const Vec3& a, const Vec3& b) {
  return {{{{a.x, a.y, a.z}, {a.x, b.y, a.z}, {a.x, b.y, b.z}, {a.x, a.y, b.z}},
           {{b.x, a.y, a.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}, {b.x, b.y, a.z}},
           {{a.x, a.y, a.z}, {a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, a.y, a.z}},
           {{a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z}},
           {{a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, b.y, a.z}, {a.x, b.y, a.z}},
           {{a.x, a.y, b.z}, {a.x, b.y, b.z}, {b.x, b.y, b.z}, {b.x, a.y, b.z}}}};
}

struct Placed {
  Vec3 centre;
  double radius = 0;  // of the circle about the box, seen from above
};

// A place on the floor where no box stands yet; the box shrinks until one is found.
Placed FindPlace(Random& random, const Vec3& room, const std::vector<Placed>& others) {
  double radius = 0.25 * std::min(room.x, room.y) * (0.4 + 0.6 * random.Unit());
  for (int tries = 0;; ++tries) {
    if (tries % 16 == 15) radius *= 0.8;
    const Vec3 centre(radius + random.Unit() * (room.x - 2 * radius),
                      radius + random.Unit() * (room.y - 2 * radius), 0.0);
    const bool is_free = std::none_of(others.begin(), others.end(), [&](const Placed& other) {
      return glm::length(other.centre - centre) < 1.02 * (other.radius + radius);
    });
    if (is_free) return {centre, 0.98 * radius};
  }
}

// A box turned about the vertical, fronts outwards; standing on the floor it has no bottom.
void AddBlock(SceneBuilder& builder, Random& random, const Placed& place, double room_height,
              uint32_t material) {
  const double angle = 0.5 * std::numbers::pi * random.Unit();
  const double share = std::numbers::pi * (0.15 + 0.2 * random.Unit());
  const Vec3 half(place.radius * std::cos(share), place.radius * std::sin(share), 0.0);
  const bool floats = random.Unit() < 0.4;
  const double low = floats ? room_height * (0.1 + 0.3 * random.Unit()) : 0.0;
  const double high = low + room_height * (0.1 + 0.35 * random.Unit());
  const auto turned = [&](const Vec3& p) {
    return place.centre + Vec3(std::cos(angle) * p.x - std::sin(angle) * p.y,
                               std::sin(angle) * p.x + std::cos(angle) * p.y, p.z);
  };
  const auto faces = BoxInside({-half.x, -half.y, low}, {half.x, half.y, high});
  for (int f = 0; f < 6; ++f) {
    if (f == 4 && !floats) continue;
    std::vector<Vec3> corners;
    for (int i = 3; i >= 0; --i) corners.push_back(turned(faces[f][i]));
    builder.Add(corners, material, kFrontTakesPart);
  }
}

struct CornellQuad {
  int material;  // index into the materials below
  std::vector<Vec3> corners_mm;
};

enum CornellMaterial { kWhite, kRed, kGreen, kLight };

// As measured and published by the Cornell Program of Computer Graphics. The left wall is not quite
// planar there, so it is two triangles; the ceiling goes round the light.
std::vector<CornellQuad> CornellQuads() {
  std::vector<CornellQuad> quads = {
      {kWhite, {{552.8, 0, 0}, {0, 0, 0}, {0, 0, 559.2}, {549.6, 0, 559.2}}},
      {kWhite, {{549.6, 0, 559.2}, {0, 0, 559.2}, {0, 548.8, 559.2}, {556, 548.8, 559.2}}},
      {kGreen, {{0, 0, 559.2}, {0, 0, 0}, {0, 548.8, 0}, {0, 548.8, 559.2}}},
      {kRed, {{552.8, 0, 0}, {549.6, 0, 559.2}, {556, 548.8, 559.2}}},
      {kRed, {{552.8, 0, 0}, {556, 548.8, 559.2}, {556, 548.8, 0}}},
  };
  const double xs[] = {556, 343, 213, 0};
  const double zs[] = {0, 227, 332, 559.2};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      quads.push_back({i == 1 && k == 1 ? kLight : kWhite,
                       {{xs[i], 548.8, zs[k]},
                        {xs[i], 548.8, zs[k + 1]},
                        {xs[i + 1], 548.8, zs[k + 1]},
                        {xs[i + 1], 548.8, zs[k]}}});
    }
  }
  const Vec3 short_block[] = {{130, 165, 65}, {82, 165, 225}, {240, 165, 272}, {290, 165, 114}};
  const Vec3 tall_block[] = {{423, 330, 247}, {265, 330, 296}, {314, 330, 456}, {472, 330, 406}};
  for (const auto& top : {short_block, tall_block}) {
    quads.push_back({kWhite, {top[0], top[1], top[2], top[3]}});
    for (int i = 0; i < 4; ++i) {
      const Vec3 a = top[i];
      const Vec3 b = top[(i + 1) % 4];
      quads.push_back({kWhite, {b, a, {a.x, 0, a.z}, {b.x, 0, b.z}}});
    }
  }
  return quads;
}

}  // namespace

Scene BoxRoom(const Vec3& size_m, const BoxFaces& faces) {
  SceneBuilder builder;
  const auto quads = BoxInside(Vec3(0.0), size_m);
  const char* names[] = {"x low", "x high", "y low", "y high", "z low", "z high"};
  for (int f = 0; f < 6; ++f) {
    const uint32_t material =
        builder.AddMaterial(names[f], faces.reflectance[f], faces.exitance[f]);
    const bool emits = Sum(faces.exitance[f]) > 0;
    builder.Add(quads[f], material, kFrontTakesPart | (emits ? kFrontEmits : 0));
  }
  return builder.Take();
}

Scene FurnaceCube(double reflectance, double exitance) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(reflectance));
  faces.exitance.fill(Rgb(exitance));
  return BoxRoom(Vec3(1.0), faces);
}

Scene RoomWithStrip(double before_wall_m, double height_m) {
  SceneBuilder builder;
  const uint32_t grey = builder.AddMaterial("grey", Rgb(0.6), Rgb(0.0));
  for (const auto& quad : BoxInside(Vec3(0.0), {4, 3, 3})) builder.Add(quad, grey, kFrontTakesPart);
  const double x = before_wall_m, low = 1, high = low + height_m;
  builder.Add({{x, 0.5, low}, {x, 0.5, high}, {x, 2.5, high}, {x, 2.5, low}},
              builder.AddMaterial("lamp", Rgb(0.0), Rgb(100.0)),
              kFrontTakesPart | kFrontEmits | kBackTakesPart);
  return builder.Take();
}

Scene CornellBox(bool both_sides) {
  SceneBuilder builder;
  builder.AddMaterial("white", {0.725, 0.71, 0.68}, Rgb(0.0));
  builder.AddMaterial("red", {0.63, 0.065, 0.05}, Rgb(0.0));
  builder.AddMaterial("green", {0.14, 0.45, 0.091}, Rgb(0.0));
  builder.AddMaterial("light", Rgb(0.78), std::numbers::pi * Rgb(17, 12, 4));
  const uint8_t sides = both_sides ? kFrontTakesPart | kBackTakesPart : kFrontTakesPart;
  for (const CornellQuad& quad : CornellQuads()) {
    std::vector<Vec3> corners;
    for (const Vec3& corner : quad.corners_mm) corners.push_back(kMetresPerMillimetre * corner);
    builder.Add(corners, quad.material, sides | (quad.material == kLight ? kFrontEmits : 0));
  }
  Scene scene = builder.Take();
  scene.unit = "mm";
  scene.metres_per_unit = kMetresPerMillimetre;
  return scene;
}

Scene RandomRoom(uint64_t seed, int blocks) {
  SceneBuilder builder;
  Random random(Mix(seed));
  const auto random_colour = [&](double low, double high) {
    const auto channel = [&] { return low + (high - low) * random.Unit(); };
    const double r = channel();
    const double g = channel();
    return Rgb(r, g, channel());
  };
  const double x = 3 + 5 * random.Unit();
  const double y = 3 + 5 * random.Unit();
  const Vec3 room(x, y, 2.2 + 1.5 * random.Unit());
  for (const auto& wall : BoxInside(Vec3(0.0), room)) {
    builder.Add(wall, builder.AddMaterial("wall", random_colour(0.2, 0.8), Rgb(0.0)),
                kFrontTakesPart);
  }
  std::vector<Placed> placed;
  for (int b = 0; b < blocks; ++b) {
    placed.push_back(FindPlace(random, room, placed));
    const uint32_t material = builder.AddMaterial("block", random_colour(0.0, 0.8), Rgb(0.0));
    AddBlock(builder, random, placed.back(), room.z, material);
  }
  // Lamps hang below the ceiling, above everything else, each in its own half of the room.
  const int lamps = random.Unit() < 0.5 ? 1 : 2;
  for (int l = 0; l < lamps; ++l) {
    const double half = 0.1 + 0.3 * random.Unit();
    const Vec3 centre(room.x * (l + 0.3 + 0.4 * random.Unit()) / lamps,
                      room.y * (0.3 + 0.4 * random.Unit()), room.z * 0.95);
    const uint32_t material =
        builder.AddMaterial("lamp", Rgb(0.5), random_colour(20, 100) / (half * half));
    builder.Add({centre + Vec3(-half, -half, 0), centre + Vec3(-half, half, 0),
                 centre + Vec3(half, half, 0), centre + Vec3(half, -half, 0)},
                material, kFrontTakesPart | kBackTakesPart | kFrontEmits);
  }
  return builder.Take();
}

}  // namespace isolux::testing
