// The patch file: a binary little-endian PLY that opens in any mesh viewer and holds the physics.
// docs/patch-file.md draws the format.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/bands.h"
#include "common/scene/solve_options.h"
#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

// Shared only between coplanar neighbours of one material. Coordinates are in the scene file's
// unit.
struct PatchVertex {
  Vec3 position{0.0};
  std::array<float, 3> radiosity{};   // W/m², gathered
  std::array<float, 3> irradiance{};  // W/m², gathered
};

struct PatchFace {
  std::vector<uint32_t> vertices;  // counter-clockwise from the lit side; T-vertices included
  std::array<float, 3> radiosity{}, irradiance{}, emission{};  // area means, W/m²
  float error = 0;       // estimated absolute error of the irradiance, worst channel, W/m²
  uint32_t polygon = 0;  // lowest file polygon
  uint32_t surface = 0;
  uint8_t side = 0;   // 0 front, 1 back
  uint64_t path = 1;  // of the element on its surface
};

// What spectral bands bring to vertices or faces, one after the other, W/m²: of each the
// radiosities of all bands, then the irradiances.
struct BandValues {
  std::vector<float> values;

  std::span<const float> Radiosity(size_t item, size_t bands) const {
    return std::span(values).subspan(2 * bands * item, bands);
  }
  std::span<const float> Irradiance(size_t item, size_t bands) const {
    return std::span(values).subspan(2 * bands * item + bands, bands);
  }
};

struct PatchFile {
  // `comment isolux KEY VALUE`, in order; the only part in which two runs with the same thresholds
  // may differ.
  std::vector<std::pair<std::string, std::string>> comments;
  std::vector<PatchVertex> vertices;
  std::vector<PatchFace> faces;
  // Where light has spectral bands; then what vertices and faces have in red, green and blue are
  // their sums.
  std::vector<Band> bands;
  BandValues vertex_bands, face_bands;

  // Value of a comment, or empty.
  std::string Comment(const std::string& key) const;
};

std::string Encode(const PatchFile& file);
// `name` stands in messages. Accepts what Encode writes (and reads only that); damaged input gives
// a Status that says where.
Result<PatchFile> DecodePatchFile(const std::string& bytes, const std::string& name);

// Writes to a temporary name in the same folder, then renames.
Status WritePatchFile(const PatchFile& file, const std::string& path);
Result<PatchFile> ReadPatchFile(const std::string& path);

}  // namespace isolux
