#include "worker/visibility/shaft.h"

#include <algorithm>
#include <cmath>

#include "common/util/check.h"

namespace isolux {
namespace {

// A side plane is spanned by an edge and a corner of the other end. Where that corner is nearer to
// the edge's line than this share of the shaft's size, rounding turns the plane noticeably, and it
// is left out: the hull only grows.
constexpr double kSteadyPlane = 1e-6;

}  // namespace

Shaft::Shaft(const ShaftEnd& p, const ShaftEnd& q, double tolerance_m)
    : p_count_(static_cast<int>(p.corners.size())),
      count_(static_cast<int>(p.corners.size() + q.corners.size())),
      p_region_(p.region),
      q_region_(q.region),
      p_plane_(p.plane),
      q_plane_(q.plane),
      tolerance_m_(tolerance_m) {
  CHECK(p.corners.size() <= ShaftEnd::kMaxCorners && q.corners.size() <= ShaftEnd::kMaxCorners);
  std::copy(p.corners.begin(), p.corners.end(), corners_.begin());
  std::copy(q.corners.begin(), q.corners.end(), corners_.begin() + p_count_);
  for (int i = 0; i < count_; ++i) bounds_.Add(corners_[i]);
  planes_[plane_count_++] = {-p.normal, -glm::dot(p.normal, p.corners[0])};
  planes_[plane_count_++] = {-q.normal, -glm::dot(q.normal, q.corners[0])};
  AddSides(p.corners, p.normal, q.corners);
  AddSides(q.corners, q.normal, p.corners);
}

// Through each edge of `base` there is one plane with both ends behind it: that through the corner
// of `other` which the plane meets first when it turns inwards about the edge. In the plane square
// to the edge a corner is at (outward, height), and the largest outward / height is met first.
void Shaft::AddSides(std::span<const Vec3> base, const Vec3& normal, std::span<const Vec3> other) {
  const double steady = kSteadyPlane * bounds_.Diagonal();
  for (size_t i = 0; i < base.size(); ++i) {
    const Vec3& a = base[i];
    const Vec3 edge = base[i + 1 < base.size() ? i + 1 : 0] - a;
    Vec3 out = glm::cross(edge, normal);
    const double length = glm::length(out);
    if (length == 0) continue;
    out /= length;
    double outward = 0, height = 0;
    bool found = false;
    for (const Vec3& corner : other) {
      const double u = glm::dot(out, corner - a);
      const double h = std::max(0.0, glm::dot(normal, corner - a));
      // On the base's plane, on the edge's line or on the inner side of it: behind any such plane.
      if (u <= tolerance_m_ && h <= tolerance_m_) continue;
      if (found && u * height <= outward * h) continue;
      outward = u;
      height = h;
      found = true;
    }
    const double distance = std::sqrt(outward * outward + height * height);
    if (!found || distance < steady) continue;
    HalfSpace plane;
    plane.normal = (height * out - outward * normal) / distance;
    plane.offset = glm::dot(plane.normal, a);
    planes_[plane_count_++] = plane;
  }
}

bool Shaft::MayTouch(const Bounds3& box) const {
  for (int d = 0; d < 3; ++d) {
    if (box.low[d] > bounds_.high[d] || box.high[d] < bounds_.low[d]) return false;
  }
  const Vec3 centre = box.Centre(), half = 0.5 * box.Extent();
  for (int i = 0; i < plane_count_; ++i) {
    const HalfSpace& plane = planes_[i];
    const double nearest = glm::dot(plane.normal, centre) - glm::dot(glm::abs(plane.normal), half);
    if (nearest > plane.offset) return false;
  }
  return true;
}

Verdict Shaft::Classify(const OccluderSet& set, const Occluder& occluder) const {
  if (occluder.region != kNoRegion &&
      (occluder.region == p_region_ || occluder.region == q_region_)) {
    return Verdict::kOutside;
  }
  if (occluder.plane != kNoRegion && (occluder.plane == p_plane_ || occluder.plane == q_plane_)) {
    return Verdict::kOutside;
  }
  for (int d = 0; d < 3; ++d) {
    if (occluder.bounds.low[d] >= bounds_.high[d] - tolerance_m_ ||
        occluder.bounds.high[d] <= bounds_.low[d] + tolerance_m_) {
      return Verdict::kOutside;
    }
  }
  // Both ends on one side of the occluder's plane.
  bool above = false, below = false;
  for (int i = 0; i < count_ && !(above && below); ++i) {
    const double height = occluder.Height(corners_[i]);
    above |= height > occluder.tolerance_m;
    below |= height < -occluder.tolerance_m;
  }
  if (!above || !below) return Verdict::kOutside;
  const auto corners = set.corners(occluder);
  for (int i = 0; i < plane_count_; ++i) {
    const double limit = planes_[i].offset - occluder.tolerance_m;
    bool beyond = true;
    for (const Vec3& corner : corners) {
      if (glm::dot(planes_[i].normal, corner) < limit) {
        beyond = false;
        break;
      }
    }
    if (beyond) return Verdict::kOutside;
  }
  return BlocksAll(set, occluder) ? Verdict::kBlocks : Verdict::kPartial;
}

// A convex polygon whose plane has one end on either side crosses every segment if and only if it
// crosses those between corners: the crossing of any segment is a convex combination of theirs,
//   crossing(x, y) = Σ_ij a_i b_j (p_i + q_j) c_ij / (p + q)   for x = Σ a_i v_i, y = Σ b_j w_j,
// p_i and q_j the distances of corners from the plane, c_ij the crossing of v_i w_j. Corners on the
// plane are allowed: a c_ij with p_i = q_j = 0 has no weight.
bool Shaft::BlocksAll(const OccluderSet& set, const Occluder& occluder) const {
  std::array<double, 2 * ShaftEnd::kMaxCorners> height;
  double most_p = 0, most_q = 0;
  for (int i = 0; i < count_; ++i) {
    height[i] = occluder.Height(corners_[i]);
    double& most = i < p_count_ ? most_p : most_q;
    if (std::abs(height[i]) > std::abs(most)) most = height[i];
  }
  if (!(most_p * most_q < 0)) return false;
  const double sign = most_p > 0 ? 1 : -1;
  for (int i = 0; i < count_; ++i) {
    height[i] *= i < p_count_ ? sign : -sign;  // now a distance on the end's own side
    if (height[i] < -occluder.tolerance_m) return false;
    height[i] = std::max(height[i], 0.0);
  }
  const auto corners = set.corners(occluder);
  const auto inwards = set.inwards(occluder);
  const auto beyond = [&](int i, int j, double inside_i, double inside_j) {
    const double sum = height[i] + height[j];
    return sum > occluder.tolerance_m &&
           height[j] * inside_i + height[i] * inside_j < -tolerance_m_ * sum;
  };
  // One segment alone first: most that do not block miss it.
  for (size_t k = 0; k < corners.size(); ++k) {
    if (beyond(0, p_count_, glm::dot(inwards[k], corners_[0] - corners[k]),
               glm::dot(inwards[k], corners_[p_count_] - corners[k]))) {
      return false;
    }
  }
  for (size_t k = 0; k < corners.size(); ++k) {
    std::array<double, 2 * ShaftEnd::kMaxCorners> inside;
    for (int i = 0; i < count_; ++i) inside[i] = glm::dot(inwards[k], corners_[i] - corners[k]);
    for (int i = 0; i < p_count_; ++i) {
      for (int j = p_count_; j < count_; ++j) {
        if (beyond(i, j, inside[i], inside[j])) return false;
      }
    }
  }
  return true;
}

bool Shaft::Filter(const OccluderSet& set, std::span<const uint32_t> candidates,
                   std::vector<uint32_t>* kept) const {
  for (const uint32_t i : candidates) {
    const Verdict verdict = Classify(set, set[i]);
    if (verdict == Verdict::kBlocks) return true;
    if (verdict == Verdict::kPartial) kept->push_back(i);
  }
  return false;
}

}  // namespace isolux
