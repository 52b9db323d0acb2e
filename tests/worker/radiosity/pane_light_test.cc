// What panes take at most of what surfaces radiate, of which they look at so many.
#include "worker/radiosity/pane_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "tests/support/glass.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

// A box with one lamp, its face 5, and panes in the middle.
Scene RoomWithPanes(int panes) {
  BoxFaces faces;
  faces.exitance[5] = Rgb(2);
  Scene scene = BoxRoom({1, 1, 1}, faces);
  scene.glazing.glasses = {GlassOf({0.6, 0.7, 0.6}, 1)};
  Pane pane;
  pane.corners = {Vec3(.4, .4, .5), Vec3(.6, .4, .5), Vec3(.6, .6, .5), Vec3(.4, .6, .5)};
  pane.count = 4;
  scene.glazing.panes.assign(static_cast<size_t>(panes), pane);
  return scene;
}

// In a convex room surfaces see a pane whole: what falls on it is the mean of what they radiate, by
// form factors; known of all together it is what the brightest radiates.
TEST(PaneLight, PanesTakeWhatSurfacesRadiate) {
  const Scene scene = RoomWithPanes(1);
  const Hierarchy hierarchy(scene);
  const std::vector<double> dark(6, 0.0), even(6, 3.0), one = {3.0};
  std::vector<double> floor = dark;
  floor[4] = 3;
  const double from_lamp = MostTakenByPanes(hierarchy, dark);
  const double from_all = MostTakenByPanes(hierarchy, one) - from_lamp;
  EXPECT_NEAR(MostTakenByPanes(hierarchy, even) - from_lamp, from_all, 1e-9 * from_all);
  // Floor and lamp are alike as seen from the middle, one shines 3, the other 2 in three channels.
  EXPECT_NEAR((MostTakenByPanes(hierarchy, floor) - from_lamp) / from_lamp, 0.5, 1e-9);
  EXPECT_LT(from_lamp, from_all);
}

// Of as many surfaces as may be looked at, the lamp among them, the brightest are; the others count
// as if all round were as bright as the brightest of them.
TEST(PaneLight, PanesLookAtNoMoreSurfacesThanTheyMay) {
  constexpr int kPanes = 3;
  const Scene scene = RoomWithPanes(kPanes);
  const Hierarchy hierarchy(scene);
  const std::vector<double> reflected = {2, 7, 0.5, 4, 3, 1}, falling = {7, 4, 3, 2, 1, 0.5};
  const std::vector<double> dark(6, 0.0), one = {1.0};
  const double from_lamp = MostTakenByPanes(hierarchy, dark);
  const double all_round = MostTakenByPanes(hierarchy, one) - from_lamp;
  std::vector<double> from_each;
  for (size_t s = 0; s < 6; ++s) {
    std::vector<double> alone = dark;
    alone[s] = 1;
    from_each.push_back(MostTakenByPanes(hierarchy, alone) - from_lamp);
  }
  const double whole = MostTakenByPanes(hierarchy, reflected);
  for (size_t looked_at = 0; looked_at <= 8; ++looked_at) {
    const double beyond = looked_at < 6 ? falling[looked_at] : 0;
    double expected = from_lamp + beyond * all_round;
    for (size_t s = 0; s < 6; ++s) {
      expected += std::max(0.0, reflected[s] - beyond) * from_each[s];
    }
    for (const uint64_t left_over : {0, 1, 2}) {  // too few pairs for one surface more
      const double taken =
          MostTakenByPanes(hierarchy, reflected, kPanes * (1 + looked_at) + left_over);
      EXPECT_NEAR(taken, expected, 1e-9 * whole) << looked_at << " surfaces";
      EXPECT_GE(taken, (1 - 1e-9) * whole);
    }
  }
  EXPECT_EQ(MostTakenByPanes(hierarchy, reflected, kPanes - 1),
            std::numeric_limits<double>::infinity());
}

// 4096 panes and 1024 lamps are as many as may be: with one more nothing is known.
TEST(PaneLight, TooManyPanesAndLampsHaveNoBound) {
  Scene scene = RoomWithPanes(4096);
  const Polygon lamp = scene.polygons[5];
  for (int i = 0; i < 1024; ++i) {
    Polygon& added = scene.polygons.emplace_back(lamp);
    added.file_polygon = scene.file_polygon_count++;
    const int column = i % 32, row = i / 32;
    const double x = 0.01 + 0.9 * column / 32, y = 0.01 + 0.9 * row / 32;
    for (size_t k = 0; k < 4; ++k) {
      const Vec3& corner = scene.vertices[lamp.vertices[k]];
      added.vertices[k] = static_cast<uint32_t>(scene.vertices.size());
      scene.vertices.push_back(Vec3(x, y, 0.9) + 0.01 * (corner - Vec3(0, 0, corner.z)));
    }
  }
  EXPECT_EQ(MostTakenByPanes(Hierarchy(scene), std::vector<double>{0.0}),
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace isolux::testing
