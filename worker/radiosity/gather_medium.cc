// The gather through a medium, or panes of glass. What a medium leaves of the light of a source is
// the mean over nine of its points, weighted by what they bring; of a cluster that of its centre.
#include <bit>
#include <cmath>

#include "worker/radiosity/gather_point.h"

namespace isolux {
namespace {

// e^−x for x ≥ 0; relative error below 3e-7, 0 beyond 87.
FloatLanes ExpOfMinus(FloatLanes x) {
  const FloatLanes bounded = Minimum(x, SplatFloat(87));
  // Rounded to whole numbers by the bits of 1.5 × 2^23.
  const FloatLanes k = (bounded * 1.44269504F + 0x1.8p23F) - 0x1.8p23F;
  const FloatLanes r = (k * 0.693359375F - bounded) + k * -2.12194440e-4F;
  FloatLanes sum = SplatFloat(1);
  for (int n = 8; n > 0; --n) sum = 1 + sum * r * (1.0F / static_cast<float>(n));
  const Int32Lanes exponent = 127 - __builtin_convertvector(k, Int32Lanes);
  const FloatLanes power = reinterpret_cast<FloatLanes>(exponent << 23);
  return Select(x > 87.0F, FloatLanes{}, sum * power);
}

struct Node {
  float at, weight;
};
// Gauss–Legendre with three points on [0, 1].
constexpr std::array<Node, 3> kGauss = {
    {{0.112701665F, 5.0F / 18}, {0.5F, 8.0F / 18}, {0.887298335F, 5.0F / 18}}};

FloatLanes LengthOf(const std::array<FloatLanes, 3>& v) {
  return SquareRoot(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

}  // namespace

std::array<FloatLanes, 3> PointGather::Left(FloatLanes distance) const {
  std::array<FloatLanes, 3> left;
  for (int c = 0; c < 3; ++c) {
    const bool as_before = c > 0 && extinction_[c] == extinction_[c - 1];
    left[c] = as_before ? left[c - 1] : ExpOfMinus(extinction_[c] * distance);
  }
  return left;
}

std::array<FloatLanes, 3> PointGather::LeftOf(const SourceOctet& octet, PlanePoint at) const {
  const std::array<float, 3> from = {at.x, at.y, 0};
  std::array<FloatLanes, 3> sum{};
  FloatLanes weights{};
  for (const auto& [v, wv] : kGauss) {
    for (const auto& [u, wu] : kGauss) {
      std::array<FloatLanes, 3> d, along_u, along_v;
      for (int i = 0; i < 3; ++i) {
        const FloatLanes& a = octet.corner[0][i];
        // From the second corner to the third, and what the third is farther from the fourth than
        // the second from the first. A triangle's fourth is its first.
        const FloatLanes& ab = octet.side[0][i];
        const FloatLanes& bc = octet.side[1][i];
        const FloatLanes ad = ab + bc + octet.side[2][i];
        along_u[i] = ab - v * (ab + octet.side[2][i]);
        along_v[i] = ad + u * (bc - ad);
        d[i] = a + u * ab + v * along_v[i] - from[static_cast<size_t>(i)];
      }
      const std::array<FloatLanes, 3> area = {along_u[1] * along_v[2] - along_u[2] * along_v[1],
                                              along_u[2] * along_v[0] - along_u[0] * along_v[2],
                                              along_u[0] * along_v[1] - along_u[1] * along_v[0]};
      const FloatLanes distance = LengthOf(d);
      const FloatLanes distance2 = Maximum(distance * distance, SplatFloat(1e-15F));
      // The height over the source's plane is the same for all of it.
      const FloatLanes weight =
          wu * wv * LengthOf(area) * Maximum(d[2], FloatLanes{}) / (distance2 * distance2);
      const std::array<FloatLanes, 3> left = Left(distance);
      for (int c = 0; c < 3; ++c) sum[c] += weight * left[c];
      weights += weight;
    }
  }
  const Int32Lanes any = weights > 0.0F;
  for (FloatLanes& channel : sum) {
    channel = Select(any, channel / Select(any, weights, SplatFloat(1)), SplatFloat(1));
  }
  return sum;
}

void PointGather::AddBlockThrough(const GatherPlace& place, SourceBlock& block) {
  const PlanePoint at = block.At(place.position);
  const UInt32Lanes seeds = UInt32Lanes{} + static_cast<uint32_t>(place.seed);
  std::array<int64_t, 3> total = block.even();
  for (int c = 0; c < 3; ++c) {
    extinction_[c] = medium_ == nullptr
                         ? 0.0F
                         : static_cast<float>(medium_->extinction_per_m[c] * block.unit_m());
  }
  std::array<FloatLanes, 3> none;
  none.fill(SplatFloat(1));
  const std::span<const SourceOctet> octets = block.octets();
  for (size_t o = 0; o < octets.size(); ++o) {
    const SourceOctet& octet = octets[o];
    const FloatLanes factor = FormFactors(octet, at);
    const FloatLanes seen = factor * octet.visibility;
    const std::array<FloatLanes, 3> left = medium_ == nullptr ? none : LeftOf(octet, at);
    std::array<FloatLanes, 3> by_panes = none;
    const bool glazed = panes_ != nullptr && LeftByPanes(place, block, o, factor, &by_panes);
    for (int c = 0; c < 3; ++c) {
      const FloatLanes arriving = seen * octet.radiosity[c] * left[c];
      total[c] += SumOfRounded(glazed ? arriving * by_panes[c] : arriving);
    }
    const size_t before = looks_.size();
    ListLooks(block, o, factor, seeds);
    for (size_t l = before; l < looks_.size(); ++l) {
      const int lane = looks_[l].lane;
      left_of_looks_.push_back({{left[0][lane], left[1][lane], left[2][lane]},
                                {by_panes[0][lane], by_panes[1][lane], by_panes[2][lane]}});
    }
  }
  for (const ClusterOctet& octet : block.clusters()) {
    const FloatLanes factor = FormFactors(octet, at);
    const std::array<FloatLanes, 3> left =
        medium_ == nullptr
            ? none
            : Left(LengthOf({octet.centre[0] - at.x, octet.centre[1] - at.y, octet.centre[2]}));
    for (int c = 0; c < 3; ++c) total[c] += SumOfRounded(factor * octet.radiosity[c] * left[c]);
  }
  for (int c = 0; c < 3; ++c) place.sums[c] += total[c];
}

}  // namespace isolux
