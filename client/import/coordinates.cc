#include "client/import/coordinates.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace isolux {
namespace {

// Files print coordinates with five or six digits; a texel of 512 is 2e-3.
constexpr double kAgree = 1e-4;
constexpr double kFarthest = 1e5;    // coordinates beyond have lost their digits
constexpr double kMostPeriods = 64;  // of an image over a polygon; following them takes time
constexpr double kHair = 1e-6;       // of the larger gradient
constexpr size_t kMostMaps = 64;     // of one plane and material that polygons are compared with

glm::dvec2 Apply(const TextureCoordinates& c, const Vec3& p) {
  return {c.u[0] * p.x + c.u[1] * p.y + c.u[2] * p.z + c.u[3],
          c.v[0] * p.x + c.v[1] * p.y + c.v[2] * p.z + c.v[3]};
}

double Distance(const glm::dvec2& a, const glm::dvec2& b) {
  return std::max(std::abs(a.x - b.x), std::abs(a.y - b.y));
}

// The affine map of a triangle without a part along its normal.
std::optional<TextureCoordinates> OfTriangle(const std::array<Vec3, 3>& p,
                                             const std::array<glm::dvec2, 3>& t) {
  const Vec3 a = p[1] - p[0], b = p[2] - p[0];
  const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b);
  const double area2 = aa * bb - ab * ab;
  if (!(area2 > 1e-24 * aa * bb)) return std::nullopt;
  Vec3 gradient[2];
  for (int k = 0; k < 2; ++k) {
    const double da = t[1][k] - t[0][k], db = t[2][k] - t[0][k];
    gradient[k] = ((bb * da - ab * db) * a + (aa * db - ab * da) * b) / area2;
  }
  const double lengths[2] = {glm::length(gradient[0]), glm::length(gradient[1])};
  const double longer = std::max(lengths[0], lengths[1]);
  if (glm::length(glm::cross(gradient[0], gradient[1])) < kHair * longer * longer && longer > 0) {
    const int k = lengths[0] < lengths[1] ? 0 : 1;
    const Vec3 across = glm::cross(glm::cross(a, b), gradient[1 - k]);
    gradient[k] += kHair * longer * glm::normalize(across);
  }
  TextureCoordinates c;
  for (int i = 0; i < 3; ++i) {
    c.u[i] = gradient[0][i];
    c.v[i] = gradient[1][i];
  }
  c.u[3] = t[0].x - glm::dot(gradient[0], p[0]);
  c.v[3] = t[0].y - glm::dot(gradient[1], p[0]);
  return c;
}

bool SameOn(const ConvexPolygon& shape, const TextureCoordinates& a, const TextureCoordinates& b) {
  for (int i = 0; i < shape.count; ++i) {
    if (Distance(Apply(a, shape.v[i]), Apply(b, shape.v[i])) > kAgree) return false;
  }
  return true;
}

}  // namespace

std::optional<TextureCoordinates> FitCoordinates(const ConvexPolygon& shape,
                                                 std::span<const glm::dvec2> corners) {
  for (const glm::dvec2& corner : corners) {
    if (!(std::abs(corner.x) < kFarthest && std::abs(corner.y) < kFarthest)) return std::nullopt;
  }
  const auto fit =
      OfTriangle({shape.v[0], shape.v[1], shape.v[2]}, {corners[0], corners[1], corners[2]});
  if (!fit || shape.count == 3) return fit;
  if (Distance(Apply(*fit, shape.v[3]), corners[3]) > kAgree) return std::nullopt;
  return fit;
}

bool IsUsable(const ConvexPolygon& shape, const TextureCoordinates& coordinates,
              const Material& material) {
  for (const TextureUse* use : {&material.reflectance_map, &material.exitance_map}) {
    if (use->texture == kNoTexture) continue;
    glm::dvec2 low(kFarthest), high(-kFarthest);
    for (int i = 0; i < shape.count; ++i) {
      const glm::dvec2 c = Apply(coordinates, shape.v[i]);
      const auto& t = use->transform;
      const glm::dvec2 image(t[0] * c.x + t[1] * c.y + t[2], t[3] * c.x + t[4] * c.y + t[5]);
      low = {std::min(low.x, image.x), std::min(low.y, image.y)};
      high = {std::max(high.x, image.x), std::max(high.y, image.y)};
    }
    if (!(high.x - low.x <= kMostPeriods && high.y - low.y <= kMostPeriods)) return false;
    if (std::max({-low.x, -low.y, high.x, high.y}) >= kFarthest) return false;
  }
  return true;
}

void UnifyCoordinates(Scene* scene, const std::vector<uint32_t>& plane_of) {
  std::map<std::tuple<uint32_t, uint32_t, uint8_t>, std::vector<uint32_t>> known;  // polygons
  for (uint32_t p = 0; p < scene->polygons.size(); ++p) {
    Polygon& polygon = scene->polygons[p];
    if (polygon.coordinates == kNoCoordinates) continue;
    auto& firsts = known[{plane_of[p], polygon.material, polygon.sides}];
    const TextureCoordinates& own = scene->coordinates[polygon.coordinates];
    const ConvexPolygon shape = SideGeometry(*scene, p, Side::kFront);
    const auto same = std::find_if(firsts.begin(), firsts.end(), [&](uint32_t first) {
      const TextureCoordinates& other = scene->coordinates[scene->polygons[first].coordinates];
      return SameOn(shape, own, other) &&
             SameOn(SideGeometry(*scene, first, Side::kFront), own, other);
    });
    if (same != firsts.end()) {
      polygon.coordinates = scene->polygons[*same].coordinates;
    } else if (firsts.size() < kMostMaps) {
      firsts.push_back(p);
    }
  }
}

}  // namespace isolux
