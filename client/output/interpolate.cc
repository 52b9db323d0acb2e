#include "client/output/interpolate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isolux {
namespace {

// Cutting ears takes time with the square of the vertices: with more, a fan must do.
constexpr size_t kMostForEars = 4096;
constexpr double kNothing = 1e-12;  // of the polygon's area

// Twice the signed area about the normal.
double Cross(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal) {
  return glm::dot(glm::cross(b - a, c - a), normal);
}

// 1 for an equilateral triangle, 0 for a line.
double Roundness(const Vec3& a, const Vec3& b, const Vec3& c, double twice_area) {
  const double longest2 =
      std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
  return longest2 > 0 ? twice_area / (0.8660254037844386 * longest2) : 0;
}

std::vector<std::array<uint32_t, 3>> Fan(size_t count) {
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 1; i + 1 < count; ++i) triangles.push_back({0, i, i + 1});
  return triangles;
}

Vec3 UnitNormal(std::span<const Vec3> polygon) {
  Vec3 sum(0.0);
  for (size_t i = 1; i + 1 < polygon.size(); ++i) {
    sum += glm::cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  }
  const double length = glm::length(sum);
  return length > 0 ? sum / length : Vec3(0.0);
}

}  // namespace

void MeanValueWeights(std::span<const Vec3> polygon, const Vec3& point, std::span<double> weights) {
  const size_t n = polygon.size();
  std::fill(weights.begin(), weights.end(), 0.0);
  const Vec3 normal = UnitNormal(polygon);
  double total = 0;
  Vec3 d = polygon[0] - point;
  double r = glm::length(d);
  for (size_t i = 0; i < n; ++i) {
    const size_t j = i + 1 < n ? i + 1 : 0;
    const Vec3 e = polygon[j] - point;
    const double s = glm::length(e);
    const double sine = glm::dot(glm::cross(d, e), normal), cosine = glm::dot(d, e);
    const double denominator = r * s + cosine;
    if (denominator <= 1e-13 * glm::dot(e - d, e - d)) {
      // On this side (or at one of its ends): linear along it.
      std::fill(weights.begin(), weights.end(), 0.0);
      const double sum = r + s;
      weights[i] = sum > 0 ? s / sum : 1;
      weights[j] += sum > 0 ? r / sum : 0;
      return;
    }
    const double half_tangent = sine / denominator;
    weights[i] += half_tangent / r;
    weights[j] += half_tangent / s;
    total += half_tangent / r + half_tangent / s;
    d = e;
    r = s;
  }
  if (!(std::abs(total) > 0) || !std::isfinite(total)) {
    std::fill(weights.begin(), weights.end(), 1.0 / static_cast<double>(n));  // a face without area
    return;
  }
  // Rounding, or a point a little outside, may leave a weight slightly negative.
  double sum = 0;
  for (double& weight : weights) sum += weight = std::max(0.0, weight / total);
  for (double& weight : weights) weight /= sum;
}

std::vector<std::array<uint32_t, 3>> Triangulate(std::span<const Vec3> polygon) {
  const size_t n = polygon.size();
  if (n <= 3 || n > kMostForEars) return Fan(n);
  const Vec3 normal = UnitNormal(polygon);
  std::vector<uint32_t> ring(n);
  std::iota(ring.begin(), ring.end(), 0U);
  double left = 0;
  for (size_t i = 1; i + 1 < n; ++i) left += Cross(polygon[0], polygon[i], polygon[i + 1], normal);
  const double nothing = kNothing * left;

  std::vector<std::array<uint32_t, 3>> triangles;
  while (ring.size() > 3) {
    // An ear must have an area and leave one: what remains must not be a line.
    size_t best = ring.size();
    double best_roundness = -1, best_area = 0;
    for (size_t i = 0; i < ring.size(); ++i) {
      const Vec3& a = polygon[ring[(i + ring.size() - 1) % ring.size()]];
      const Vec3& b = polygon[ring[i]];
      const Vec3& c = polygon[ring[(i + 1) % ring.size()]];
      const double area = Cross(a, b, c, normal);
      if (area <= nothing || left - area <= nothing) continue;
      const double roundness = Roundness(a, b, c, area);
      if (roundness > best_roundness) {
        best = i;
        best_roundness = roundness;
        best_area = area;
      }
    }
    if (best == ring.size()) best = 0;  // a line already: any will do
    triangles.push_back(
        {ring[(best + ring.size() - 1) % ring.size()], ring[best], ring[(best + 1) % ring.size()]});
    left -= best_area;
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(best));
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return triangles;
}

}  // namespace isolux
