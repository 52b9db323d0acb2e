#include "worker/coupling/contour.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "worker/coupling/edges.h"

namespace isolux {
namespace {

constexpr double kPi = std::numbers::pi;
// Edges at a right angle (this cosine or less) exchange nothing.
constexpr double kRightAngle = 1e-15;
// Of the sum of the bounds of the pieces' errors, what the error comes to: the worst case of each
// lies elsewhere, and signs differ. Fewer than one random pair in a hundred errs by more.
constexpr double kUsualShare = 0.3;
// Of the tolerance of a pair of edges, what a piece may err by.
constexpr double kPieceShare = 0.5;
// Rounding of the whole, over the product of the perimeters.
constexpr double kRounding = 1e-16;
// Divisions of an edge; rounding ends the need for more long before.
constexpr int kMostDepth = 40;
// A piece is divided nearer to where the integrand is not smooth, at this share of its length.
constexpr double kGrading = 0.25;
// Error of four points on a piece of half length h that lies against f, where no end of f is beside
// the piece but near its ends: at most this times h², the largest found in a scan.
constexpr double kTouching = 0.015;
// Relative rounding of the closed form for parallel edges.
constexpr double kParallelNoise = 1e-15;

// Sum of integrals and of the bounds of their errors, and how many there were.
struct Integral {
  double value = 0, error = 0;
  uint32_t pieces = 0;
};

// Edges e and f: ∫_e G_f.
class EdgePair {
 public:
  EdgePair(const Edge& e, const Edge& f)
      : length_e_(e.length),
        length_f_(f.length),
        cosine_(glm::dot(e.along, f.along)),
        a_(glm::dot(f.start - e.start, f.along)),
        across_(glm::cross(f.start - e.start, f.along)),
        turn_(glm::cross(e.along, f.along)),
        sine_(glm::length(turn_)) {
    foot_[0] = glm::dot(f.start - e.start, e.along);
    foot_[1] = foot_[0] + cosine_ * length_f_;
  }

  // Each piece may err by the tolerance.
  Integral Integrate(double tolerance) const {
    Integral total;
    const double reach = std::abs(a_) + length_e_ + length_f_;
    const double error = 2 * sine_ * length_e_ * length_e_ + kParallelNoise * reach * reach;
    if (error <= 0.1 * tolerance) {
      const double distance = glm::length(across_ - 0.5 * length_e_ * turn_);
      total.value = ParallelEdges(a_, distance, length_e_, length_f_, cosine_ < 0 ? -1.0 : 1.0);
      total.error = error;
      total.pieces = 1;
    } else {
      Add(0, length_e_, tolerance, 0, total);
    }
    return total;
  }

 private:
  void Add(double from, double to, double tolerance, int depth, Integral& total) const {
    const double half = 0.5 * (to - from);
    const double centre = from + half;
    const double a = a_ - cosine_ * centre, b = a + length_f_;
    const Vec3 across = across_ - centre * turn_;
    // Squared distances of the piece's centre from f, and from what its line has beyond both ends;
    // and from the line itself.
    const double beyond = std::max(std::max(a, -b), 0.0);
    const double behind = std::min(a, 0.0), ahead = std::max(b, 0.0);
    const Lanes reach2 = Maximum(
        glm::dot(across, across) + Lanes{beyond * beyond, behind * behind, ahead * ahead, 0},
        Splat(1e-300));
    const Lanes reach = SquareRoot(reach2);
    const Lanes ratio2 = half * half * Lanes{1, 1, 1, sine_ * sine_} / reach2;
    Lanes size = kLineShare * reach;
    size[0] = std::min(size[0], length_f_);
    const Lanes bound = ExpansionBound(4, Splat(half), ratio2, size);
    const double ends = bound[1] + bound[2];
    const double line = std::min(kPi * bound[3], kKink * sine_ * half * half);
    if (std::min(bound[0], std::max(ends, line)) <= tolerance) {
      total.value += Gauss(from, to, 0);
      total.error += std::min(bound[0], ends + line);
      ++total.pieces;
      return;
    }
    if (ends <= tolerance) {
      total.value += GaussBesideLine(from, to);
      total.error += ends;
      ++total.pieces;
      return;
    }
    const double foot = foot_[std::abs(a) < std::abs(b) ? 0 : 1];  // of the end of f that is nearer
    const bool inside = foot > from + 0.1 * half && foot < to - 0.1 * half;
    const double touching = kTouching * half * half;
    if ((!inside && touching <= tolerance) || depth == kMostDepth) {
      const bool beside = a < 0 && b > 0 && line > tolerance;
      total.value += beside ? GaussBesideLine(from, to) : Gauss(from, to, 0);
      total.error += touching;
      ++total.pieces;
      return;
    }
    double cut = foot;
    if (!inside) cut = foot < centre ? from + kGrading * (to - from) : to - kGrading * (to - from);
    Add(from, cut, tolerance, depth + 1, total);
    Add(cut, to, tolerance, depth + 1, total);
  }

  // By four points, less turn·g.
  double Gauss(double from, double to, double turn) const {
    const GaussRule& rule = kGauss[2];
    const Lanes point{rule.point[0], rule.point[1], rule.point[2], rule.point[3]};
    const Lanes weight{rule.weight[0], rule.weight[1], rule.weight[2], rule.weight[3]};
    const Lanes s = from + (to - from) * point;
    const Vec3x4 across = {across_.x - turn_.x * s, across_.y - turn_.y * s,
                           across_.z - turn_.z * s};
    return (to - from) * Total(weight * Potential(a_ - cosine_ * s, Splat(length_f_),
                                                  Dot(across, across), Splat(turn)));
  }

