#include <algorithm>

#include "common/hierarchy/mirrors.h"

namespace isolux {
namespace {

// Whether all of the points are inside one mirror of the plane, or all outside each of them by one
// of its sides.
Passage PassageOf(const Mirrors& mirrors, uint32_t plane, std::span<const Vec3> points) {
  const MirrorPlane& of = mirrors.planes()[plane];
  Passage passage = Passage::kNone;
  for (const uint32_t s : of.surfaces) {
    const ConvexPolygon& polygon = mirrors.geometry(s);
    bool all = true, none = false;
    for (int i = 0; i < polygon.count && !none; ++i) {
      const Vec3 along = glm::normalize(polygon.v[(i + 1) % polygon.count] - polygon.v[i]);
      const Vec3 inwards = glm::cross(of.normal, along);
      bool outside = true;
      for (const Vec3& point : points) {
        const double inside_m = glm::dot(inwards, point - polygon.v[i]);
        all = all && inside_m >= -mirrors.tolerance_m();
        outside = outside && inside_m <= 0;
      }
      none = outside;
    }
    if (none) continue;
    if (all) return Passage::kAll;
    passage = Passage::kSome;
  }
  return passage;
}

}  // namespace

Passage PassageThrough(const Mirrors& mirrors, std::span<const MirrorOpening> openings,
                       std::span<const Vec3> here, std::span<const Vec3> there) {
  Passage passage = Passage::kAll;
  std::vector<Vec3> points;
  for (const MirrorOpening& opening : openings) {
    double highest = -mirrors.tolerance_m(), lowest = -highest;
    bool across = false;
    for (const Vec3& x : here) {
      highest = std::max(highest, opening.HeightOf(x));
      across = across || opening.HeightOf(x) < -mirrors.tolerance_m();
    }
    for (const Vec3& y : there) {
      lowest = std::min(lowest, opening.HeightOf(y));
      across = across || opening.HeightOf(y) > mirrors.tolerance_m();
    }
    if (highest <= mirrors.tolerance_m() || lowest >= -mirrors.tolerance_m()) return Passage::kNone;
    if (across) {
      passage = Passage::kSome;
      continue;
    }
    // All that passes is in the hull of where lines from corner to corner pass.
    points.clear();
    for (const Vec3& x : here) {
      const double before = std::max(0.0, opening.HeightOf(x));
      for (const Vec3& y : there) {
        const double behind = std::max(0.0, -opening.HeightOf(y));
        const double share = before + behind > 0 ? before / (before + behind) : 0.5;
        points.push_back(opening.to_scene.Point(x + share * (y - x)));
      }
    }
    const Passage here_passes = PassageOf(mirrors, opening.plane, points);
    if (here_passes == Passage::kNone) return Passage::kNone;
    if (here_passes == Passage::kSome) passage = Passage::kSome;
  }
  return passage;
}

}  // namespace isolux
