#include "common/hierarchy/planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/occluders.h"
#include "common/util/random.h"

namespace isolux {
namespace {

class SceneBuilder {
 public:
  SceneBuilder() { scene.materials.push_back({"a", Rgb(0.5), Rgb(1.0)}); }

  uint32_t Vertex(const Vec3& v) {
    scene.vertices.push_back(v);
    return static_cast<uint32_t>(scene.vertices.size() - 1);
  }
  void Add(uint32_t a, uint32_t b, uint32_t c, uint32_t d = kNoVertex) {
    Polygon polygon;
    polygon.vertices = {a, b, c, d};
    polygon.file_polygon = scene.file_polygon_count++;
    scene.polygons.push_back(polygon);
  }
  // A grid of n × n squares, its vertices as `place` puts them from (0,0) to (1,1).
  template <typename Place>
  void Grid(int n, const Place& place, bool triangles) {
    const auto first = static_cast<uint32_t>(scene.vertices.size());
    for (int y = 0; y <= n; ++y) {
      for (int x = 0; x <= n; ++x) Vertex(place(1.0 * x / n, 1.0 * y / n));
    }
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const uint32_t v = first + static_cast<uint32_t>(y * (n + 1) + x);
        const auto up = v + static_cast<uint32_t>(n) + 1;
        if (triangles) {
          Add(v, v + 1, up + 1);
          Add(up + 1, up, v);
        } else {
          Add(v, v + 1, up + 1, up);
        }
      }
    }
  }

  Scene scene;
};

size_t CountPlanes(const std::vector<uint32_t>& plane_of) {
  return std::set<uint32_t>(plane_of.begin(), plane_of.end()).size();
}

// As a file with six significant digits has it.
double Printed(double x) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", x);
  return std::atof(text);
}

TEST(Planes, AgreeWhereCoordinatesArePrintedWithSixDigits) {
  // A wall askew in a room of 10 m at 3 m from the origin, in tiles of 20 cm with corners of their
  // own: their normals differ by 1e-4.
  SceneBuilder b;
  const Vec3 u = glm::normalize(Vec3(0.8, 0.53, 0.1)),
             v = glm::normalize(glm::cross(u, Vec3(1, -2, 0.3)));
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      std::array<uint32_t, 4> corner;
      for (int k = 0; k < 4; ++k) {
        const double s = 0.2 * (x + (k == 1 || k == 2)), t = 0.2 * (y + (k > 1));
        const Vec3 p = Vec3(3, 1, 2) + s * u + t * v;
        corner[k] = b.Vertex({Printed(p.x), Printed(p.y), Printed(p.z)});
      }
      b.Add(corner[0], corner[1], corner[2], corner[3]);
    }
  }
  EXPECT_EQ(CountPlanes(FindPlanes(b.scene)), 1U);
}

