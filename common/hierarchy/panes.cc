#include "common/hierarchy/panes.h"

#include <algorithm>
#include <cmath>

#include "common/scene/effects_plan.h"

namespace isolux {
namespace {

// Of the scene's extent: nearer to a pane than this is on it, and points so far outside its border
// still within it, lest light slip between two that join. Packets of rays have coordinates in
// single precision.
constexpr double kTolerance = 1e-7;

// One glass for three channels: the mean of what it leaves.
Glass GreyGlass(const Glass& glass) {
  if (glass.is_grey()) return glass;
  Rgb left;
  for (int c = 0; c < 3; ++c) left[c] = ExpOfMinus(glass.optical_depth[c]);
  return {Rgb(OpticalDepthOf(GreyOf(left))), glass.index};
}

// Where a segment crosses a pane.
struct Met {
  double share = 0;  // of the segment that is behind
  uint32_t plane = 0;
};

constexpr size_t kMostMet = 64;

// What a glass leaves is tabled by steps of the cosine, between which it is linear within 1e-5.
constexpr uint32_t kSteps = 1024;

}  // namespace

Panes::Panes(const Glazing& glazing, double extent_m, bool grey)
    : glasses_(glazing.glasses), tolerance_m_(kTolerance * extent_m) {
  if (grey) {
    for (Glass& glass : glasses_) glass = GreyGlass(glass);
  }
  grey_ = std::ranges::all_of(glasses_, &Glass::is_grey);
  for (const Glass& glass : glasses_) {
    for (uint32_t i = 0; i <= kSteps; ++i) {
      left_.push_back(glass.Transmittance(static_cast<double>(i) / kSteps));
    }
  }
  std::vector<Bounds3> boxes;
  for (const Pane& pane : glazing.panes) {
    const std::span<const Vec3> corners(pane.corners.data(), pane.count);
    const ConvexPolygon shape = ShapeOf(pane);
    Plane plane;
    plane.normal = shape.Normal();
    plane.point = shape.Centroid();
    plane.first = static_cast<uint32_t>(corners_.size());
    plane.count = pane.count;
    plane.glass = pane.glass;
    plane.is_half = pane.is_half;
    Bounds3 box;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Vec3 side = corners[(i + 1) % corners.size()] - corners[i];
      corners_.push_back(corners[i]);
      const double length = glm::length(side);
      inwards_.push_back(length > 0 ? glm::cross(plane.normal, side / length) : Vec3(0.0));
      box.Add(corners[i]);
    }
    planes_.push_back(plane);
    boxes.push_back(Widened(box, 2 * tolerance_m_));
  }
  tree_.emplace(boxes);
}

Rgb Panes::Left(uint32_t glass, double cosine) const {
  const double at = std::min(cosine, 1.0) * kSteps;
  const auto step = std::min(static_cast<uint32_t>(at), kSteps - 1);
  const Rgb* left = &left_[size_t{glass} * (kSteps + 1) + step];
  return left[0] + (at - step) * (left[1] - left[0]);
}

bool Panes::Holds(const Plane& plane, const Vec3& x) const {
  for (uint32_t i = plane.first; i < plane.first + plane.count; ++i) {
    if (glm::dot(inwards_[i], x - corners_[i]) < -tolerance_m_) return false;
  }
  return true;
}

