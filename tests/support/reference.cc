#include "tests/support/reference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/random.h"

namespace isolux::testing {
namespace {

// A grid of patches on a quad; a triangle is cut at its midpoints into four, again and again.
void Divide(const ConvexPolygon& polygon, double largest_m2, std::vector<ConvexPolygon>& out) {
  if (polygon.Area() <= largest_m2) {
    out.push_back(polygon);
    return;
  }
  const auto middle = [&](int a, int b) { return 0.5 * (polygon.v[a] + polygon.v[b]); };
  if (polygon.count == 3) {
    const Vec3 a = middle(0, 1), b = middle(1, 2), c = middle(2, 0);
    for (const ConvexPolygon& part :
         {ConvexPolygon{3, {polygon.v[0], a, c}}, ConvexPolygon{3, {a, polygon.v[1], b}},
          ConvexPolygon{3, {c, b, polygon.v[2]}}, ConvexPolygon{3, {a, b, c}}}) {
      Divide(part, largest_m2, out);
    }
    return;
  }
  const int k =
      glm::length(polygon.v[1] - polygon.v[0]) >= glm::length(polygon.v[2] - polygon.v[1]) ? 0 : 1;
  const Vec3 a = middle(k, k + 1), b = middle(k + 2, (k + 3) % 4);
  Divide({4, {polygon.v[k], a, b, polygon.v[(k + 3) % 4]}}, largest_m2, out);
  Divide({4, {a, polygon.v[k + 1], polygon.v[k + 2], b}}, largest_m2, out);
}

}  // namespace

DenseReference::DenseReference(const Scene& scene, int patches, int rays, ThreadPool& pool)
    : scene_(scene), surfaces_(MakeSurfaces(scene)) {
  double total = 0;
  for (const Surface& s : surfaces_) total += SideGeometry(scene, s.polygon, s.side).Area();
  for (uint32_t s = 0; s < surfaces_.size(); ++s) {
    std::vector<ConvexPolygon> parts;
    Divide(SideGeometry(scene, surfaces_[s].polygon, surfaces_[s].side), total / patches, parts);
    for (const ConvexPolygon& part : parts) {
      patches_.push_back({s, part, part.Centroid(), part.Area(), surfaces_[s].exitance});
    }
  }
  const size_t n = patches_.size();
  std::vector<float> factors(n * n, 0);
  pool.For(n, 4, [&](size_t begin, size_t end, int) {
    for (size_t i = begin; i < end; ++i) {
      const Vec3 normal = patches_[i].polygon.Normal();
      const uint32_t own = surfaces_[patches_[i].surface].polygon;
      for (size_t j = 0; j < n; ++j) {
        const double f = FormFactor(patches_[i].centre, normal, patches_[j]);
        if (f <= 0) continue;
        factors[i * n + j] = static_cast<float>(
            f * Visibility(patches_[i].centre, own, patches_[j], rays, Hash(i, j)));
      }
    }
  });
  for (int sweep = 0; sweep < 60; ++sweep) {  // Gauss–Seidel
    for (size_t i = 0; i < n; ++i) {
      Rgb h(0.0);
      for (size_t j = 0; j < n; ++j)
        h += static_cast<double>(factors[i * n + j]) * patches_[j].radiosity;
      const Surface& surface = surfaces_[patches_[i].surface];
      patches_[i].radiosity = surface.exitance + surface.reflectance * h;
    }
  }
}

Rgb DenseReference::IrradianceAt(uint32_t surface, const Vec3& point, int rays,
                                 uint64_t seed) const {
  const Vec3 normal =
      SideGeometry(scene_, surfaces_[surface].polygon, surfaces_[surface].side).Normal();
  Rgb h(0.0);
  for (size_t j = 0; j < patches_.size(); ++j) {
    const double f = FormFactor(point, normal, patches_[j]);
    if (f <= 0) continue;
    h += f * Visibility(point, surfaces_[surface].polygon, patches_[j], rays, Hash(seed, j)) *
         patches_[j].radiosity;
  }
  return h;
}

// Lambert's sum over the edges of the part in front of the point's plane.
double DenseReference::FormFactor(const Vec3& point, const Vec3& normal, const Patch& patch) const {
  if (glm::dot(patch.polygon.Normal(), point - patch.centre) <= 1e-9) return 0;
  std::vector<Vec3> corners;
  for (int i = 0; i < patch.polygon.count; ++i) {
    const Vec3 a = patch.polygon.v[i] - point;
    const Vec3 b = patch.polygon.v[(i + 1) % patch.polygon.count] - point;
    const double ha = glm::dot(normal, a), hb = glm::dot(normal, b);
    if (ha >= 0) corners.push_back(a);
    if ((ha < 0) != (hb < 0)) corners.push_back(a + ha / (ha - hb) * (b - a));
  }
  double sum = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3& b = corners[(i + 1) % corners.size()];
    const Vec3 cross = glm::cross(a, b);
    const double length = glm::length(cross);
    if (length > 0) sum -= std::atan2(length, glm::dot(a, b)) * glm::dot(normal, cross) / length;
  }
  return std::max(0.0, sum / (2 * std::numbers::pi));
}

double DenseReference::Visibility(const Vec3& from, uint32_t from_polygon, const Patch& to,
                                  int rays, uint64_t seed) const {
  Random random(seed);
  int visible = 0;
  for (int k = 0; k < rays; ++k) {
    double u = random.Unit(), v = random.Unit();
    // Uniform in a triangle; a quad's two triangles by turns.
    const int first = to.polygon.count == 4 && k % 2 == 1 ? 2 : 1;
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Vec3 target = to.polygon.v[0] + u * (to.polygon.v[first] - to.polygon.v[0]) +
                        v * (to.polygon.v[first + 1] - to.polygon.v[0]);
    visible += Blocked(from, target, from_polygon, surfaces_[to.surface].polygon) ? 0 : 1;
  }
  return static_cast<double>(visible) / rays;
}

bool DenseReference::Blocked(const Vec3& from, const Vec3& to, uint32_t from_polygon,
                             uint32_t to_polygon) const {
  const Vec3 d = to - from;
  for (uint32_t p = 0; p < scene_.polygons.size(); ++p) {
    if (p == from_polygon || p == to_polygon) continue;
    const Polygon& polygon = scene_.polygons[p];
    for (int i = 1; i + 1 < polygon.vertex_count(); ++i) {
      const Vec3& a = scene_.vertices[polygon.vertices[0]];
      const Vec3 e1 = scene_.vertices[polygon.vertices[i]] - a;
      const Vec3 e2 = scene_.vertices[polygon.vertices[i + 1]] - a;
      const Vec3 h = glm::cross(d, e2);
      const double det = glm::dot(e1, h);
      if (det == 0) continue;
      const Vec3 s = from - a;
      const double u = glm::dot(s, h) / det;
      const Vec3 q = glm::cross(s, e1);
      const double v = glm::dot(d, q) / det;
      const double t = glm::dot(e2, q) / det;
      if (u >= 0 && v >= 0 && u + v <= 1 && t > 1e-9 && t < 1 - 1e-9) return true;
    }
  }
  return false;
}

}  // namespace isolux::testing
