#include "tests/support/hard_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/check.h"
#include "common/util/random.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

uint8_t SidesSwapped(uint8_t sides) {
  uint8_t swapped = 0;
  if ((sides & kFrontTakesPart) != 0) swapped |= kBackTakesPart;
  if ((sides & kBackTakesPart) != 0) swapped |= kFrontTakesPart;
  if ((sides & kFrontEmits) != 0) swapped |= kBackEmits;
  if ((sides & kBackEmits) != 0) swapped |= kFrontEmits;
  return swapped;
}

uint8_t Emitting(uint8_t sides) {
  if ((sides & kFrontTakesPart) != 0) sides |= kFrontEmits;
  if ((sides & kBackTakesPart) != 0) sides |= kBackEmits;
  return sides;
}

}  // namespace

uint32_t SceneSketch::Material(const std::string& name, double reflectance, double exitance) {
  scene_.materials.push_back({name, Rgb(reflectance), Rgb(exitance)});
  return static_cast<uint32_t>(scene_.materials.size() - 1);
}

void SceneSketch::Polygon(const std::vector<Vec3>& corners, uint32_t material, uint8_t sides) {
  isolux::Polygon polygon;
  for (size_t i = 0; i < corners.size(); ++i) {
    polygon.vertices[i] = static_cast<uint32_t>(scene_.vertices.size());
    scene_.vertices.push_back(corners[i]);
  }
  polygon.material = material;
  polygon.file_polygon = scene_.file_polygon_count++;
  polygon.sides = sides;
  scene_.polygons.push_back(polygon);
}

void SceneSketch::Rectangle(int axis, double at, const std::array<double, 2>& low,
                            const std::array<double, 2>& high, bool seen_from_above,
                            uint32_t material, uint8_t sides) {
  const int s = (axis + 1) % 3, t = (axis + 2) % 3;  // s × t points along the axis
  const auto corner = [&](double u, double v) {
    Vec3 p(0.0);
    p[axis] = at;
    p[s] = u;
    p[t] = v;
    return p;
  };
  std::vector<Vec3> corners = {corner(low[0], low[1]), corner(high[0], low[1]),
                               corner(high[0], high[1]), corner(low[0], high[1])};
  if (!seen_from_above) std::reverse(corners.begin(), corners.end());
  Polygon(corners, material, sides);
}

void SceneSketch::Box(const Vec3& low, const Vec3& high, bool from_inside, uint32_t material,
                      uint8_t sides) {
  for (int axis = 0; axis < 3; ++axis) {
    const int s = (axis + 1) % 3, t = (axis + 2) % 3;
    for (const bool upper : {false, true}) {
      Rectangle(axis, upper ? high[axis] : low[axis], {low[s], low[t]}, {high[s], high[t]},
                upper != from_inside, material, sides);
    }
  }
}

void SceneSketch::WallWithHole(int axis, double at, const std::array<double, 2>& low,
                               const std::array<double, 2>& high,
                               const std::array<double, 2>& hole_middle, double hole_size,
                               uint32_t material, uint8_t sides) {
  const double r = 0.5 * hole_size;
  const std::array<double, 2> a = {hole_middle[0] - r, hole_middle[1] - r};
  const std::array<double, 2> b = {hole_middle[0] + r, hole_middle[1] + r};
  Rectangle(axis, at, low, {a[0], high[1]}, true, material, sides);
  Rectangle(axis, at, {b[0], low[1]}, high, true, material, sides);
  Rectangle(axis, at, {a[0], low[1]}, {b[0], a[1]}, true, material, sides);
  Rectangle(axis, at, {a[0], b[1]}, {b[0], high[1]}, true, material, sides);
}

Scene FurnishedRoom() {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.7), floor = sketch.Material("floor", 0.3),
                 box = sketch.Material("box", 0.5), lamp = sketch.Material("lamp", 0.5, 100);
  sketch.Box({0, 0, 0}, {4, 3, 2.5}, true, wall, kFrontTakesPart);
  sketch.Rectangle(2, 2.3, {1.5, 1.2}, {2.5, 1.8}, false, lamp, kBothTakePart | kFrontEmits);
  sketch.Box({0.5, 0.5, 0.3}, {1.3, 1.4, 0.9}, false, box, kFrontTakesPart);
  sketch.Box({2.6, 1.5, 0.2}, {3.5, 2.4, 1.6}, false, floor, kFrontTakesPart);
  return sketch.Take();
}

