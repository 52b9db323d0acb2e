#include "client/import/merge.h"

#include <gtest/gtest.h>

namespace isolux {
namespace {

Scene TrianglesOf(const std::vector<Vec3>& vertices,
                  const std::vector<std::array<uint32_t, 3>>& corners) {
  Scene scene;
  scene.vertices = vertices;
  scene.materials.push_back({"a", Rgb(0.5), Rgb(1.0)});
  scene.materials.push_back({"b", Rgb(0.5), Rgb(1.0)});
  for (const auto& c : corners) {
    Polygon polygon;
    polygon.vertices = {c[0], c[1], c[2], kNoVertex};
    polygon.file_polygon = scene.file_polygon_count++;
    polygon.sides |= kFrontEmits;
    scene.polygons.push_back(polygon);
  }
  return scene;
}

double TotalArea(const Scene& scene) {
  double area = 0;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    area += SideGeometry(scene, p, Side::kFront).Area();
  }
  return area;
}

const std::vector<Vec3> kSquare = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

TEST(Merge, JoinsTheHalvesOfASquare) {
  Scene scene = TrianglesOf(kSquare, {{0, 1, 2}, {2, 3, 0}});
  scene.polygons[0].file_polygon = 7;
  scene.polygons[1].file_polygon = 3;
  EXPECT_EQ(MergeTrianglePairs(&scene), 1U);
  ASSERT_EQ(scene.polygons.size(), 1U);
  EXPECT_EQ(scene.polygons[0].vertex_count(), 4);
  EXPECT_EQ(scene.polygons[0].file_polygon, 3U);
  EXPECT_TRUE(Validate(scene).ok()) << Validate(scene).message();
  EXPECT_EQ(SideGeometry(scene, 0, Side::kFront).AreaVector(), Vec3(0, 0, 1));
}

TEST(Merge, KeepsApartWhatDiffers) {
  Scene material = TrianglesOf(kSquare, {{0, 1, 2}, {2, 3, 0}});
  material.polygons[1].material = 1;
  EXPECT_EQ(MergeTrianglePairs(&material), 0U);
  Scene sides = TrianglesOf(kSquare, {{0, 1, 2}, {2, 3, 0}});
  sides.polygons[1].sides = kFrontTakesPart;
  EXPECT_EQ(MergeTrianglePairs(&sides), 0U);
  Scene winding = TrianglesOf(kSquare, {{0, 1, 2}, {0, 3, 2}});
  EXPECT_EQ(MergeTrianglePairs(&winding), 0U);
  Scene folded =
      TrianglesOf({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 1e-4}}, {{0, 1, 2}, {2, 3, 0}});
  EXPECT_EQ(MergeTrianglePairs(&folded), 0U);
  Scene concave = TrianglesOf({{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}}, {{0, 1, 2}, {0, 2, 3}});
  EXPECT_EQ(MergeTrianglePairs(&concave), 0U);
  Scene split_side =
      TrianglesOf({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, {{0, 1, 3}, {1, 2, 3}});
  EXPECT_EQ(MergeTrianglePairs(&split_side), 0U);
  Scene fin = TrianglesOf({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}},
                          {{0, 1, 2}, {2, 3, 0}, {0, 2, 4}});
  EXPECT_EQ(MergeTrianglePairs(&fin), 0U);
}

TEST(Merge, MakesNoSlivers) {
  // Two right triangles joined along the short side make a long parallelogram.
  Scene scene =
      TrianglesOf({{0, 0, 0}, {10, 0, 0}, {10, 1, 0}, {20, 1, 0}}, {{0, 1, 2}, {1, 3, 2}});
  EXPECT_EQ(MergeTrianglePairs(&scene), 0U);
}

TEST(Merge, PrefersTheBestShape) {
  // A strip of four triangles: the squares win over the parallelogram between them.
  Scene scene = TrianglesOf({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}},
                            {{1, 4, 3}, {0, 1, 3}, {1, 2, 4}, {2, 5, 4}});
  EXPECT_EQ(MergeTrianglePairs(&scene), 2U);
  ASSERT_EQ(scene.polygons.size(), 2U);
  EXPECT_NEAR(TotalArea(scene), 2.0, 1e-15);
  for (uint32_t p = 0; p < 2; ++p)
    EXPECT_NEAR(SideGeometry(scene, p, Side::kFront).Area(), 1, 1e-15);
}

}  // namespace
}  // namespace isolux
