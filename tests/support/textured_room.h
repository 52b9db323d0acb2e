// A room whose chequers, mirror and sky call for effects that others do not have.
#pragma once

#include "tests/support/scenes.h"

namespace isolux::testing {

// A grey room with a chequered floor, a small mirror on a wall, and the sky where its ceiling is
// open.
inline Scene TexturedRoom() {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.5));
  Scene scene = BoxRoom({4, 3, 2.5}, faces);
  scene.polygons.erase(scene.polygons.begin() + 5);
  Texture chequers{2, 2, Wrap::kRepeat, Wrap::kRepeat, {}};
  for (const float texel : {1.5F, 0.5F, 0.5F, 1.5F}) {
    for (int c = 0; c < 3; ++c) chequers.texels.push_back(texel);
  }
  scene.textures = {chequers};
  scene.coordinates = {{{2, 0, 0, 0}, {0, 2, 0, 0}}};
  scene.materials[scene.polygons[4].material].reflectance_map.texture = 0;
  scene.polygons[4].coordinates = 0;
  Polygon mirror;
  mirror.vertices.fill(kNoVertex);
  for (const Vec3& v :
       {Vec3(0.02, 1, 1), Vec3(0.02, 1.2, 1), Vec3(0.02, 1.2, 1.2), Vec3(0.02, 1, 1.2)}) {
    mirror.vertices[scene.vertices.size() % 4] = static_cast<uint32_t>(scene.vertices.size());
    scene.vertices.push_back(v);
  }
  mirror.material = static_cast<uint32_t>(scene.materials.size());
  mirror.file_polygon = scene.file_polygon_count++;
  mirror.sides = kFrontTakesPart;
  scene.materials.push_back({"mirror", Rgb(0.05), Rgb(0.0)});
  scene.materials.back().specular = 0.9;
  scene.polygons.push_back(mirror);
  scene.sky.columns = scene.sky.rows = 1;
  scene.sky.texels = {1, 1, 1};
  return scene;
}

}  // namespace isolux::testing
