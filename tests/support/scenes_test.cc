#include "tests/support/scenes.h"

#include <gtest/gtest.h>

namespace isolux::testing {
namespace {

// Volume enclosed by the fronts: positive where they look outwards.
double SignedVolume(const Scene& scene) {
  double volume = 0;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const ConvexPolygon shape = SideGeometry(scene, p, Side::kFront);
    volume += glm::dot(shape.Centroid(), shape.AreaVector()) / 3;
  }
  return volume;
}

TEST(Scenes, BoxLooksInwards) {
  BoxFaces faces;
  faces.reflectance.fill(Rgb(0.5));
  faces.exitance[5] = Rgb(1.0);
  const Scene scene = BoxRoom({2, 3, 4}, faces);
  EXPECT_TRUE(Validate(scene).ok()) << Validate(scene).message();
  EXPECT_EQ(scene.polygons.size(), 6U);
  EXPECT_EQ(scene.vertices.size(), 8U);
  EXPECT_EQ(MakeSurfaces(scene).size(), 6U);
  EXPECT_NEAR(SignedVolume(scene), -24.0, 1e-12);
  EXPECT_EQ(SideGeometry(scene, 1, Side::kFront).Centroid(), Vec3(2, 1.5, 2));
  EXPECT_EQ(SideGeometry(scene, 4, Side::kFront).Normal(), Vec3(0, 0, 1));
}

TEST(Scenes, FurnaceIsValid) {
  for (const double rho : {0.0, 0.5, 0.9}) EXPECT_TRUE(Validate(FurnaceCube(rho, 1)).ok());
}

TEST(Scenes, CornellBoxLooksAtItsInside) {
  const Scene scene = CornellBox(true);
  ASSERT_TRUE(Validate(scene).ok()) << Validate(scene).message();
  EXPECT_EQ(scene.polygons.size(), 24U);
  EXPECT_EQ(MakeSurfaces(scene).size(), 48U);
  EXPECT_EQ(MakeSurfaces(CornellBox(false)).size(), 24U);
  const Vec3 centre(0.278, 0.274, 0.28);
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const ConvexPolygon shape = SideGeometry(scene, p, Side::kFront);
    if (p < 14) {
      EXPECT_GT(glm::dot(centre - shape.Centroid(), shape.Normal()), 0.2) << p;
    } else {
      const Vec3 block = p < 19 ? Vec3(0.186, 0.08, 0.169) : Vec3(0.368, 0.16, 0.351);
      EXPECT_GT(glm::dot(shape.Centroid() - block, shape.Normal()), 0.05) << p;
    }
  }
}

TEST(Scenes, RandomRoomsAreValidAndRepeat) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    const Scene scene = RandomRoom(seed, static_cast<int>(seed % 12));
    const Status status = Validate(scene);
    ASSERT_TRUE(status.ok()) << "seed " << seed << ": " << status.message();
    EXPECT_EQ(Encode(scene), Encode(RandomRoom(seed, static_cast<int>(seed % 12))));
  }
  EXPECT_NE(Encode(RandomRoom(1, 3)), Encode(RandomRoom(2, 3)));
}

}  // namespace
}  // namespace isolux::testing
