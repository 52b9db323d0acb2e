#include "worker/factors/sampled_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/util/random.h"

namespace isolux {
namespace {

constexpr int kReplicates = 16;
// Standard errors, from sixteen values: 98 of 100 errors stay below.
constexpr double kStated = 3;
// Twice the segments make errors 0.6 times as large; a sudden drop further than this is luck.
constexpr double kLeastOfLast = 0.5;
constexpr uint32_t kFirstSegments = 4;    // of a replicate
constexpr uint32_t kMostDrawn = 1 << 17;  // of a replicate, those that miss among them

// Direction numbers of the second to fourth dimension: polynomials x + 1, x² + x + 1, x³ + x + 1
// with first numbers 1; 1, 3; 1, 3, 1.
using Directions = std::array<std::array<uint32_t, 32>, 4>;
constexpr Directions MakeDirections() {
  Directions v{};
  for (uint32_t i = 0; i < 32; ++i) v[0][i] = 1U << (31 - i);
  constexpr std::array<uint32_t, 4> kDegree{0, 1, 2, 3}, kInner{0, 0, 1, 1};
  constexpr std::array<std::array<uint32_t, 3>, 4> kFirst{{{}, {1}, {1, 3}, {1, 3, 1}}};
  for (uint32_t d = 1; d < 4; ++d) {
    const uint32_t s = kDegree[d];
    for (uint32_t i = 0; i < 32; ++i) {
      if (i < s) {
        v[d][i] = kFirst[d][i] << (31 - i);
        continue;
      }
      v[d][i] = v[d][i - s] ^ (v[d][i - s] >> s);
      for (uint32_t k = 1; k < s; ++k) {
        if (((kInner[d] >> (s - 1 - k)) & 1) != 0) v[d][i] ^= v[d][i - k];
      }
    }
  }
  return v;
}
constexpr Directions kDirections = MakeDirections();

uint32_t Reverse(uint32_t x) {
  x = (x >> 16) | (x << 16);
  x = ((x & 0x00ff00ffU) << 8) | ((x & 0xff00ff00U) >> 8);
  x = ((x & 0x0f0f0f0fU) << 4) | ((x & 0xf0f0f0f0U) >> 4);
  x = ((x & 0x33333333U) << 2) | ((x & 0xccccccccU) >> 2);
  return ((x & 0x55555555U) << 1) | ((x & 0xaaaaaaaaU) >> 1);
}

// Nested uniform scrambling: each bit is flipped depending on the ones above it.
uint32_t Scramble(uint32_t x, uint32_t seed) {
  x = Reverse(x);
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return Reverse(x);
}

// Uniform on a convex polygon: the triangle of its fan by area, then a point of that.
class Sampler {
 public:
  explicit Sampler(const ShaftEnd& end) : corners_(end.corners) {
    for (size_t i = 2; i < corners_.size(); ++i) {
      total_ += glm::length(glm::cross(corners_[i - 1] - corners_[0], corners_[i] - corners_[0]));
      upto_[i - 2] = total_;
    }
  }
  double area() const { return 0.5 * total_; }
  Vec3 At(double u, double v) const {
    double target = u * total_, before = 0;
    size_t i = 0;
    while (i + 3 < corners_.size() && target >= upto_[i]) before = upto_[i++];
    const double own = upto_[i] - before;
    const double s = std::sqrt(own > 0 ? std::clamp((target - before) / own, 0.0, 1.0) : 0.5);
    return corners_[0] +
           s * ((1 - v) * (corners_[i + 1] - corners_[0]) + v * (corners_[i + 2] - corners_[0]));
  }

 private:
  std::span<const Vec3> corners_;
  std::array<double, ShaftEnd::kMaxCorners> upto_{};
  double total_ = 0;
};

struct Segment {
  Vec3 from{0.0}, to{0.0};
  double weight = 0;  // 0: no segment
};

// Segments between two ends. Where the smaller sees much of the larger, directions are drawn by
// their cosine from points of the smaller, and those that miss the larger are none: all others
// weigh the same however near the two are. Else points are drawn on both, and the kernel weighs.
class SegmentMaker {
 public:
  // A share of directions worth drawing: the others cost no tracing.
  static constexpr double kSeesMuch = 0.02;