Rgb Panes::Along(const Vec3& from, const Vec3& to) const {
  std::array<Met, kMostMet> met;
  size_t count = 0;
  tree_->ForEachAlong(from, to, [&](uint32_t p) {
    const Plane& plane = planes_[p];
    const double here = HeightOf(plane, from), there = HeightOf(plane, to);
    const bool across = (here > tolerance_m_ && there < -tolerance_m_) ||
                        (here < -tolerance_m_ && there > tolerance_m_);
    if (!across || count == kMostMet) return;
    const double share = here / (here - there);
    if (Holds(plane, from + share * (to - from))) met[count++] = {share, p};
  });
  if (count == 0) return Rgb(1.0);
  std::sort(met.begin(), met.begin() + static_cast<ptrdiff_t>(count),
            [](const Met& a, const Met& b) {
              return a.share != b.share ? a.share < b.share : a.plane < b.plane;
            });
  const double length = glm::length(to - from);
  const Vec3 direction = (to - from) / length;
  Rgb left(1.0);
  for (size_t i = 0; i < count; ++i) {
    const Plane& plane = planes_[met[i].plane];
    if (i > 0) {
      const Plane& before = planes_[met[i - 1].plane];
      const bool same_place = (met[i].share - met[i - 1].share) * length <= 2 * tolerance_m_;
      if (same_place && std::abs(HeightOf(plane, before.point)) <= 2 * tolerance_m_ &&
          std::abs(HeightOf(before, plane.point)) <= 2 * tolerance_m_) {
        continue;
      }
    }
    const Rgb one = Left(plane.glass, std::abs(glm::dot(plane.normal, direction)));
    left *= plane.is_half ? glm::sqrt(one) : one;
  }
  return left;
}

Rgb Panes::Along(const Vec3& from, const Vec3& to, const MirrorImage& image) const {
  Rgb left(1.0);
  Vec3 at = from;
  for (const MirrorOpening& opening : image.openings) {
    const double before = opening.HeightOf(from), behind = -opening.HeightOf(to);
    if (!(before > 0 && behind > 0)) return left;  // no light goes that way
    const Vec3 point = opening.to_scene.Point(from + before / (before + behind) * (to - from));
    left *= Along(at, point);
    at = point;
  }
  return left * Along(at, image.back.Point(to));
}

Crossing Panes::Across(const Plane& plane, std::span<const Vec3> here,
                       std::span<const Vec3> there) const {
  double low_here = std::numeric_limits<double>::infinity(), high_here = -low_here;
  double low_there = low_here, high_there = -low_here;
  for (const Vec3& x : here) {
    low_here = std::min(low_here, HeightOf(plane, x));
    high_here = std::max(high_here, HeightOf(plane, x));
  }
  for (const Vec3& y : there) {
    low_there = std::min(low_there, HeightOf(plane, y));
    high_there = std::max(high_there, HeightOf(plane, y));
  }
  if (std::min(low_here, low_there) >= -tolerance_m_) return Crossing::kNone;
  if (std::max(high_here, high_there) <= tolerance_m_) return Crossing::kNone;
  const bool apart = (low_here >= -tolerance_m_ && high_there <= tolerance_m_) ||
                     (high_here <= tolerance_m_ && low_there >= -tolerance_m_);
  if (!apart) return Crossing::kSome;
  // What crosses the plane is in the hull of where lines from corner to corner cross it.
  bool all = true;
  for (uint32_t i = plane.first; i < plane.first + plane.count; ++i) {
    bool outside = true;
    for (const Vec3& x : here) {
      const double before = std::abs(HeightOf(plane, x));
      for (const Vec3& y : there) {
        const double behind = std::abs(HeightOf(plane, y));
        const double share = before + behind > 0 ? before / (before + behind) : 0.5;
        const double inside_m = glm::dot(inwards_[i], x + share * (y - x) - corners_[i]);
        all = all && inside_m >= -tolerance_m_;
        outside = outside && inside_m <= -tolerance_m_;
      }
    }
    if (outside) return Crossing::kNone;
  }
  return all ? Crossing::kAll : Crossing::kSome;
}

Crossing Panes::Between(std::span<const Vec3> here, std::span<const Vec3> there) const {
  Bounds3 box;
  for (const Vec3& x : here) box.Add(x);
  for (const Vec3& y : there) box.Add(y);
  Crossing result = Crossing::kNone;
  tree_->ForEachOverlap(box, [&](uint32_t p) {
    if (result == Crossing::kSome) return;
    const Crossing of_pane = Across(planes_[p], here, there);
    if (of_pane != Crossing::kNone) result = of_pane;
  });
  return result;
}

}  // namespace isolux
