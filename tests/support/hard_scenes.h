// Scenes that are hard in one respect each, built in code, and the same scene told in another way.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/patch_file.h"
#include "common/scene/scene.h"

namespace isolux::testing {

inline constexpr uint8_t kBothTakePart = kFrontTakesPart | kBackTakesPart;

// Puts scenes together from quads and boxes; metres.
class SceneSketch {
 public:
  SceneSketch() = default;
  explicit SceneSketch(Scene begun) : scene_(std::move(begun)) {}

  // Grey; exitance in W/m².
  uint32_t Material(const std::string& name, double reflectance, double exitance = 0);

  // Each polygon has corners and a number in the file of its own.
  void Polygon(const std::vector<Vec3>& corners, uint32_t material, uint8_t sides);
  // An axis-aligned rectangle at `at` along `axis`, seen from above (along −axis) or below.
  void Rectangle(int axis, double at, const std::array<double, 2>& low,
                 const std::array<double, 2>& high, bool seen_from_above, uint32_t material,
                 uint8_t sides);
  // The six walls of a box seen from inside or outside.
  void Box(const Vec3& low, const Vec3& high, bool from_inside, uint32_t material, uint8_t sides);
  // A wall with a square hole about its middle, of four rectangles.
  void WallWithHole(int axis, double at, const std::array<double, 2>& low,
                    const std::array<double, 2>& high, const std::array<double, 2>& hole_middle,
                    double hole_size, uint32_t material, uint8_t sides);

  Scene Take() { return std::move(scene_); }

 private:
  Scene scene_;
};

// Power that arrives at faces of polygons from `first` on, W, in the first channel.
double ArrivingAt(const PatchFile& patch, uint32_t first);

// A closed room 4 × 3 × 2.5 with a lamp under its ceiling and two boxes on its floor.
Scene FurnishedRoom();
// The Cornell box with both blocks, closed in front.
Scene ClosedCornellBox();
// Closed rooms that are not convex, all of whose walls emit: with an L for its floor (2 × 2 without
// a quarter), and with a column from floor to ceiling.
Scene LRoom();
Scene ColumnRoom();
// A closed room with a random few of: boxes, screens, lamps; random colours. Small.
Scene RandomClosedRoom(uint64_t seed);

// Emission that lights everything alike whatever stands where: E = 1 − ρ, on every side that takes
// part, with random reflectances up to `most`. Everything then radiates 1.
Scene Kirchhoff(Scene scene, double most, uint64_t seed);

// ---- the same scene, told in another way
Scene Scaled(Scene scene, double factor);
// Turned about the origin; back: the other way.
Vec3 Turned(const Vec3& point, uint64_t seed, bool back = false);
Scene Turned(Scene scene, uint64_t seed);
Scene Flipped(Scene scene);                  // every polygon the other way round; so are its sides
Scene Shuffled(Scene scene, uint64_t seed);  // the order of polygons and where they begin
Scene Retriangulated(Scene scene, uint64_t seed);  // quads as two triangles, along either diagonal
// As an OBJ file, each face `copies` times.
std::string AsObj(const Scene& scene, int copies);

}  // namespace isolux::testing
