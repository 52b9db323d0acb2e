#include "worker/visibility/clipped_factor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/coupling/lanes.h"

namespace isolux {
namespace {

double Size(const Vec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

// Edges a → b of polygons about the origin, four at a time; Lambert's sum over them.
class EdgeSum {
 public:
  explicit EdgeSum(const Vec3& n) : n_(n) {}

  void Add(const Vec3& a, const Vec3& b) {
    a_[count_] = a;
    b_[count_] = b;
    if (++count_ == 4) Flush();
  }

  double Total() {
    while (count_ != 0) Add(Vec3(0.0), Vec3(0.0));
    return (sum_[0] + sum_[1]) + (sum_[2] + sum_[3]);
  }

 private:
  void Flush() {
    const Vec3x4 a(a_), b(b_);
    const Vec3x4 cross = Cross(a, b);
    const Lanes length = SquareRoot(Dot(cross, cross));
    const Lanes angle = Atan2Upper(length, Dot(a, b));
    const Lanes term = angle * Dot(n_, cross) / Select(length == 0.0, Splat(1.0), length);
    sum_ += Select(length == 0.0, Splat(0.0), term);
    count_ = 0;
  }

  Vec3 n_;
  std::array<Vec3, 4> a_{}, b_{};
  int count_ = 0;
  Lanes sum_ = Splat(0.0);
};

}  // namespace

bool PointClipper::MayHide(const Vec3& x, const Occluder& occluder) const {
  const auto corners = set_->corners(occluder);
  return std::none_of(cone_.begin(), cone_.end(), [&](const Vec3& side) {
    return std::all_of(corners.begin(), corners.end(),
                       [&](const Vec3& corner) { return glm::dot(side, corner - x) >= 0; });
  });
}

// The cone from x over the occluder, and what lies beyond its plane.
void PointClipper::MakeCuts(const Vec3& x, const Occluder& occluder, double height) {
  cuts_.clear();
  const double sign = height > 0 ? 1 : -1;
  cuts_.push_back({-sign * occluder.normal, sign * height, occluder.tolerance_m});
  const auto corners = set_->corners(occluder);
  Vec3 a = corners.back() - x;
  for (const Vec3& corner : corners) {
    const Vec3 b = corner - x;
    // Seen counter-clockwise from x, a × b points away from what lies between.
    const Vec3 normal = -sign * glm::cross(a, b);
    cuts_.push_back({normal, 0, set_->tolerance_m() * Size(normal)});
    a = b;
  }
}

PointClipper::Piece PointClipper::Divide(const Piece& piece, const Cut& cut) {
  heights_.clear();
  double low = 0, high = 0;
  for (uint32_t i = 0; i < piece.count; ++i) {
    const double height = glm::dot(cut.normal, corners_[piece.first + i]) - cut.offset;
    heights_.push_back(height);
    low = std::min(low, height);
    high = std::max(high, height);
  }
  if (low >= -cut.tolerance) return piece;
  if (high <= cut.tolerance) {
    next_.push_back(piece);
    return {};
  }
  const auto part = [&](double side) {
    Piece result{static_cast<uint32_t>(corners_.size()), 0};
    for (uint32_t i = 0; i < piece.count; ++i) {
      const uint32_t j = i + 1 < piece.count ? i + 1 : 0;
      const Vec3 a = corners_[piece.first + i], b = corners_[piece.first + j];
      if (side * heights_[i] >= 0) corners_.push_back(a);
      if (heights_[i] * heights_[j] < 0) {
        corners_.push_back(a + (heights_[i] / (heights_[i] - heights_[j])) * (b - a));
      }
    }
    result.count = static_cast<uint32_t>(corners_.size()) - result.first;
    return result;
  };
  next_.push_back(part(-1));
  return part(1);
}

void PointClipper::Subtract(const Piece& piece) {
  for (const Cut& cut : cuts_) {  // most pieces miss the cone altogether
    bool outside = true;
    for (uint32_t i = 0; i < piece.count && outside; ++i) {
      outside = glm::dot(cut.normal, corners_[piece.first + i]) - cut.offset <= cut.tolerance;
    }
    if (outside) return next_.push_back(piece);
  }
  Piece inside = piece;
  for (const Cut& cut : cuts_) {
    inside = Divide(inside, cut);
    if (inside.count < 3) return;
  }
}

double PointClipper::FactorOfPieces(const Vec3& n) const {
  EdgeSum sum(n);
  for (const Piece& piece : pieces_) {
    for (uint32_t i = 0; i < piece.count; ++i) {
      sum.Add(corners_[piece.first + i], corners_[piece.first + (i + 1 < piece.count ? i + 1 : 0)]);
    }
  }
  return -0.5 * std::numbers::inv_pi * sum.Total();
}

double PointClipper::VisibleFactor(const Vec3& x, const Vec3& n, std::span<const Vec3> q,
                                   std::span<const uint32_t> candidates, double whole) {
  corners_.clear();
  for (const Vec3& corner : q) corners_.push_back(corner - x);
  pieces_.assign(1, {0, static_cast<uint32_t>(q.size())});
  cone_.clear();
  for (size_t i = 0; i < q.size(); ++i) {
    cone_.push_back(glm::cross(corners_[i], corners_[i + 1 < q.size() ? i + 1 : 0]));
  }
  bool untouched = true;
  // Fronts first: of a solid they hide what its backs would cut into more pieces.
  for (const double side : {1.0, -1.0}) {
    for (const uint32_t i : candidates) {
      const Occluder& occluder = (*set_)[i];
      const double height = occluder.Height(x);
      if (side * height <= occluder.tolerance_m) continue;
      ++work_;
      if (!MayHide(x, occluder)) continue;
      work_ += pieces_.size();
      MakeCuts(x, occluder, height);
      next_.clear();
      for (const Piece& piece : pieces_) Subtract(piece);
      untouched &= next_.size() == 1 && next_[0].first == 0;
      pieces_.swap(next_);
      if (pieces_.empty()) return 0;
    }
  }
  return untouched ? whole : std::clamp(FactorOfPieces(n), 0.0, whole);
}

}  // namespace isolux
