// What preparation makes of things that stand, lie, hang and stick in each other.
#include "client/import/prepare.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/obj_scene.h"

namespace isolux::testing {
namespace {

constexpr uint8_t kFront = kFrontTakesPart, kBack = kBackTakesPart, kBoth = kFront | kBack;
constexpr uint8_t kShining = kFront | kFrontEmits;
using Sides = std::vector<uint8_t>;

// A room of 4 × 4 × 3 m, fronts inwards.
ObjScene Room() {
  ObjScene scene;
  scene.Box("white", {0, 0, 0}, {4, 4, 3}, true, true, true);
  return scene;
}

TEST(Prepare, CutsTheFloorRoundABlock) {
  for (const double z : {0.0, 1e-8, -1e-8}) {
    for (const bool bottom : {false, true}) {
      SCOPED_TRACE(::testing::Message() << "bottom at " << z << (bottom ? "" : ", open"));
      ObjScene room = Room();
      room.Box("red", {1, 1, z}, {2, 2, 1}, bottom);
      const Scene scene = room.Import();
      EXPECT_TRUE(CountOf(scene, ToText(Repair::kContact)) > 0);
      // Inside the outline the floor is a piece of its own.
      double covered = 0;
      for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
        const ConvexPolygon shape = SideGeometry(scene, p, Side::kFront);
        const Vec3 c = shape.Centroid() + scene.origin_m;
        if (scene.materials[scene.polygons[p].material].name != "white" || c.z > 0.1) continue;
        if (std::abs(c.x - 1.5) < 0.5 && std::abs(c.y - 1.5) < 0.5) covered += shape.Area();
      }
      EXPECT_NEAR(covered, 1, 1e-12);
      const Sides floor = SidesAt(scene, "white", {1.5, 1.4, 0});
      EXPECT_EQ(floor, Sides{bottom ? kBack : kBoth});
      EXPECT_EQ(SidesAt(scene, "red", {1.5, 1.4, z}), bottom ? Sides{kBack} : Sides{});
      EXPECT_EQ(SidesAt(scene, "white", {0.5, 0.4, 0}), Sides{kBoth});
    }
  }
}

TEST(Prepare, ACarpetLiesOnTheFrontOfTheFloor) {
  for (const double z : {0.0, 1e-8, -1e-8}) {
    SCOPED_TRACE(z);
    ObjScene room = Room();
    room.Level("red", 1, 1, 3, 2, z);
    const Scene scene = room.Import();
    EXPECT_EQ(SidesAt(scene, "red", {1.5, 1.4, z}), Sides{kFront});
    EXPECT_EQ(SidesAt(scene, "white", {1.5, 1.4, 0}), Sides{kBack});
    EXPECT_EQ(SidesAt(scene, "white", {0.5, 1.4, 0}), Sides{kBoth});
  }
}

TEST(Prepare, AMeasuredGapSaysWhichSideIsCovered) {
  // 25 µm under a ceiling, and 25 µm above it, in a room of 6.4 m.
  for (const double z : {3 - 2.5e-5, 3 + 2.5e-5}) {
    ObjScene room = Room();
    room.Level("lamp", 1, 1, 2, 2, z, false);
    const Scene scene = room.Import();
    const bool below = z < 3;
    EXPECT_EQ(SidesAt(scene, "lamp", {1.5, 1.4, z}), Sides{below ? kShining : kBack});
    EXPECT_EQ(SidesAt(scene, "white", {1.5, 1.4, 3}), Sides{below ? kBack : kFront});
  }
}

TEST(Prepare, ALampInTheCeilingShines) {
  ObjScene room = Room();
  room.Level("lamp", 1, 1, 2, 2, 3, false);
  const Scene scene = room.Import();
  EXPECT_EQ(SidesAt(scene, "lamp", {1.5, 1.4, 3}), Sides{kShining});
  EXPECT_EQ(SidesAt(scene, "white", {1.5, 1.4, 3}), Sides{kBack});
}

TEST(Prepare, AWallOfTwoMaterialsKeepsBothFronts) {
  // The same place, other corners: red to one side, blue in two parts to the other.
  ObjScene wall;
  wall.Face("red", {{0, 0, 0}, {4, 0, 0}, {4, 0, 3}, {0, 0, 3}});
  wall.Face("blue", {{0, 0, 3}, {1, 0, 3}, {1, 0, 0}, {0, 0, 0}});
  wall.Face("blue", {{1, 0, 3}, {4, 0, 3}, {4, 0, 0}, {1, 0, 0}});
  wall.Level("lamp", 0, -2, 4, 2, 5, false);
  const Scene scene = wall.Import();
  EXPECT_EQ(SidesAt(scene, "red", {2.5, 0, 1.4}), Sides{kFront});
  EXPECT_EQ(SidesAt(scene, "blue", {2.5, 0, 1.4}), Sides{kFront});
  EXPECT_EQ(SidesAt(scene, "blue", {0.5, 0, 1.4}), Sides{kFront});
}

TEST(Prepare, StackedBlocksHideWhereTheyTouch) {
  ObjScene room = Room();
  room.Box("red", {0.5, 0.5, 0}, {2, 2, 1});
  room.Box("blue", {1.5, 1.1, 1}, {3.2, 1.9, 1.5});
  const Scene scene = room.Import();
  EXPECT_EQ(SidesAt(scene, "red", {1.7, 1.5, 1}), Sides{kBack});
  EXPECT_EQ(SidesAt(scene, "blue", {1.7, 1.5, 1}), Sides{kBack});
  EXPECT_EQ(SidesAt(scene, "red", {1.3, 1.5, 1}), Sides{kBoth});
  EXPECT_EQ(SidesAt(scene, "blue", {2.1, 1.5, 1}), Sides{kBoth});
}

TEST(Prepare, SplitsWhatPassesThroughEachOther) {
  ObjScene scene_text;
  scene_text.Level("white", 0, 0, 4, 4, 0);
  scene_text.Face("red", {{1, 2, -1}, {3, 2, -1}, {3, 2, 1}, {1, 2, 1}});  // a wall sunk in
  const Scene scene = scene_text.Import();
  EXPECT_EQ(CountOf(scene, ToText(Repair::kPenetration)), 2U);
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const ConvexPolygon shape = SideGeometry(scene, p, Side::kFront);
    bool above = false, below = false;
    for (int k = 0; k < shape.count; ++k) {
      const Vec3 v = shape.v[k] + scene.origin_m;
      const bool red = scene.materials[scene.polygons[p].material].name == "red";
      const double side = red ? v.z : (v.x > 0.9999 && v.x < 3.0001) ? v.y - 2 : 0;
      above |= side > 1e-9;
      below |= side < -1e-9;
    }
    EXPECT_FALSE(above && below) << p;
  }
}

