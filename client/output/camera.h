// Where a picture is taken from: camera.json, or a guess from the patch file.
#pragma once

#include <string>

#include "client/output/patch_scene.h"

namespace isolux {

// Pinhole; lengths in the scene file's unit. In JSON: {"eye": [x,y,z], "target": [x,y,z],
// "up": [x,y,z], "fov_y_deg": degrees, "width": pixels, "height": pixels}; eye and target must be
// given, "note" is ignored.
struct Camera {
  static constexpr int kMostPixelsASide = 32768;

  Vec3 eye{0.0}, target{0.0, 0.0, -1.0}, up{0.0, 1.0, 0.0};
  double fov_y_deg = 60;  // whole angle of the picture's height
  int width = 1280, height = 960;

  // Direction (not normalised) through a place on the picture: (0, 0) the upper left corner,
  // (width, height) the lower right one.
  Vec3 Direction(double x, double y) const;
};

// Errors name the file, the line or key, and what is wanted.
Result<Camera> ParseCamera(const std::string& json, const std::string& name);
Result<Camera> ReadCamera(const std::string& path);

// A sensible view: from outside through the open side of a room that has one; otherwise from the
// place inside, at eye height, that sees the most. `up`: 1 for y, 2 for z, 0 to guess from lamps
// and shape (y where these do not say).
Camera GuessCamera(const PatchScene& scene, int up = 0);

}  // namespace isolux
