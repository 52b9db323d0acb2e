#include "tests/support/factor_scenes.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "tests/support/polygons.h"

namespace isolux::testing {
namespace {

constexpr double kPanel = 0.5;  // metres

// Both sides of a room or box along an axis, in panels; `inwards`: fronts face each other.
void AddWalls(int axis, const Vec3& low, const Vec3& high, int nu, int nv, bool inwards,
              std::vector<ConvexPolygon>* out) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (const bool upper : {false, true}) {
    for (int i = 0; i < nu; ++i) {
      for (int j = 0; j < nv; ++j) {
        const double du = (high[u] - low[u]) / nu, dv = (high[v] - low[v]) / nv;
        out->push_back(AxisRectangle(axis, upper ? high[axis] : low[axis], low[u] + i * du,
                                     low[u] + (i + 1) * du, low[v] + j * dv, low[v] + (j + 1) * dv,
                                     upper != inwards));
      }
    }
  }
}

}  // namespace

Scene MakeScene(const std::vector<ConvexPolygon>& polygons) {
  Scene scene;
  scene.materials.push_back({"grey", Rgb(0.5), Rgb(0.0)});
  std::map<std::tuple<double, double, double>, uint32_t> vertices;
  for (const ConvexPolygon& shape : polygons) {
    Polygon polygon;
    for (int i = 0; i < shape.count; ++i) {
      const Vec3& v = shape.v[i];
      const auto [at, is_new] =
          vertices.emplace(std::tuple(v.x, v.y, v.z), static_cast<uint32_t>(scene.vertices.size()));
      if (is_new) scene.vertices.push_back(v);
      polygon.vertices[i] = at->second;
    }
    polygon.sides = kFrontTakesPart;
    polygon.file_polygon = scene.file_polygon_count++;
    scene.polygons.push_back(polygon);
  }
  return scene;
}

Scene MakePanelledRoom(const PanelledRoom& room) {
  const auto& n = room.panels;
  const Vec3 size = kPanel * Vec3(n[0], n[1], n[2]);
  std::vector<ConvexPolygon> polygons;
  AddWalls(0, Vec3(0.0), size, n[1], n[2], true, &polygons);
  AddWalls(1, Vec3(0.0), size, n[2], n[0], true, &polygons);
  AddWalls(2, Vec3(0.0), size, n[0], n[1], true, &polygons);
  if (!room.with_box) return MakeScene(polygons);
  const Vec3 low(kPanel * room.low[0], kPanel * room.low[1], room.gap_m);
  const Vec3 high(kPanel * room.high[0], kPanel * room.high[1], room.gap_m + room.height_m);
  const bool stands = room.gap_m == 0;
  if (stands) {
    std::erase_if(polygons, [&](const ConvexPolygon& polygon) {
      const Vec3 c = polygon.Centroid();
      return c.z == 0 && c.x > low.x && c.x < high.x && c.y > low.y && c.y < high.y;
    });
  }
  AddWalls(0, low, high, 2, 1, false, &polygons);
  AddWalls(1, low, high, 1, 2, false, &polygons);
  std::vector<ConvexPolygon> ends;
  AddWalls(2, low, high, 2, 1, false, &ends);
  polygons.insert(polygons.end(), ends.begin() + (stands ? 2 : 0), ends.end());
  return MakeScene(polygons);
}

}  // namespace isolux::testing
