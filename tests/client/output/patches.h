// Small patch files made by hand.
#pragma once

#include <vector>

#include "common/scene/patch_file.h"

namespace isolux::testing {

// A face with vertices of its own, all with the same radiosity and irradiance.
inline PatchFace& AddFace(PatchFile& file, const std::vector<Vec3>& corners, float radiosity,
                          float irradiance) {
  PatchFace face;
  face.polygon = face.surface = static_cast<uint32_t>(file.faces.size());
  face.radiosity.fill(radiosity);
  face.irradiance.fill(irradiance);
  for (const Vec3& corner : corners) {
    face.vertices.push_back(static_cast<uint32_t>(file.vertices.size()));
    file.vertices.push_back({corner, face.radiosity, face.irradiance});
  }
  file.faces.push_back(face);
  return file.faces.back();
}

// A room [0,6] × [0,2.5] × [0,3], faces inwards, without the wall at high z where `open`. Each wall
// has a radiosity of its own: 1 … 6.
inline PatchFile RoomPatches(bool open) {
  const Vec3 s(6, 2.5, 3);
  PatchFile file;
  const auto add = [&](std::vector<Vec3> corners) {
    for (Vec3& c : corners) c *= s;
    AddFace(file, corners, static_cast<float>(file.faces.size() + 1), 1);
  };
  add({{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}});
  add({{1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}});
  add({{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}});
  add({{0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}});
  add({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  if (!open) add({{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}});
  return file;
}

}  // namespace isolux::testing
