#include "common/hierarchy/occluders.h"

#include "common/hierarchy/planes.h"
#include "common/hierarchy/regions.h"

namespace isolux {
namespace {

// Straightened borders may stick out by this share of the extent.
constexpr double kStraightOfExtent = 1e-7;

// Cells of a region: of its outline where that can be divided, else its polygons.
std::vector<Loop> CellsOf(const Scene& scene, const Region& region, std::span<const Loop> loops,
                          const Vec3& normal, double area_m2, double tolerance_m) {
  std::vector<Loop> cells;
  for (const uint32_t p : region.polygons) cells.push_back(loops[p]);
  if (cells.size() == 1) return cells;
  std::vector<Loop> joined = JoinConvex(scene, cells, normal, OccluderPolygon::kMostCorners);
  if (joined.size() == 1) return joined;
  const auto triangles = Retriangulate(scene, region, normal, area_m2, tolerance_m);
  if (!triangles) return joined;
  std::vector<Loop> divided;
  for (const auto& t : *triangles) divided.push_back({t[0], t[1], t[2]});
  divided = JoinConvex(scene, std::move(divided), normal, OccluderPolygon::kMostCorners);
  return divided.size() < joined.size() ? divided : joined;
}

}  // namespace

std::vector<OccluderPolygon> MergeOccluders(const Scene& scene,
                                            std::span<const uint32_t> plane_of) {
  const double tolerance = kStraightOfExtent * ExtentOf(scene);
  const auto [loops, normals, areas] = OrientAlike(scene, plane_of);
  const std::vector<uint64_t> key(plane_of.begin(), plane_of.end());
  std::vector<OccluderPolygon> occluders;
  for (const Region& region : FindRegions(scene, loops, key, normals)) {
    const uint32_t first = region.polygons[0];
    double area = 0;
    for (const uint32_t p : region.polygons) area += areas[p];
    const Vec3& normal = normals[first];
    for (const Loop& cell : CellsOf(scene, region, loops, normal, area, tolerance)) {
      OccluderPolygon occluder;
      for (const uint32_t v : cell) occluder.corners.push_back(scene.vertices[v]);
      occluder.normal = normal;
      occluder.plane = plane_of[first];
      occluder.first_polygon = first;
      occluders.push_back(std::move(occluder));
    }
  }
  return occluders;
}

}  // namespace isolux