TEST(Prepare, JoinsNearPointsAndCountsTJunctions) {
  ObjScene text;
  text.Level("white", 0, 0, 1, 1, 0);
  text.Level("white", 1, 0, 2, 0.4, 1e-8);
  text.Level("white", 1, 0.4, 2, 1, -1e-8);
  const Scene scene = text.Import();
  EXPECT_EQ(scene.vertices.size(), 8U);
  EXPECT_EQ(CountOf(scene, ToText(Repair::kWelded)), 4U);
  EXPECT_EQ(CountOf(scene, ToText(Repair::kTJunction)), 1U);
  // Not what is as small as that: a bead of a micrometre in a room.
  ObjScene bead = Room();
  bead.Box("red", {1, 1, 1}, {1 + 1e-6, 1 + 1e-6, 1 + 1e-6});
  const Scene with_bead = bead.Import();
  EXPECT_EQ(with_bead.vertices.size(), 16U);
  EXPECT_EQ(with_bead.polygons.size(), 12U);
}

TEST(Prepare, MakesOneQuadOfATessellatedWall) {
  ObjScene text;
  const int n = 100;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const auto at = [&](int i, int k) { return Vec3(0.06 * (x + i), 1.0 / 3, 0.03 * (y + k)); };
      text.Face("red", {at(0, 0), at(1, 0), at(1, 1)});
      text.Face("red", {at(1, 1), at(0, 1), at(0, 0)});
    }
  }
  text.Level("white", 0, 0, 6, 4, 4);
  const Scene scene = text.Import();
  EXPECT_EQ(scene.polygons.size(), 2U);
  EXPECT_NEAR(AreaByMaterial(scene)["red"], 18, 1e-9);
  EXPECT_EQ(scene.polygons[0].file_polygon, 0U);
  EXPECT_EQ(scene.polygons[1].file_polygon, 20'000U);
}

TEST(Prepare, KeepsHolesAndMaterialsWhereItMerges) {
  ObjScene text;  // 10 × 10 squares, a window of 2 × 2, a red frame on the left
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 10; ++x) {
      if ((x == 4 || x == 5) && (y == 4 || y == 5)) continue;
      const char* material = x == 0 ? "red" : "white";
      text.Face(material, {Vec3(x, 0, y), Vec3(x + 1, 0, y), Vec3(x + 1, 0, y + 1)});
      text.Face(material, {Vec3(x + 1, 0, y + 1), Vec3(x, 0, y + 1), Vec3(x, 0, y)});
    }
  }
  const Scene scene = text.Import();
  EXPECT_LE(scene.polygons.size(), 8U);
  auto area = AreaByMaterial(scene);
  EXPECT_NEAR(area["red"], 10, 1e-9);
  EXPECT_NEAR(area["white"], 86, 1e-9);
  EXPECT_TRUE(SidesAt(scene, "white", {5.1, 0, 5.2}).empty());
  EXPECT_EQ(SidesAt(scene, "white", {7.1, 0, 5.2}).size(), 1U);
}

TEST(Prepare, StrictTakesWhatOnlyHasToBeCut) {
  ObjScene room = Room();
  room.Box("red", {1, 1, 0}, {2, 2, 1});
  room.Face("blue", {{1, 2.5, -1}, {3, 2.5, -1}, {3, 2.5, 1}, {1, 2.5, 1}});
  ImportOptions options;
  options.strict = true;
  EXPECT_TRUE(room.TryImport(options).has_value());
}

}  // namespace
}  // namespace isolux::testing
