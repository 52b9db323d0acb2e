#include "client/import/covered.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/hierarchy/planes.h"
#include "common/hierarchy/regions.h"
#include "common/scene/box_tree.h"
#include "common/scene/plane_frame.h"

namespace isolux {
namespace {

// A gap below this share of the contact tolerance may be rounding: two coordinates printed with six
// digits differ by up to 2.8e-6 of the extent, of which the tolerance is 5e-6.
constexpr double kMeasuredGap = 0.6;
constexpr double kWholly = 0.999;        // share of the area from which a side counts as covered
constexpr double kSameSize = 0.99;       // of two sheets
constexpr double kSameDirection = 1e-2;  // sine between touching polygons

using Flat = std::vector<Point2>;

double Area(const Flat& polygon) {
  double twice = 0;
  for (size_t i = 1; i + 1 < polygon.size(); ++i) {
    twice += Cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  }
  return 0.5 * twice;
}

// What of `polygon` lies in the convex counter-clockwise `window`.
Flat Clip(Flat polygon, const Flat& window) {
  for (size_t w = 0; w < window.size() && !polygon.empty(); ++w) {
    const Point2& from = window[w];
    const Point2 along = window[(w + 1) % window.size()] - from;
    Flat kept;
    for (size_t i = 0; i < polygon.size(); ++i) {
      const Point2& a = polygon[i];
      const Point2& b = polygon[(i + 1) % polygon.size()];
      const double da = Cross(along, a - from), db = Cross(along, b - from);
      if (da >= 0) kept.push_back(a);
      if ((da > 0 && db < 0) || (da < 0 && db > 0)) kept.push_back(a + (da / (da - db)) * (b - a));
    }
    polygon = std::move(kept);
  }
  return polygon;
}

// `slack`: twice an area, by which p may lie outside.
bool Holds(const Flat& polygon, const Point2& p, double slack) {
  for (size_t i = 0; i < polygon.size(); ++i) {
    if (Cross(polygon[(i + 1) % polygon.size()] - polygon[i], p - polygon[i]) < -slack)
      return false;
  }
  return true;
}

class Coverer {
 public:
  Coverer(const Sheets& sheets, std::span<const uint32_t> source, const Scene& scene)
      : sheets_(sheets),
        source_(source),
        scene_(scene),
        extent_(ExtentOf(scene)),
        boxes_(BoxesOf(scene)),
        tree_(boxes_) {}

  // Whether the front and the back of a polygon are covered.
  std::array<bool, 2> Of(uint32_t p) const {
    const ConvexPolygon shape = SideGeometry(scene_, p, Side::kFront);
    const Vec3 normal = shape.Normal();
    const PlaneFrame frame(shape.Centroid(), normal);
    Flat own;
    for (int i = 0; i < shape.count; ++i) own.push_back(frame.Flat(shape.v[i]));
    const double area = Area(own), size = boxes_[p].Diagonal();
    std::array<Cover, 2> covers;
    tree_.ForEachOverlap(Widened(boxes_[p], ContactTolerance(extent_, size)), [&](uint32_t q) {
      if (q == p) return;
      const ConvexPolygon other = SideGeometry(scene_, q, Side::kFront);
      const double tolerance = ContactTolerance(extent_, std::min(size, boxes_[q].Diagonal()));
      double height = 0;
      for (int i = 0; i < other.count; ++i) {
        const double h = frame.Height(other.v[i]);
        if (std::abs(h) > tolerance) return;
        height += h / other.count;
      }
      const Vec3 direction = other.Normal();
      if (glm::length(glm::cross(direction, normal)) > kSameDirection) return;
      const bool reversed = glm::dot(direction, normal) < 0;
      Flat window;
      for (int i = 0; i < other.count; ++i) window.push_back(frame.Flat(other.v[i]));
      if (reversed) std::reverse(window.begin(), window.end());
      const double common = Area(Clip(own, window));
      if (common <= 1e-6 * area) return;
      const bool in_front = std::abs(height) > kMeasuredGap * tolerance
                                ? height > 0
                                : LiesInFront(p, q, normal, reversed);
      Cover& cover = covers[in_front ? 0 : 1];
      cover.area += common;
      cover.windows.push_back(std::move(window));
    });
    return {IsWhole(own, area, covers[0]), IsWhole(own, area, covers[1])};
  }

 private:
  struct Cover {
    double area = 0;
    std::vector<Flat> windows;
  };

  static std::vector<Bounds3> BoxesOf(const Scene& scene) {
    std::vector<Bounds3> boxes;
    for (uint32_t p = 0; p < scene.polygons.size(); ++p) boxes.push_back(BoundsOf(scene, p));
    return boxes;
  }

  // Covers may overlap each other, so their areas alone do not tell: points inside must be covered,
  // too.
  static bool IsWhole(const Flat& own, double area, const Cover& cover) {
    if (cover.area < kWholly * area) return false;
    Point2 centre;
    for (const Point2& p : own) centre = centre + (1.0 / static_cast<double>(own.size())) * p;
    const auto covered = [&](const Point2& p) {
      return std::any_of(cover.windows.begin(), cover.windows.end(),
                         [&](const Flat& window) { return Holds(window, p, 1e-9 * area); });
    };
    if (!covered(centre)) return false;
    for (size_t i = 0; i < own.size(); ++i) {
      const Point2 middle = 0.5 * (own[i] + own[(i + 1) % own.size()]);
      for (const double share : {0.5, 0.99}) {
        if (!covered(centre + share * (own[i] - centre))) return false;
        if (!covered(centre + share * (middle - centre))) return false;
      }
    }
    return true;
  }

