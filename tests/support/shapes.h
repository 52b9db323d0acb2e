// Shapes of many polygons that are known in closed form: boxes, discs, spheres.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/scene/scene.h"

namespace isolux::testing {

// Face x = 0, x = a, y = 0, y = b, z = 0 or z = c of a box a × b × c, seen from inside.
inline ConvexPolygon BoxFace(const Vec3& size, int face) {
  const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
  ConvexPolygon polygon{4, {}};
  for (int i = 0; i < 4; ++i) {
    polygon.v[i][axis] = face % 2 == 0 ? 0 : size[axis];
    polygon.v[i][u] = i == 1 || i == 2 ? size[u] : 0;
    polygon.v[i][v] = i >= 2 ? size[v] : 0;
  }
  if (face % 2 == 1) std::reverse(polygon.v.begin(), polygon.v.begin() + 4);
  return polygon;
}

// A regular polygon about the z axis at height z, seen from above or below: quads between rings of
// corners, triangles round the middle; an even number of corners, the outermost at `radius`.
inline std::vector<ConvexPolygon> Disc(double radius, double z, int corners, int rings, bool up) {
  std::vector<ConvexPolygon> parts;
  const auto corner = [&](int ring, int k) {
    const double angle = 2 * std::numbers::pi * k / corners, r = radius * ring / rings;
    return Vec3(r * std::cos(angle), r * std::sin(angle), z);
  };
  for (int k = 0; k < corners; ++k) {
    parts.push_back({3, {corner(0, 0), corner(1, k), corner(1, k + 1)}});
    for (int ring = 1; ring < rings; ++ring) {
      parts.push_back(
          {4,
           {corner(ring, k), corner(ring + 1, k), corner(ring + 1, k + 1), corner(ring, k + 1)}});
    }
  }
  for (ConvexPolygon& part : parts) {
    if (!up) std::reverse(part.v.begin(), part.v.begin() + part.count);
  }
  return parts;
}

// The radius of a regular polygon as large as a disc of radius 1.
inline double RadiusOfEqualArea(int corners) {
  const double angle = 2 * std::numbers::pi / corners;
  return std::sqrt(angle / std::sin(angle));
}

// An icosahedron whose sides are halved `halvings` times, its corners at `radius`: 20, 80, 320 …
// triangles, seen from outside or inside.
inline std::vector<ConvexPolygon> Sphere(double radius, int halvings, bool outside) {
  const double g = std::numbers::phi;
  const Vec3 v[] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  const int faces[][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                          {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                          {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                          {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  const auto on_sphere = [&](const Vec3& x) { return radius / glm::length(x) * x; };
  std::vector<ConvexPolygon> parts;
  for (const auto& f : faces) {
    parts.push_back({3, {on_sphere(v[f[0]]), on_sphere(v[f[1]]), on_sphere(v[f[2]])}});
  }
  for (; halvings > 0; --halvings) {
    std::vector<ConvexPolygon> finer;
    for (const ConvexPolygon& part : parts) {
      const Vec3 &a = part.v[0], &b = part.v[1], &c = part.v[2];
      const Vec3 ab = on_sphere(a + b), bc = on_sphere(b + c), ca = on_sphere(c + a);
      for (const auto& t : {ConvexPolygon{3, {a, ab, ca}}, ConvexPolygon{3, {ab, b, bc}},
                            ConvexPolygon{3, {ca, bc, c}}, ConvexPolygon{3, {ab, bc, ca}}}) {
        finer.push_back(t);
      }
    }
    parts = std::move(finer);
  }
  for (ConvexPolygon& part : parts) {
    if ((glm::dot(part.Normal(), part.v[0]) > 0) != outside) std::swap(part.v[1], part.v[2]);
  }
  return parts;
}

inline double AreaOf(const std::vector<ConvexPolygon>& parts) {
  double area = 0;
  for (const ConvexPolygon& part : parts) area += part.Area();
  return area;
}

}  // namespace isolux::testing