  double GaussBesideLine(double from, double to) const {
    const double nearest = glm::dot(across_, turn_) / (sine_ * sine_);
    const Vec3 apart = across_ - nearest * turn_;
    const Lanes line = LineDistance(Splat(sine_ * (from - nearest)), Splat(sine_ * (to - nearest)),
                                    Splat(glm::dot(apart, apart)), Splat(sine_));
    return Gauss(from, to, kPi) + kPi * line[0];
  }

  double length_e_, length_f_;
  double cosine_;
  double a_;     // of the start of e
  Vec3 across_;  // from the line of f to the start of e, turned by a right angle about it
  Vec3 turn_;    // how that changes along e
  double sine_;
  std::array<double, 2> foot_{};  // of the ends of f, along e
};

// Up to four edges of the inner polygon, side by side.
class EdgeGroup {
 public:
  EdgeGroup(const Edges& edges, int first) {
    for (int i = 0; i < 4; ++i) {
      const bool real = first + i < edges.count;
      const Edge& edge = edges.edge[real ? first + i : 0];
      start_.x[i] = edge.start.x;
      start_.y[i] = edge.start.y;
      start_.z[i] = edge.start.z;
      along_.x[i] = real ? edge.along.x : 0;
      along_.y[i] = real ? edge.along.y : 0;
      along_.z[i] = real ? edge.along.z : 0;
      length_[i] = edge.length;
    }
  }

  // Adds the integrals along all of e of those edges that are far enough from it for a rule of at
  // most four points, times the cosine; says of which not, as a set of bits.
  int AddFar(const Edge& e, double tolerance, Lanes& value, Lanes& error) const {
    const double half = 0.5 * e.length;
    const Vec3x4 to = start_ - (e.start + half * e.along);
    const Lanes a = Dot(to, along_), b = a + length_;
    const Vec3x4 across = Cross(to, along_);
    const Lanes distance2 = Dot(across, across);
    const Lanes cosine = Dot(e.along, along_);
    const Lanes weight = Absolute(cosine);
    const Lanes zero = Splat(0.0);
    const Lanes beyond = Maximum(Maximum(a, -b), zero);
    const Lanes reach2 = Maximum(distance2 + beyond * beyond, Splat(1e-300));
    const Lanes size = Minimum(length_, kLineShare * SquareRoot(reach2));
    const Lanes ratio2 = half * half / reach2;
    const LaneMask right = weight <= kRightAngle;
    for (int points = 2;; ++points) {
      const Lanes bound = weight * ExpansionBound(points, Splat(half), ratio2, size);
      const LaneMask done = right | (bound <= tolerance);
      const int left = ~Bits(done) & 15;
      if (left != 0 && points < 4) continue;
      if (left == 15) return left;
      const GaussRule& rule = kGauss[points - 2];
      const Vec3x4 turn = Cross(e.along, along_);
      Lanes sum = zero;
      for (int k = 0; k < points; ++k) {
        const double s = (2 * rule.point[k] - 1) * half;
        const Vec3x4 off = {across.x - s * turn.x, across.y - s * turn.y, across.z - s * turn.z};
        sum += rule.weight[k] * Potential(a - s * cosine, length_, Dot(off, off), zero);
      }
      value += Select(done, e.length * cosine * sum, zero);
      error += Select(done & ~right, bound, zero);
      return left;
    }
  }

 private:
  Vec3x4 start_, along_;
  Lanes length_;
};

}  // namespace

ContourIntegral IntegrateContours(std::span<const Vec3> p, std::span<const Vec3> q,
                                  double tolerance) {
  const Edges outer(p), inner(q);
  const double whole = 2 * kPi * tolerance / kUsualShare;
  const double share = whole / (outer.count * inner.count);
  Lanes far_value = Splat(0.0), far_error = Splat(0.0);
  std::array<std::array<int, 2>, 5> left{};
  int near_count = 0;
  for (int group = 0; 4 * group < inner.count; ++group) {
    const EdgeGroup edges(inner, 4 * group);
    for (int i = 0; i < outer.count; ++i) {
      left[i][group] = edges.AddFar(outer.edge[i], share, far_value, far_error);
      near_count += std::popcount(static_cast<unsigned>(left[i][group]));
    }
  }
  Integral near;
  const double near_share = kPieceShare * (whole - Total(far_error)) / std::max(near_count, 1);
  for (int i = 0; i < outer.count; ++i) {
    for (int j = 0; j < inner.count; ++j) {
      if ((left[i][j / 4] >> j % 4 & 1) == 0) continue;
      const double cosine = glm::dot(outer.edge[i].along, inner.edge[j].along);
      const Integral integral =
          EdgePair(outer.edge[i], inner.edge[j]).Integrate(near_share / std::abs(cosine));
      near.value += cosine * integral.value;
      near.error += std::abs(cosine) * integral.error;
      near.pieces += integral.pieces;
    }
  }
  // Pieces are many where their tolerance is small against the edges; then most err by far less.
  const double error = kUsualShare * (Total(far_error) + near.error) / (2 * kPi);
  return {(Total(far_value) + near.value) / (2 * kPi),
          std::min(error, tolerance) + kRounding * outer.perimeter * inner.perimeter,
          static_cast<uint32_t>(outer.count * inner.count - near_count) + near.pieces};
}

}  // namespace isolux