  // For polygons without a measurable gap: whether q is on the front side of p.
  bool LiesInFront(uint32_t p, uint32_t q, const Vec3& normal, bool reversed) const {
    const uint32_t a = sheets_.sheet_of[source_[p]], b = sheets_.sheet_of[source_[q]];
    const Sheet& mine = sheets_.sheets[a];
    const Sheet& its = sheets_.sheets[b];
    const auto side = [&](const Sheet& sheet) {  // of p's front, where the body is
      return glm::dot(sheet.normal, normal) < 0 ? -sheet.body : sheet.body;
    };
    const bool smaller = its.area_m2 < kSameSize * mine.area_m2;
    const bool larger = mine.area_m2 < kSameSize * its.area_m2;
    if (smaller && side(its) != 0) return side(its) > 0;
    if (larger && side(mine) != 0) return side(mine) < 0;
    if (reversed) return false;  // back to back
    if (smaller || larger) return smaller;
    return source_[q] < source_[p];  // as good as copies: the first is seen
  }

  const Sheets& sheets_;
  std::span<const uint32_t> source_;
  const Scene& scene_;
  double extent_;
  std::vector<Bounds3> boxes_;
  BoxTree tree_;
};

// On which sides of its plane the neighbours of each sheet stand.
void FindBodies(const Scene& scene, double extent, Sheets* sheets, std::span<const Vec3> points) {
  // Which sheets have a vertex.
  std::vector<std::vector<uint32_t>> at(scene.vertices.size());
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    for (int i = 0; i < polygon.vertex_count(); ++i) {
      std::vector<uint32_t>& here = at[polygon.vertices[i]];
      const uint32_t sheet = sheets->sheet_of[p];
      if (std::find(here.begin(), here.end(), sheet) == here.end()) here.push_back(sheet);
    }
  }
  std::vector<uint8_t> sides(sheets->sheets.size(), 0);  // 1: above, 2: below
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    const int count = polygon.vertex_count();
    const double tolerance = ContactTolerance(extent, BoundsOf(scene, p).Diagonal());
    for (int i = 0; i < count; ++i) {
      const auto& next = at[polygon.vertices[(i + 1) % count]];
      for (const uint32_t s : at[polygon.vertices[i]]) {
        if (s == sheets->sheet_of[p] || std::find(next.begin(), next.end(), s) == next.end())
          continue;
        for (int k = 0; k < count; ++k) {
          const double height =
              glm::dot(sheets->sheets[s].normal, scene.vertices[polygon.vertices[k]] - points[s]);
          if (height > 2 * tolerance) sides[s] |= 1;
          if (height < -2 * tolerance) sides[s] |= 2;
        }
      }
    }
  }
  for (size_t s = 0; s < sides.size(); ++s) {
    sheets->sheets[s].body = sides[s] == 1 ? 1 : sides[s] == 2 ? -1 : 0;
  }
}

}  // namespace

Sheets FindSheets(const Scene& scene, std::span<const uint32_t> plane_of) {
  const auto [loops, normals, areas] = OrientAlike(scene, plane_of);
  const std::vector<uint64_t> key(plane_of.begin(), plane_of.end());
  Sheets sheets;
  sheets.sheet_of.resize(loops.size());
  std::vector<Vec3> points;
  for (const Region& region : FindRegions(scene, loops, key, normals)) {
    const uint32_t first = region.polygons[0];
    double area = 0;
    for (const uint32_t p : region.polygons) {
      area += areas[p];
      sheets.sheet_of[p] = static_cast<uint32_t>(sheets.sheets.size());
    }
    sheets.sheets.push_back({area, normals[first], 0});
    points.push_back(SideGeometry(scene, first, Side::kFront).Centroid());
  }
  FindBodies(scene, ExtentOf(scene), &sheets, points);
  return sheets;
}

Uncovered DropCoveredSides(const Sheets& sheets, std::span<const uint32_t> source, Scene* scene) {
  const Coverer coverer(sheets, source, *scene);
  Uncovered result;
  std::vector<uint8_t> kept(scene->polygons.size());
  for (uint32_t p = 0; p < kept.size(); ++p) {
    kept[p] = scene->polygons[p].sides;
    const auto [front, back] = coverer.Of(p);
    const auto drop = [&](uint8_t flags, uint8_t mark) {
      if ((kept[p] & flags) != 0 && result.sides++ == 0) result.first_polygon = p;
      kept[p] = static_cast<uint8_t>((kept[p] & ~flags) | mark);
    };
    if (front) drop(kFrontTakesPart | kFrontEmits, kFrontCovered);
    if (back) drop(kBackTakesPart | kBackEmits, kBackCovered);
  }
  for (uint32_t p = 0; p < kept.size(); ++p) scene->polygons[p].sides = kept[p];
  return result;
}

}  // namespace isolux