TEST(Planes, DifferOverACurvedSurface) {
  // A sphere of 10^4 facets and a vault of a thousand strips, seen from inside: facets exchange
  // light.
  SceneBuilder sphere;
  sphere.Grid(
      100,
      [](double s, double t) {
        const double a = 2 * M_PI * s, h = M_PI * (0.005 + 0.99 * t);
        return Vec3(std::sin(h) * std::cos(a), std::sin(h) * std::sin(a), std::cos(h));
      },
      true);
  const std::vector<uint32_t> planes = FindPlanes(sphere.scene);
  EXPECT_GE(CountPlanes(planes), 9'500U);  // 10^4 but for the narrow ones at the poles
  SceneBuilder vault;
  for (int i = 0; i <= 1000; ++i) {
    const double a = M_PI * i / 1000;
    vault.Vertex({std::cos(a), std::sin(a), 0});
    vault.Vertex({std::cos(a), std::sin(a), 5});
    if (i > 0) {
      const auto v = static_cast<uint32_t>(2 * i);
      vault.Add(v - 2, v, v + 1, v - 1);
    }
  }
  // Neighbouring strips, 5 m by 3 mm, are 10 micrometres off each other's plane; farther ones not.
  const std::vector<uint32_t> strips = FindPlanes(vault.scene);
  for (uint32_t s = 5; s < strips.size(); ++s) EXPECT_NE(strips[s], strips[s - 5]);
}

TEST(Planes, DoNotDependOnOrientationOrDistance) {
  SceneBuilder b;
  b.Grid(
      1, [](double s, double t) { return Vec3(s, t, 0); }, false);
  b.Grid(
      1, [](double s, double t) { return Vec3(20 + t, s, 0); }, false);  // faces down
  b.Grid(
      1, [](double s, double t) { return Vec3(s, t, 0.001); }, false);  // a shelf above
  b.Grid(
      1, [](double s, double t) { return Vec3(s, 0, t); }, false);
  b.Grid(
      1, [](double s, double t) { return Vec3(0.5 * s, t, 1e-8); }, false);  // as good as in it
  const std::vector<uint32_t> planes = FindPlanes(b.scene);
  EXPECT_EQ(planes, (std::vector<uint32_t>{0, 0, 1, 2, 0}));
}

TEST(Planes, KeepSmallThingsApartInALargeScene) {
  SceneBuilder b;  // a ground of 10 km, a table of 1 m, 5 cm thick
  b.Grid(
      1, [](double s, double t) { return Vec3(1e4 * s, 1e4 * t, 0); }, false);
  b.Grid(
      1, [](double s, double t) { return Vec3(50 + s, 50 + t, 0.7); }, false);
  b.Grid(
      1, [](double s, double t) { return Vec3(50 + s, 50 + t, 0.75); }, false);
  b.Grid(
      1, [](double s, double t) { return Vec3(53 + s, 50 + t, 0.01); }, false);
  EXPECT_EQ(CountPlanes(FindPlanes(b.scene)), 4U);
}

double AreaOf(const OccluderPolygon& occluder) {
  Vec3 sum(0.0);
  for (size_t i = 1; i + 1 < occluder.corners.size(); ++i) {
    sum += glm::cross(occluder.corners[i] - occluder.corners[0],
                      occluder.corners[i + 1] - occluder.corners[0]);
  }
  return 0.5 * glm::dot(sum, occluder.normal);
}

TEST(Occluders, OneForATessellatedWall) {
  SceneBuilder b;
  b.Grid(
      224, [](double s, double t) { return Vec3(6 * s, 0.1, 3 * t); }, true);  // 100,352
  for (size_t p = 0; p < b.scene.polygons.size(); p += 3) {  // either orientation, any material
    std::swap(b.scene.polygons[p].vertices[0], b.scene.polygons[p].vertices[1]);
    b.scene.polygons[p].material = p % 2;
  }
  const auto occluders = MergeOccluders(b.scene, FindPlanes(b.scene));
  ASSERT_EQ(occluders.size(), 1U);
  EXPECT_EQ(occluders[0].corners.size(), 4U);
  EXPECT_NEAR(AreaOf(occluders[0]), 18, 1e-9);
  EXPECT_EQ(occluders[0].first_polygon, 0U);
}

TEST(Occluders, OneForRandomTrianglesOfAWall) {
  const uint64_t seed = 11;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  Random random(seed);
  SceneBuilder b;
  b.Grid(
      40,
      [&](double s, double t) {
        const bool inside = s > 0.01 && s < 0.99 && t > 0.01 && t < 0.99;
        const double shift = inside ? 0.004 : 0;
        return Vec3(s + shift * (2 * random.Unit() - 1), 2, t + shift * (2 * random.Unit() - 1));
      },
      true);
  const auto occluders = MergeOccluders(b.scene, FindPlanes(b.scene));
  ASSERT_EQ(occluders.size(), 1U);
  EXPECT_NEAR(AreaOf(occluders[0]), 1, 1e-9);
}

TEST(Occluders, LeaveHolesOpen) {
  SceneBuilder b;  // a wall with a window, of 32 squares
  b.Grid(
      6, [](double s, double t) { return Vec3(6 * s, 0, 6 * t); }, false);
  std::erase_if(b.scene.polygons, [](const Polygon& p) {
    return p.file_polygon == 14 || p.file_polygon == 15 || p.file_polygon == 20 ||
           p.file_polygon == 21;
  });
  const auto occluders = MergeOccluders(b.scene, FindPlanes(b.scene));
  double area = 0;
  for (const auto& occluder : occluders) {
    area += AreaOf(occluder);
    Vec3 middle(0.0);
    for (const Vec3& c : occluder.corners)
      middle += c / static_cast<double>(occluder.corners.size());
    EXPECT_FALSE(middle.x > 2 && middle.x < 4 && middle.z > 2 && middle.z < 4);
    for (size_t i = 0; i < occluder.corners.size(); ++i) {  // convex
      const auto& c = occluder.corners;
      const Vec3 in = c[(i + 1) % c.size()] - c[i],
                 out = c[(i + 2) % c.size()] - c[(i + 1) % c.size()];
      EXPECT_GE(glm::dot(glm::cross(in, out), occluder.normal), -1e-9);
    }
  }
  EXPECT_NEAR(area, 32, 1e-9);
  EXPECT_LE(occluders.size(), 6U);
}

TEST(Occluders, KeepWhatCannotBeJoined) {
  SceneBuilder b;  // three sheets on one edge, two of them in one plane; and an overlap
  for (const Vec3& v : {Vec3(0, 0, 0), Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(1, 0, 0), Vec3(-1, 0, 1),
                        Vec3(-1, 0, 0), Vec3(0, 1, 1), Vec3(0, 1, 0)}) {
    b.Vertex(v);
  }
  b.Add(0, 1, 2, 3);
  b.Add(0, 5, 4, 1);
  b.Add(0, 1, 6, 7);
  b.Add(0, 1, 2);
  const auto occluders = MergeOccluders(b.scene, FindPlanes(b.scene));
  double area = 0;
  for (const auto& occluder : occluders) area += AreaOf(occluder);
  EXPECT_NEAR(area, 3.5, 1e-12);
}

// A box whose six walls are of so many triangles is convex, however many they are, and is not with
// one vertex of one wall a thousandth inside.
TEST(Convex, WallsOfManyTriangles) {
  SceneBuilder b;
  constexpr int kAcross = 91;  // 99,372 in all
  for (int axis = 0; axis < 3; ++axis) {
    for (const double at : {0.0, 3.0}) {
      b.Grid(
          kAcross,
          [&](double s, double t) {
            Vec3 v(at);
            v[(axis + 1) % 3] = 3 * s;
            v[(axis + 2) % 3] = 3 * t;
            return v;
          },
          true);
    }
  }
  EXPECT_TRUE(Hierarchy(b.scene).convex());
  b.scene.vertices[(kAcross + 1) * (kAcross + 1) / 2].x = 0.003;
  EXPECT_FALSE(Hierarchy(b.scene).convex());
}

}  // namespace
}  // namespace isolux
