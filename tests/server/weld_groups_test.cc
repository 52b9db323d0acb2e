#include "server/weld_groups.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/obj_scene.h"

namespace isolux::testing {
namespace {

// Group of the front of the polygon of a material whose middle is nearest to a point of the file.
uint32_t GroupAt(const Scene& scene, const std::vector<uint32_t>& groups,
                 const Hierarchy& hierarchy, const std::string& material, const Vec3& point) {
  uint32_t best = 0;
  double least = 1e300;
  for (uint32_t s = 0; s < groups.size(); ++s) {
    const Surface& surface = hierarchy.surfaces()[s];
    const std::string& name = scene.materials[scene.polygons[surface.polygon].material].name;
    if (surface.side != Side::kFront || name != material) continue;
    const double distance = glm::length(hierarchy.geometry(s).Centroid() + scene.origin_m - point);
    if (distance >= least) continue;
    least = distance;
    best = groups[s];
  }
  return best;
}

TEST(WeldGroups, DivideAFloorWhereThingsStand) {
  ObjScene room;
  room.Box("white", {0, 0, 0}, {6, 4, 3}, true, true, true);
  room.Box("red", {1, 1, 0}, {2, 2, 1}, false);                       // a block
  room.Face("blue", {{4, 0, 0}, {4, 4, 0}, {4, 4, 3}, {4, 0, 3}});    // a partition
  room.Face("blue", {{0, 3, -1}, {3, 3, -1}, {3, 3, 0}, {0, 3, 0}});  // a wall below the floor
  room.Face("blue", {{2.5, 0, 0}, {2.5, 1.5, 0}, {2.5, 1.5, 2}, {2.5, 0, 2}});  // ends in the room
  const Scene scene = room.Import();
  const Hierarchy hierarchy(scene);
  const std::vector<uint32_t> groups = FindWeldGroups(hierarchy);
  std::set<uint32_t> of_floor;
  for (uint32_t s = 0; s < groups.size(); ++s) {
    const Surface& surface = hierarchy.surfaces()[s];
    const Vec3 centre = hierarchy.geometry(s).Centroid() + scene.origin_m;
    if (surface.side == Side::kFront && std::abs(centre.z) < 1e-9) of_floor.insert(groups[s]);
  }
  EXPECT_EQ(of_floor.size(), 3U);
  const auto at = [&](double x, double y) {
    return GroupAt(scene, groups, hierarchy, "white", {x, y, 0});
  };
  EXPECT_NE(at(1.5, 1.5), at(0.5, 1.5));  // under the block, and beside it
  EXPECT_NE(at(5, 2), at(3, 2));          // beyond the partition
  EXPECT_EQ(at(0.5, 1.5), at(3, 2));
  EXPECT_EQ(at(0.5, 3.5), at(3, 2));  // what stands below does not matter above
}

TEST(WeldGroups, DivideAFloorAlongPanesOfGlass) {
  for (const double width : {4.0, 2.0}) {  // from wall to wall, or half of that
    ObjScene room;
    room.Box("white", {0, 0, 0}, {6, 4, 3}, true, true, true);
    room.Face("glass", {{4, 0, 0}, {4, width, 0}, {4, width, 3}, {4, 0, 3}});
    const Scene scene = room.Import();
    ASSERT_EQ(scene.glazing.panes.size(), 1U);
    const Hierarchy hierarchy(scene);
    const std::vector<uint32_t> groups = FindWeldGroups(hierarchy);
    const bool apart = GroupAt(scene, groups, hierarchy, "white", {5, 1, 0}) !=
                       GroupAt(scene, groups, hierarchy, "white", {3, 1, 0});
    EXPECT_EQ(apart, width == 4);
  }
}

}  // namespace
}  // namespace isolux::testing