Scene ClosedCornellBox() {
  Scene scene = CornellBox(false);
  const Vec3 corners[] = {{552.8, 0, 0}, {556, 548.8, 0}, {0, 548.8, 0}, {0, 0, 0}};
  Polygon front;
  for (int i = 0; i < 4; ++i) {
    const Vec3 corner = 1e-3 * corners[i];
    const auto found = std::find(scene.vertices.begin(), scene.vertices.end(), corner);
    CHECK(found != scene.vertices.end());
    front.vertices[i] = static_cast<uint32_t>(found - scene.vertices.begin());
  }
  front.file_polygon = scene.file_polygon_count++;
  front.sides = kFrontTakesPart;
  scene.polygons.push_back(front);
  return scene;
}

Scene LRoom() {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.5, 1);
  constexpr uint8_t kSides = kFrontTakesPart | kFrontEmits;
  for (const bool upper : {false, true}) {
    for (const auto& [x, y] : {std::pair(0, 0), std::pair(1, 0), std::pair(0, 1)}) {
      sketch.Rectangle(2, upper ? 1 : 0, {1.0 * x, 1.0 * y}, {x + 1.0, y + 1.0}, !upper, wall,
                       kSides);
    }
  }
  sketch.Rectangle(0, 0, {0, 0}, {2, 1}, true, wall, kSides);
  sketch.Rectangle(0, 2, {0, 0}, {1, 1}, false, wall, kSides);
  sketch.Rectangle(0, 1, {1, 0}, {2, 1}, false, wall, kSides);
  sketch.Rectangle(1, 0, {0, 0}, {1, 2}, true, wall, kSides);
  sketch.Rectangle(1, 2, {0, 0}, {1, 1}, false, wall, kSides);
  sketch.Rectangle(1, 1, {0, 1}, {1, 2}, false, wall, kSides);
  return sketch.Take();
}

Scene ColumnRoom() {
  SceneSketch sketch;
  const uint32_t wall = sketch.Material("wall", 0.5, 1);
  constexpr uint8_t kSides = kFrontTakesPart | kFrontEmits;
  constexpr uint8_t kBack = kBackTakesPart | kBackEmits;
  sketch.WallWithHole(2, 0, {0, 0}, {1, 1}, {0.5, 0.5}, 0.2, wall, kSides);
  sketch.WallWithHole(2, 1, {0, 0}, {1, 1}, {0.5, 0.5}, 0.2, wall, kBack);
  for (int axis = 0; axis < 2; ++axis) {
    for (const bool upper : {false, true}) {
      sketch.Rectangle(axis, upper ? 1 : 0, {0, 0}, {1, 1}, !upper, wall, kSides);
      const std::array<double, 2> low = axis == 0 ? std::array{0.4, 0.0} : std::array{0.0, 0.4};
      const std::array<double, 2> high = axis == 0 ? std::array{0.6, 1.0} : std::array{1.0, 0.6};
      sketch.Rectangle(axis, upper ? 0.6 : 0.4, low, high, upper, wall, kSides);
    }
  }
  return sketch.Take();
}

Scene RandomClosedRoom(uint64_t seed) {
  Random random(Mix(seed ^ 0xc105edu));
  const auto unit = [&] { return random.Unit(); };
  SceneSketch sketch;
  const Vec3 size(1 + 4 * unit(), 1 + 4 * unit(), 1 + 2 * unit());
  sketch.Box(Vec3(0.0), size, true, sketch.Material("wall", 0.95 * unit()), kFrontTakesPart);
  const int things = static_cast<int>(4 * unit());
  for (int k = 0; k < things; ++k) {
    // Each in its own slice of the room, clear of everything else.
    const double from = size.x * (k + 0.1 + 0.3 * unit()) / things;
    const double to = size.x * (k + 0.6 + 0.3 * unit()) / things;
    const Vec3 low(from, size.y * (0.05 + 0.3 * unit()), size.z * (0.05 + 0.3 * unit()));
    const Vec3 high(to, size.y * (0.5 + 0.3 * unit()), size.z * (0.5 + 0.2 * unit()));
    const uint32_t material = sketch.Material("thing", 0.95 * unit());
    if (unit() < 0.5) {
      sketch.Box(low, high, false, material, kFrontTakesPart);
    } else {
      const int axis = static_cast<int>(3 * unit()), s = (axis + 1) % 3, t = (axis + 2) % 3;
      sketch.Rectangle(axis, 0.5 * (low[axis] + high[axis]), {low[s], low[t]}, {high[s], high[t]},
                       true, material, kBothTakePart);
    }
  }
  const double reach = 0.02 + 0.2 * unit();
  sketch.Rectangle(2, 0.9 * size.z, {size.x * (0.5 - reach), size.y * (0.5 - reach)},
                   {size.x * (0.5 + reach), size.y * (0.5 + reach)}, false,
                   sketch.Material("lamp", 0.9 * unit(), std::exp2(20 * unit() - 10)),
                   kBothTakePart | kFrontEmits);
  Scene scene = sketch.Take();
  for (Material& material : scene.materials) {
    for (int c = 0; c < 3; ++c) material.reflectance[c] *= 1 - 0.5 * unit();
    for (int c = 0; c < 3; ++c) material.exitance[c] *= 1 - 0.5 * unit();
  }
  return scene;
}

