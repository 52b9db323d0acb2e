// Scene files made in code: polygons by their corners, each with its own points, imported through a
// temporary file.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "client/import/import.h"
#include "common/util/random.h"
#include "tests/support/temp_dir.h"

namespace isolux::testing {

struct ObjFaceText {
  std::vector<Vec3> corners;
  std::string material;
};

class ObjScene {
 public:
  std::vector<ObjFaceText> faces;

  void Face(const std::string& material, const std::vector<Vec3>& corners) {
    faces.push_back({corners, material});
  }
  // x and y from `low` to `high`, at height z, counter-clockwise from above or from below.
  void Level(const std::string& material, double x0, double y0, double x1, double y1, double z,
             bool up = true) {
    std::vector<Vec3> corners{{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}};
    if (!up) std::reverse(corners.begin(), corners.end());
    Face(material, corners);
  }
  // Fronts outwards, or inwards; the bottom (z low) and the top (z high) can be left out.
  void Box(const std::string& material, const Vec3& low, const Vec3& high, bool bottom = true,
           bool top = true, bool inwards = false) {
    const auto at = [&](int x, int y, int z) {
      return Vec3(x != 0 ? high.x : low.x, y != 0 ? high.y : low.y, z != 0 ? high.z : low.z);
    };
    const auto add = [&](std::vector<Vec3> corners) {
      if (inwards) std::reverse(corners.begin(), corners.end());
      Face(material, corners);
    };
    if (bottom) add({at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)});
    if (top) add({at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)});
    add({at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)});
    add({at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)});
    add({at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1)});
    add({at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1)});
  }

  // Materials are white, red, blue, lamp and glass. Coordinates are printed with `digits`.
  Result<Scene> TryImport(const ImportOptions& options = {}, int digits = 17,
                          const Vec3& shift = Vec3(0.0), double scale = 1) const {
    std::string text = "mtllib s.mtl\n";
    for (const ObjFaceText& face : faces) {
      text += "usemtl " + face.material + "\n";
      std::string last = "f";
      for (size_t i = 0; i < face.corners.size(); ++i) {
        const Vec3 p = scale * face.corners[i] + shift;
        text += fmt::format("v {:.{}g} {:.{}g} {:.{}g}\n", p.x, digits, p.y, digits, p.z, digits);
        last += fmt::format(" {}", static_cast<int>(i) - static_cast<int>(face.corners.size()));
      }
      text += last + "\n";
    }
    const TempDir dir;
    dir.Write("s.mtl",
              "newmtl white\nKd 0.7 0.7 0.7\nnewmtl red\nKd 0.6 0.1 0.1\n"
              "newmtl blue\nKd 0.1 0.1 0.6\nnewmtl lamp\nKd 0 0 0\nKe 10 10 10\n"
              "newmtl glass\nTf 0.5 0.5 0.5\n");
    ImportOptions with = options;
    with.require_emission = false;
    return ImportScene(dir.Write("s.obj", text), with);
  }
  Scene Import(const ImportOptions& options = {}, int digits = 17, const Vec3& shift = Vec3(0.0),
               double scale = 1) const {
    Result<Scene> scene = TryImport(options, digits, shift, scale);
    EXPECT_TRUE(scene.has_value()) << scene.error().message();
    return scene.has_value() ? *std::move(scene) : Scene();
  }
};

// Flags of sides that take part or emit.
inline constexpr uint8_t kActive = kFrontTakesPart | kBackTakesPart | kFrontEmits | kBackEmits;

// Active side flags of the polygons of a material that hold a point of the file (metres, within a
// micrometre of the extent), seen along z; in the order of the polygons.
inline std::vector<uint8_t> SidesAt(const Scene& scene, const std::string& material,
                                    const Vec3& point) {
  std::vector<uint8_t> sides;
  const Vec3 p = point - scene.origin_m;
  for (uint32_t i = 0; i < scene.polygons.size(); ++i) {
    if (scene.materials[scene.polygons[i].material].name != material) continue;
    const ConvexPolygon shape = SideGeometry(scene, i, Side::kFront);
    const Vec3 normal = shape.Normal();
    if (std::abs(glm::dot(normal, p - shape.v[0])) > 1e-5) continue;
    bool inside = true;
    for (int k = 0; k < shape.count; ++k) {
      const Vec3 along = shape.v[(k + 1) % shape.count] - shape.v[k];
      inside = inside && glm::dot(glm::cross(along, p - shape.v[k]), normal) >= 0;
    }
    if (inside) sides.push_back(scene.polygons[i].sides & kActive);
  }
  return sides;
}

inline uint64_t CountOf(const Scene& scene, const std::string& kind) {
  for (const auto& entry : scene.repairs.entries) {
    if (entry.kind == kind) return entry.count;
  }
  return 0;
}

// m² by material name; one side of each polygon, whether it takes part or not.
inline std::map<std::string, double> AreaByMaterial(const Scene& scene) {
  std::map<std::string, double> area;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    area[scene.materials[scene.polygons[p].material].name] +=
        SideGeometry(scene, p, Side::kFront).Area();
  }
  return area;
}

}  // namespace isolux::testing
