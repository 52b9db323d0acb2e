// The canonical scene: what the client's importer makes, what travels, and all that the solver
// knows. Polygons are triangles or convex planar quads; everything is in metres and linear light.
//
// A polygon has two sides. A side that takes part or emits (SideFlags) is a Surface. Every polygon
// blocks light from both sides, whichever take part.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/bands.h"
#include "common/scene/glazing.h"
#include "common/scene/light.h"
#include "common/scene/medium.h"
#include "common/scene/reradiation.h"
#include "common/scene/sky.h"
#include "common/scene/texture.h"
#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

inline constexpr uint32_t kNoVertex = 0xffffffffu;

enum class Side : uint8_t { kFront = 0, kBack = 1 };  // front: seen counter-clockwise

// What a lobe between diffuse and mirror reflects, of what arrives. It is not simulated: bounds on
// what that costs rest on it.
struct Gloss {
  Rgb share{0.0};
  bool kept = false;  // the diffuse reflectance holds it; else it is absorbed

  bool exists() const { return share != Rgb(0.0); }
  bool operator==(const Gloss&) const = default;
};

struct Material {
  std::string name;
  Rgb reflectance{0.0};  // diffuse, linear, in [0, 1)
  Rgb exitance{0.0};     // self-emitted, W/m² = π times the radiance of the file
  double specular = 0;   // share that is reflected as by a mirror; with the reflectance at most 1
  // Diffuse, of what arrives on either side: the share that comes out on the other (where both
  // sides take part; see translucency.h). With reflectance and specular share below 1.
  Rgb transmittance{0.0};
  Reradiation reradiation{};  // fluorescence; with all of these below 1 in each channel
  Gloss gloss{};              // with all of these at most 1 in each channel
  Spectrum spectrum{};        // what of these is known band by band
  // How these vary over polygons that have texture coordinates; without, they are the means.
  TextureUse reflectance_map{}, exitance_map{};
};

// How a side of a polygon takes part: a set of flags a polygon.
enum SideFlags : uint8_t {
  kFrontTakesPart = 1,  // has irradiance, reflects with the material's reflectance
  kBackTakesPart = 2,
  kFrontEmits = 4,  // radiates the material's exitance; implies that the side takes part
  kBackEmits = 8,
  // Lies wholly against another polygon: does not take part, and what arrives is the other's.
  kFrontCovered = 16,
  kBackCovered = 32,
};

struct Polygon {
  // Counter-clockwise from the front; a triangle has kNoVertex in the last place.
  std::array<uint32_t, 4> vertices{kNoVertex, kNoVertex, kNoVertex, kNoVertex};
  uint32_t material = 0;
  uint32_t file_polygon = 0;  // number in the file, from 0; the lowest where several were merged
  uint8_t sides = kFrontTakesPart | kBackTakesPart;
  uint32_t coordinates = kNoCoordinates;  // in Scene::coordinates

  int vertex_count() const { return vertices[3] == kNoVertex ? 3 : 4; }
};

// What the importer mended; shown by `inspect`, kept with the job.
struct RepairReport {
  struct Entry {
    std::string kind;  // for instance "zero-area faces dropped"
    uint64_t count = 0;
    std::string example;  // "room.obj:17", or empty
  };
  std::vector<Entry> entries;
};

struct Scene {
  std::vector<Vec3> vertices;  // metres, relative to `origin_m`
  std::vector<Polygon> polygons;
  std::vector<Material> materials;
  std::vector<Band> bands;  // spectral ones; without, light has its three channels alone
  std::vector<Texture> textures;
  std::vector<TextureCoordinates> coordinates;
  std::vector<Photometry> photometries;  // of photometric lights
  std::vector<Light> lights;             // beside the polygons that emit
  Sky sky;                               // where one exists
  Medium medium;                         // likewise; fills the whole scene
  Glazing glazing;                       // panes of clear glass, which are no polygons
  Vec3 origin_m{0.0};      // centre that was subtracted, in double, before anything else
  std::string unit = "m";  // of the file: m, cm, mm, in, ft
  double metres_per_unit = 1.0;
  uint32_t file_polygon_count = 0;  // polygons in the file, dropped ones included
  RepairReport repairs;
};

// One side of one polygon, as the solver sees it.
struct Surface {
  uint32_t polygon = 0;
  Side side = Side::kFront;
  Rgb reflectance{0.0};  // where a map varies it: the mean
  Rgb exitance{0.0};     // W/m², likewise; 0 on a side that does not emit
};

// A triangle or convex quad by value, counter-clockwise about its normal.
struct ConvexPolygon {
  int count = 0;                     // 3 or 4
  bool divided_from_behind = false;  // back of a translucent sheet: Subdivide (hierarchy/element.h)
  std::array<Vec3, 4> v{};

  ConvexPolygon() = default;
  constexpr ConvexPolygon(int corner_count, const std::array<Vec3, 4>& corners)
      : count(corner_count), v(corners) {}

  // Area vector: along the normal, as long as the area (Newell).
  Vec3 AreaVector() const;
  double Area() const { return glm::length(AreaVector()); }
  Vec3 Normal() const { return glm::normalize(AreaVector()); }
  Vec3 Centroid() const;  // of the area, not of the corners
};

// What the solver asks of a polygon's shape. Quads in files printed with six digits are off their
// plane, and straight corners off their line, by up to 3e-5; what is really bent is so by 1e-3 or
// more.
inline constexpr double kNoArea = 1e-12;          // area over squared longest side
inline constexpr double kPlanarTolerance = 5e-5;  // of a corner from the plane, over the diagonal
inline constexpr double kConvexTolerance = 5e-5;  // sine by which a corner may turn the wrong way
bool HasArea(const ConvexPolygon& polygon);
bool IsPlanar(const ConvexPolygon& polygon);
bool IsConvex(const ConvexPolygon& polygon);  // a corner may be straight

// Whether a side of any polygon radiates, or any light, or the sky.
bool Emits(const Scene& scene);

// The surfaces of a scene in order: by polygon, front before back, only sides that take part.
// A surface's number is its place here.
std::vector<Surface> MakeSurfaces(const Scene& scene);

// A side's polygon; that of the back has the order of its corners reversed.
ConvexPolygon SideGeometry(const Scene& scene, uint32_t polygon, Side side);
ConvexPolygon ShapeOf(const Pane& pane);
// Of a polygon's front, or of a pane; panes are numbered after all polygons.
ConvexPolygon ShapeOf(const Scene& scene, uint32_t number);

struct SceneLimits {
  uint64_t polygons = 5'000'000;
  uint64_t vertices = 20'000'000;
  uint64_t materials = 65'536;
  uint64_t lights = 16'384;
  uint64_t photometries = 1024;
  uint64_t bytes = 1ULL << 30;  // of the encoded scene
};

// Whether the solver can take the scene: indices in range, coordinates finite, polygons planar,
// convex and of some area, reflectance in [0, 1), exitance finite and not negative, something
// emits. The message names the polygon (by its number in the file) or material, and the remedy.
Status Validate(const Scene& scene, const SceneLimits& limits = {});

// The scene as bytes (little-endian, versioned; not the repair report) and back. The encoding is
// canonical: equal scenes have equal bytes.
std::string Encode(const Scene& scene);
Result<Scene> Decode(const std::string& bytes, const SceneLimits& limits = {});

// 32 hexadecimal digits: XXH3-128 of Encode(scene).
std::string HashOf(const std::string& encoded_scene);

}  // namespace isolux
