#include "worker/coupling/contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "worker/coupling/lanes.h"

namespace isolux {
namespace {

// A piece of a side is taken as converged where its halves change it by less than the tolerance
// over this. Measured on random pairs: 0.05 is exceeded by half of the near ones.
constexpr double kStepShare = 0.35;
// What a bisected piece leaves to each half: the errors of the two rarely add up.
constexpr double kHalfTolerance = 0.6;
constexpr int kMostDepth = 24;
// Rounding of an integral over a side, over its scale. Nothing converges below.
constexpr double kNoise = 4e-16;
// Points nearer than this share of a side are where it is cut.
constexpr double kCutReach = 0.5;
// Sides at a right angle (this cosine or less) exchange nothing.
constexpr double kRightAngle = 1e-15;

// Gauss's four points on [0, 1].
constexpr Lanes kGaussPoint{0.069431844202973712, 0.33000947820757187, 0.66999052179242813,
                            0.93056815579702629};
constexpr Lanes kGaussWeight{0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                             0.17392742256872693};

struct Edge {
  Vec3 start{0.0};
  Vec3 along{0.0};  // unit
  double length = 0;
};

struct Edges {
  int count = 0;
  std::array<Edge, 5> edge;

  explicit Edges(std::span<const Vec3> corners) {
    for (size_t i = 0; i < corners.size(); ++i) {
      const Vec3 side = corners[(i + 1) % corners.size()] - corners[i];
      const double length = glm::length(side);
      if (length > 0) edge[count++] = {corners[i], side / length, length};
    }
  }
};

// ∫_f ln|x − y| dy over a side f, but for a constant; the line of f is `distance2` (squared) from
// x, and the ends are at a and b = a + length along it, seen from the foot of x.
Lanes Potential(Lanes a, Lanes b, Lanes distance2, Lanes length) {
  const Lanes tiny = Splat(1e-300);  // times a vanishing factor
  const Lanes log_a = Log(Maximum(a * a + distance2, tiny));
  const Lanes log_b = Log(Maximum(b * b + distance2, tiny));
  const Lanes distance = SquareRoot(distance2);
  return 0.5 * (b * log_b - a * log_a) +
         distance * Atan2Upper(distance * length, distance2 + a * b);
}

// Sides e and f: the potential of f along e.
class EdgePair {
 public:
  EdgePair(const Edge& e, const Edge& f)
      : length_e_(e.length),
        length_f_(f.length),
        cosine_(glm::dot(e.along, f.along)),
        a_(glm::dot(f.start - e.start, f.along)),
        across_(glm::cross(f.start - e.start, f.along)),
        turn_(glm::cross(e.along, f.along)) {
    // Where the integrand's derivatives are large: at the feet of the ends of f, and where the two
    // lines are closest.
    for (const double t : {0.0, f.length}) {
      const Vec3 to_end = f.start + t * f.along - e.start;
      const Vec3 off = glm::cross(to_end, e.along);
      AddCut(glm::dot(to_end, e.along), glm::dot(off, off));
    }
    const double turn2 = glm::dot(turn_, turn_);
    if (turn2 > 1e-24) {
      const double s = glm::dot(across_, turn_) / turn2;
      const Vec3 apart = across_ - s * turn_;
      AddCut(s, glm::dot(apart, apart));
    }
  }

  double cosine() const { return cosine_; }

  struct Integral {
    double value = 0, error = 0;
  };

  // ∫_e of the potential.
  Integral Integrate(double tolerance) const {
    Integral total;
    double from = 0;
    for (int i = 0; i <= cut_count_; ++i) {
      const double to = i < cut_count_ ? cuts_[i] : length_e_;
      if (to > from) {
        Refine(from, to, Gauss(from, to), tolerance / (cut_count_ + 1), 0, total);
      }
      from = to;
    }
    return total;
  }

 private:
  // In order along e.
  void AddCut(double s, double distance2) {
    if (!(s > 0 && s < length_e_ && distance2 < kCutReach * kCutReach * length_e_ * length_e_)) {
      return;
    }
    int i = cut_count_++;
    for (; i > 0 && cuts_[i - 1] > s; --i) cuts_[i] = cuts_[i - 1];
    cuts_[i] = s;
  }

  double Gauss(double from, double to) const {
    const Lanes s = from + (to - from) * kGaussPoint;
    const Lanes a = a_ - cosine_ * s;
    const Vec3x4 across = {across_.x - turn_.x * s, across_.y - turn_.y * s,
                           across_.z - turn_.z * s};
    const Lanes value = Potential(a, a + length_f_, Dot(across, across), Splat(length_f_));
    return (to - from) * Total(kGaussWeight * value);
  }

  // An upper bound of the error of Gauss's four points on a piece: ln r is expanded about the
  // piece's centre, where it converges within the distance to f.
  double Bound(double from, double to) const {
    const double half = 0.5 * (to - from);
    const double s = from + half;
    const double a = a_ - cosine_ * s;
    const Vec3 across = across_ - s * turn_;
    const double beyond = std::max(std::max(a, -(a + length_f_)), 0.0);
    const double reach2 = glm::dot(across, across) + beyond * beyond;
    const double x2 = half * half / reach2;
    if (!(x2 < 0.64)) return std::numeric_limits<double>::infinity();
    const double x4 = x2 * x2;
    const double rest = 1 - x2;
    return 0.0015 * x4 * x4 / (rest * rest) * half * std::min(length_f_, 1.6 * std::sqrt(reach2));
  }

  void Refine(double from, double to, double whole, double tolerance, int depth,
              Integral& total) const {
    if (const double bound = Bound(from, to); bound <= tolerance) {
      total.value += whole;
      total.error += bound;
      return;
    }
    const double middle = 0.5 * (from + to);
    const double first = Gauss(from, middle), second = Gauss(middle, to);
    const double halves = first + second;
    const double step = std::abs(halves - whole);
    const double noise = kNoise * (std::abs(halves) + length_f_ * (to - from));
    if (kStepShare * step <= tolerance || step <= noise || depth == kMostDepth) {
      total.value += halves;
      total.error += kStepShare * step + noise;
      return;
    }
    Refine(from, middle, first, kHalfTolerance * tolerance, depth + 1, total);
    Refine(middle, to, second, kHalfTolerance * tolerance, depth + 1, total);
  }

  double length_e_, length_f_;
  double cosine_;
  double a_;  // of the start of e, along f
  Vec3 across_, turn_;
  int cut_count_ = 0;
  std::array<double, 3> cuts_{};
};

}  // namespace

ContourIntegral IntegrateContours(std::span<const Vec3> p, std::span<const Vec3> q,
                                  double tolerance) {
  const Edges outer(p), inner(q);
  const double share = 2 * std::numbers::pi * tolerance / (outer.count * inner.count);
  ContourIntegral result;
  for (int i = 0; i < outer.count; ++i) {
    for (int j = 0; j < inner.count; ++j) {
      const EdgePair pair(outer.edge[i], inner.edge[j]);
      const double weight = std::abs(pair.cosine());
      if (weight <= kRightAngle) continue;
      const EdgePair::Integral integral = pair.Integrate(share / weight);
      result.coupling += pair.cosine() * integral.value;
      result.error += weight * integral.error;
    }
  }
  result.coupling /= 2 * std::numbers::pi;
  result.error /= 2 * std::numbers::pi;
  return result;
}

}  // namespace isolux