  SegmentMaker(const ShaftEnd& p, const ShaftEnd& q, double unobstructed_m2)
      : p_(Sampler(p).area() <= Sampler(q).area() ? p : q),
        q_(Sampler(p).area() <= Sampler(q).area() ? q : p),
        on_p_(p_),
        on_q_(q_),
        by_direction_(unobstructed_m2 > kSeesMuch * on_p_.area()) {
    const Vec3 other = std::abs(p_.normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    u_ = glm::normalize(glm::cross(other, p_.normal));
    v_ = glm::cross(p_.normal, u_);
  }

  Segment Make(const std::array<double, 4>& sample) const {
    const Vec3 x = on_p_.At(sample[0], sample[1]);
    if (by_direction_) return Along(x, sample[2], sample[3]);
    const Vec3 y = on_q_.At(sample[2], sample[3]);
    const Vec3 d = y - x;
    const double d2 = glm::dot(d, d);
    const double kernel =
        std::max(0.0, glm::dot(p_.normal, d)) * std::max(0.0, -glm::dot(q_.normal, d)) / (d2 * d2);
    return {x, y, kernel > 0 ? kernel : 0.0};
  }

 private:
  Segment Along(const Vec3& x, double s, double t) const {
    const double r = std::sqrt(s), angle = 2 * std::numbers::pi * t;
    const Vec3 d =
        r * std::cos(angle) * u_ + r * std::sin(angle) * v_ + std::sqrt(1 - s) * p_.normal;
    const double approach = -glm::dot(q_.normal, d);
    const double height = glm::dot(q_.normal, x - q_.corners[0]);
    if (!(approach > 0) || !(height > 0)) return {};
    const Vec3 y = x + (height / approach) * d;
    for (size_t i = 0; i < q_.corners.size(); ++i) {
      const Vec3& a = q_.corners[i];
      const Vec3 edge = q_.corners[i + 1 < q_.corners.size() ? i + 1 : 0] - a;
      if (glm::dot(glm::cross(edge, y - a), q_.normal) < 0) return {};
    }
    return {x, y, 1};
  }

  const ShaftEnd &p_, &q_;  // the smaller, the larger
  Sampler on_p_, on_q_;
  bool by_direction_;
  Vec3 u_{0.0}, v_{0.0};  // with p's normal a frame
};

struct Replicate {
  uint32_t seed = 0;
  double whole = 0, visible = 0;
};

// What all replicates together say.
VisibleShare Combine(const std::array<Replicate, kReplicates>& replicates, uint64_t traced,
                     uint64_t passed) {
  double whole = 0, visible = 0, scatter = 0;
  for (const Replicate& r : replicates) {
    whole += r.whole;
    visible += r.visible;
  }
  VisibleShare share;
  share.value = whole > 0 ? visible / whole : 0;
  for (const Replicate& r : replicates) {
    // As a ratio's scatter: replicates that drew less weigh less.
    const double off = whole > 0 ? (r.visible - share.value * r.whole) * kReplicates / whole : 1;
    scatter += off * off;
  }
  // Sixteen values may agree by luck: at least half of what such points have on average, 1.2 N^-0.7
  // of a single segment's scatter, taken by the rule of succession, as all segments may agree, too.
  const double n = static_cast<double>(traced) + 2;
  const double odds = (static_cast<double>(passed) + 1) / n;
  const double unseen = 0.6 * std::sqrt(odds * (1 - odds)) * std::pow(n, -0.7);
  share.error = kStated * std::max(std::sqrt(scatter / (kReplicates * (kReplicates - 1))), unseen);
  // Where all agree, up to three in as many may not (the rule of three, 95 %).
  if (passed == 0 || passed == traced) share.error = std::max(share.error, 3 / n);
  return share;
}

}  // namespace

double ScrambledSobol(uint32_t index, int dimension, uint32_t seed) {
  uint32_t x = 0;
  for (int bit = 0; bit < 32 && (index >> bit) != 0; ++bit) {
    if (((index >> bit) & 1) != 0) x ^= kDirections[dimension][bit];
  }
  const auto of_dimension = static_cast<uint32_t>(Hash(seed, static_cast<uint64_t>(dimension)));
  return static_cast<double>(Scramble(x, of_dimension)) * 0x1p-32;
}

VisibleShare SampleVisibleShare(const ShaftEnd& p, const ShaftEnd& q, const OccluderTree& tree,
                                double unobstructed_m2, double tolerance, uint64_t seed) {
  const SegmentMaker maker(p, q, unobstructed_m2);
  std::array<Replicate, kReplicates> replicates;
  for (int r = 0; r < kReplicates; ++r) {
    replicates[r].seed = static_cast<uint32_t>(Hash(seed, static_cast<uint64_t>(r)));
  }
  VisibleShare share;
  uint64_t traced = 0, passed = 0;
  uint32_t done = 0;
  for (uint32_t target = kFirstSegments; traced < kMostSegments && target <= kMostDrawn;
       target *= 2) {
    for (Replicate& replicate : replicates) {
      for (uint32_t i = done; i < target; ++i) {
        std::array<double, 4> sample;
        for (int d = 0; d < 4; ++d) sample[d] = ScrambledSobol(i, d, replicate.seed);
        const Segment segment = maker.Make(sample);
        if (segment.weight == 0) continue;
        ++traced;
        replicate.whole += segment.weight;
        if (tree.Blocked(segment.from, segment.to, p.region, q.region)) continue;
        replicate.visible += segment.weight;
        ++passed;
      }
    }
    done = target;
    if (traced < kReplicates * kFirstSegments) continue;
    const double last = share.error;
    share = Combine(replicates, traced, passed);
    if (last < 1) share.error = std::max(share.error, kLeastOfLast * last);
    share.segments = static_cast<uint32_t>(traced);
    if (share.error <= tolerance) break;
  }
  return share;
}

}  // namespace isolux
