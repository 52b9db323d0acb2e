// What a scene file says, whatever its format: points, faces and materials as the file has them, in
// the file's unit, before anything is mended.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

inline constexpr uint32_t kNoMaterial = 0xffffffffu;
inline constexpr uint32_t kNoImage = 0xffffffffu;

// An image a material names: a file looked for beside the scene, or bytes inside it.
struct FileMap {
  std::string name;              // as messages show it; empty where there is no map
  std::string folder;            // where the file `name` is looked for
  uint32_t embedded = kNoImage;  // in SceneFile::images, which then holds the encoded image
  // From the file's texture coordinates (u, v, 1) to those of the image.
  std::array<double, 6> transform{1, 0, 0, 0, 1, 0};
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  int set = 0;  // which of the file's sets of texture coordinates
};

struct FileMaterial {
  std::string name;
  std::string where;                  // "room.mtl:17" or "room.glb: materials[2]"
  Rgb diffuse{0.0};                   // reflectance; 1 where only a map is given
  Rgb radiance{0.0};                  // W/(m² sr)
  FileMap diffuse_map, emission_map;  // colours, sRGB-encoded
  // Of a metallic-roughness material: its diffuse part is 1 less this, times the mean of the map's
  // blue channel (linear) where there is one.
  double metallic = 0;
  FileMap metallic_map;
  int coordinate_set() const {
    return diffuse_map.name.empty() ? emission_map.set : diffuse_map.set;
  }
  bool double_sided = false;  // both sides reflect, and emit where the material does
  bool opacity_map = false;
  bool mirror = false;
  Rgb specular{0.0};    // what a mirror reflects as such; of a metal, times `metallic` and the maps
  bool glossy = false;  // and no mirror
  // What a glossy material reflects by its lobe at most, beside what it does diffusely; a metal's
  // base colour counts as diffuse.
  Rgb lobe{0.0};
  bool glass = false;
  // Of glass: what its inside leaves of light that falls straight, times the mean of `diffuse_map`
  // where `tinted`; what it reflects diffusely beside; and its index of refraction, 1: no Fresnel.
  Rgb clear{0.0}, scattered{0.0};
  bool tinted = false;
  double index_of_refraction = 1;
  Rgb transmittance{0.0};     // diffuse: what of arriving light comes out on the other side
  Reradiation reradiation{};  // fluorescence
  bool sheet_maps = false;    // that would vary it
  bool unlit = false;         // shown without light by viewers
};

// Of isolux.json, by the name of the material.
struct FileSpectrum {
  std::string material, where;
  Spectrum spectrum;
};

struct FileFace {
  uint64_t first = 0;               // of its corners, in SceneFile::corners
  uint32_t count = 0;               // at least 3
  uint32_t place = 0;               // line of a text file, else number in SceneFile::parts
  uint32_t material = kNoMaterial;  // in SceneFile::materials
};

struct SceneFile {
  std::string path;
  std::vector<Vec3> points;
  std::vector<uint32_t> corners;  // numbers of points, from 0
  // Texture coordinates, v downwards; `corner_coordinates` has one for each corner, or
  // kNoCoordinates.
  // Of a glTF material they are of the set of its diffuse map, else of its emission map.
  std::vector<glm::dvec2> coordinates;
  std::vector<uint32_t> corner_coordinates;
  std::vector<FileFace> faces;  // in file order: a face's number is its place
  std::vector<FileMaterial> materials;
  std::vector<std::string> images;  // encoded (PNG, JPEG, …), of formats that hold them
  std::vector<std::string> parts;  // "nodes[3] 'lamp', meshes[1].primitives[0]"; none of text files

  std::vector<Photometry> photometries;
  std::vector<Light> lights;  // positions in the file's unit
  Sky sky;
  Medium medium;
  std::vector<Band> bands;  // spectral ones
  std::vector<FileSpectrum> spectra;

  // Libraries named but not found, where ("room.obj:3"); no face needs a material of theirs.
  std::vector<std::string> missing_libraries;
  // Materials whose name was taken already, where ("room.mtl:17"); the first counts.
  std::vector<std::string> repeated_materials;
  // What the file holds beside its surfaces, where.
  std::vector<std::string> cameras;
  std::vector<std::string> animated;  // animations, skins and morph targets
  std::vector<std::string> lines;     // meshes of points and lines, which have no area

  std::string Where(const FileFace& face) const {
    return parts.empty() ? fmt::format("{}:{}", path, face.place)
                         : fmt::format("{}: {}", path, parts[face.place]);
  }
};

}  // namespace isolux