Scene Kirchhoff(Scene scene, double most, uint64_t seed) {
  Random random(Mix(seed));
  scene.materials.clear();
  for (Polygon& polygon : scene.polygons) {
    const auto draw = [&] { return most * random.Unit(); };
    const double r = draw(), g = draw();
    const Rgb rho(r, g, draw());
    polygon.material = static_cast<uint32_t>(scene.materials.size());
    polygon.sides = Emitting(polygon.sides);
    scene.materials.push_back({fmt::format("{}", polygon.material), rho, Rgb(1.0) - rho});
  }
  return scene;
}

Scene Scaled(Scene scene, double factor) {
  for (Vec3& vertex : scene.vertices) vertex *= factor;
  return scene;
}

Vec3 Turned(const Vec3& point, uint64_t seed, bool back) {
  Random random(Mix(seed));
  const auto draw = [&] { return 2 * random.Unit() - 1; };
  const double x = draw(), y = draw(), z = draw();
  const Vec3 third = glm::normalize(Vec3(x, y, z));
  const Vec3 first = glm::normalize(glm::cross(third, Vec3(0.3, -0.2, 0.9)));
  const Vec3 second = glm::cross(third, first);
  if (back) return point.x * first + point.y * second + point.z * third;
  return {glm::dot(first, point), glm::dot(second, point), glm::dot(third, point)};
}

Scene Turned(Scene scene, uint64_t seed) {
  for (Vec3& vertex : scene.vertices) vertex = Turned(vertex, seed);
  return scene;
}

Scene Flipped(Scene scene) {
  for (Polygon& polygon : scene.polygons) {
    std::reverse(polygon.vertices.begin(), polygon.vertices.begin() + polygon.vertex_count());
    polygon.sides = SidesSwapped(polygon.sides);
  }
  return scene;
}

Scene Shuffled(Scene scene, uint64_t seed) {
  Random random(Mix(seed));
  auto& polygons = scene.polygons;
  for (size_t i = polygons.size(); i > 1; --i)
    std::swap(polygons[i - 1], polygons[static_cast<size_t>(random.Unit() * i)]);
  for (Polygon& polygon : polygons) {
    const int turn = static_cast<int>(random.Unit() * polygon.vertex_count());
    std::rotate(polygon.vertices.begin(), polygon.vertices.begin() + turn,
                polygon.vertices.begin() + polygon.vertex_count());
  }
  return scene;
}

Scene Retriangulated(Scene scene, uint64_t seed) {
  Random random(Mix(seed));
  std::vector<Polygon> triangles;
  for (const Polygon& polygon : scene.polygons) {
    if (polygon.vertex_count() == 3) {
      triangles.push_back(polygon);
      continue;
    }
    const int first = random.Unit() < 0.5 ? 0 : 1;
    for (const int k : {first, first + 2}) {
      Polygon triangle = polygon;
      triangle.vertices = {polygon.vertices[k % 4], polygon.vertices[(k + 1) % 4],
                           polygon.vertices[(k + 2) % 4], kNoVertex};
      triangles.push_back(triangle);
    }
  }
  scene.polygons = std::move(triangles);
  return scene;
}

std::string AsObj(const Scene& scene, int copies) {
  std::string text = "mtllib scene.mtl\n";
  for (const Vec3& v : scene.vertices) text += fmt::format("v {} {} {}\n", v.x, v.y, v.z);
  for (int copy = 0; copy < copies; ++copy) {
    for (const Polygon& polygon : scene.polygons) {
      text += fmt::format("usemtl m{}\nf", polygon.material);
      for (int i = 0; i < polygon.vertex_count(); ++i)
        text += fmt::format(" {}", polygon.vertices[i] + 1);
      text += "\n";
    }
  }
  return text;
}

double ArrivingAt(const PatchFile& patch, uint32_t first) {
  double sum = 0;
  for (const PatchFace& face : patch.faces) {
    if (face.polygon < first) continue;
    Vec3 area(0.0);
    for (size_t i = 0; i < face.vertices.size(); ++i) {
      area +=
          0.5 * glm::cross(patch.vertices[face.vertices[i]].position,
                           patch.vertices[face.vertices[(i + 1) % face.vertices.size()]].position);
    }
    sum += glm::length(area) * face.irradiance[0];
  }
  return sum;
}

}  // namespace isolux::testing
