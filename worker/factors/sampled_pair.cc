#include "worker/factors/sampled_pair.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/util/random.h"

namespace isolux {
namespace {

constexpr int kReplicates = 4;
constexpr uint32_t kFirstSegments = 16;  // of a replicate
constexpr uint32_t kMostSegments = 1 << 14;

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

struct Replicate {
  uint32_t seed = 0;
  double whole = 0, visible = 0;
};

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
                                double tolerance, uint64_t seed) {
  const Sampler on_p(p), on_q(q);
  std::array<Replicate, kReplicates> replicates;
  for (int r = 0; r < kReplicates; ++r) {
    replicates[r].seed = static_cast<uint32_t>(Hash(seed, static_cast<uint64_t>(r)));
  }
  VisibleShare share;
  uint32_t passed = 0;
  uint32_t done = 0;
  for (uint32_t target = kFirstSegments; target <= kMostSegments; target *= 2) {
    for (Replicate& replicate : replicates) {
      const auto at = [&](uint32_t i, int d) { return ScrambledSobol(i, d, replicate.seed); };
      for (uint32_t i = done; i < target; ++i) {
        const Vec3 x = on_p.At(at(i, 0), at(i, 1)), y = on_q.At(at(i, 2), at(i, 3));
        const Vec3 d = y - x;
        const double d2 = glm::dot(d, d);
        const double kernel = std::max(0.0, glm::dot(p.normal, d)) *
                              std::max(0.0, -glm::dot(q.normal, d)) / (d2 * d2);
        if (!(kernel > 0)) continue;
        replicate.whole += kernel;
        if (tree.Blocked(x, y)) continue;
        replicate.visible += kernel;
        ++passed;
      }
    }
    done = target;
    double whole = 0, visible = 0, scatter = 0;
    for (const Replicate& r : replicates) {
      whole += r.whole;
      visible += r.visible;
    }
    share.value = whole > 0 ? visible / whole : 0;
    for (const Replicate& r : replicates) {
      const double own = r.whole > 0 ? r.visible / r.whole : share.value;
      scatter += (own - share.value) * (own - share.value);
    }
    share.segments = kReplicates * target;
    const double n = share.segments + 2.0;
    const double odds = (passed + 1.0) / n;
    // Where all segments agree, one more that does not may be found: the rule of succession.
    const double unseen = std::sqrt(odds * (1 - odds)) / n;
    share.error = 2 * std::max(std::sqrt(scatter / (kReplicates * (kReplicates - 1))), unseen);
    if (share.error <= tolerance) break;
  }
  return share;
}

}  // namespace isolux
