#include "worker/radiosity/gather_point.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/util/random.h"
#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/matvec.h"
#include "worker/radiosity/polygon_sampler.h"

namespace isolux {
namespace {

constexpr float kMostRays = 64;  // from one point to one source
// Of a source that gets a ray by a small chance, what it sees counts for those that get none; but
// not for more than this, lest single rays decide.
constexpr float kMostStandFor = 8;

// A shifted additive sequence: even over a polygon whatever the number of points ([Roberts18]).
// Eight terms from `at` on, which is moved past them.
constexpr double kStepU = 0.75487766624669276, kStepV = 0.56984029099805327;
FloatLanes Sequence(double step, double& at) {
  FloatLanes terms{};
  for (int i = 0; i < 8; ++i) {
    terms[i] = std::min(static_cast<float>(at), 1 - 0x1p-24F);
    at += step;
    if (at >= 1) at -= 1;
  }
  return terms;
}

int64_t Rounded(float arriving) { return ToInteger(Splat(static_cast<double>(arriving)))[0]; }

}  // namespace

int64_t SumOfRounded(FloatLanes arriving) {
  const __m256 v = reinterpret_cast<__m256>(arriving);
  const Lanes low = reinterpret_cast<Lanes>(_mm256_cvtps_pd(_mm256_castps256_ps128(v)));
  const Lanes high = reinterpret_cast<Lanes>(_mm256_cvtps_pd(_mm256_extractf128_ps(v, 1)));
  const IntLanes sum = ToInteger(low) + ToInteger(high);
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void PointGather::Evaluate(const GatherPlace& place, std::span<SourceBlock* const> blocks,
                           double rays_per_doubt) {
  looks_.clear();
  left_of_looks_.clear();
  const auto place_seed = static_cast<uint32_t>(place.seed);
  for (SourceBlock* block : blocks) {
    const auto per_doubt = static_cast<float>(rays_per_doubt);
    if (medium_ == nullptr && panes_ == nullptr) {
      AddBlock(*block, block->At(place.position), place_seed, per_doubt, place.sums);
    } else {
      AddBlockThrough(place, *block, per_doubt);
    }
  }
  for (int c = 0; c < 3; ++c) {
    packet_.from[c] = SplatFloat(static_cast<float>(place.position[c]));
  }
  packet_.from_polygon.fill(own_polygon_);
  for (uint32_t l = 0; l < looks_.size(); ++l) {
    if (!looks_[l].exactly || !SeeExactly(place, looks_[l])) Aim(place, l);
  }
  Trace();
  Correct(place);
}

void PointGather::AddBlock(SourceBlock& block, PlanePoint at, uint32_t place_seed,
                           float rays_per_doubt, int64_t* sums) {
  const UInt32Lanes seeds = UInt32Lanes{} + place_seed;
  std::array<int64_t, 3> total = block.even();
  const std::span<const SourceOctet> octets = block.octets();
  for (size_t o = 0; o < octets.size(); ++o) {
    const SourceOctet& octet = octets[o];
    const FloatLanes factor = FormFactors(octet, at);
    const FloatLanes seen = factor * octet.visibility;
    for (int c = 0; c < 3; ++c) total[c] += SumOfRounded(seen * octet.radiosity[c]);
    const FloatLanes least = Select(factor > 0.0F, octet.least_rays, FloatLanes{});
    ListLooks(block, o, factor, Maximum(octet.rays * factor * rays_per_doubt, least), seeds);
  }
  for (const ClusterOctet& octet : block.clusters()) {
    const FloatLanes factor = FormFactors(octet, at);
    for (int c = 0; c < 3; ++c) total[c] += SumOfRounded(factor * octet.radiosity[c]);
  }
  for (int c = 0; c < 3; ++c) sums[c] += total[c];
}

// Wanted rays, rounded at random to whole ones.
void PointGather::ListLooks(SourceBlock& block, size_t octet, FloatLanes factor, FloatLanes wanted,
                            UInt32Lanes place_seed) {
  const SourceOctet& sources = block.octets()[octet];
  const FloatLanes rays = wanted + UnitFromHash(sources.seed ^ place_seed);
  const Int32Lanes exact = (factor > 0.0F) & (factor >= exact_from_w_m2_ * sources.exact_per_w_m2);
  const int exactly = view_ ? Bits(exact) : 0;
  for (int chosen = Bits(rays >= 1.0F) | exactly; chosen != 0; chosen &= chosen - 1) {
    const int lane = std::countr_zero(static_cast<unsigned>(chosen));
    looks_.push_back({&block.target(8 * octet + static_cast<size_t>(lane)), &sources, lane,
                      static_cast<int>(std::min(kMostRays, rays[lane])), factor[lane],
                      std::clamp(1 / wanted[lane], 1.0F, kMostStandFor)});
    looks_.back().exactly = (exactly >> lane & 1) != 0;
  }
}

// False where too much stands between; rays then say what is seen.
bool PointGather::SeeExactly(const GatherPlace& place, Look& look) {
  RayTarget& target = *look.target;
  const ExactView::Source source{
      {target.polygon.v.data(), static_cast<size_t>(target.polygon.count)},
      target.normal,
      target.surface_polygon};
  const std::optional<double> share = view_->ShareSeen(place.position, source, &target.view);
  if (!share) return false;
  look.stands_for = 1;
  look.passed = *share;
  look.total = 1;
  return true;
}

void PointGather::Aim(const GatherPlace& place, uint32_t l) {
  RayTarget& target = *looks_[l].target;
  if (!target.sampler) {
    target.sampler.emplace(DrawnIn(target.polygon, rays_.coordinate_noise_m()));
  }
  Random random(Hash(target.seed, place.seed));
  double u = random.Unit(), v = random.Unit();
  for (int rays = looks_[l].rays; rays > 0; rays -= RayScene::kPacket) {
    const FloatPoints to = target.sampler->At(Sequence(kStepU, u), Sequence(kStepV, v));
    const FloatLanes weight = Kernel(place, to, target.normal);
    for (int i = 0; i < std::min(rays, RayScene::kPacket); ++i) {
      if (!(weight[i] > 0)) continue;
      for (int c = 0; c < 3; ++c) packet_.to[c][count_] = to[c][i];
      packet_.to_polygon[count_] = target.surface_polygon;
      if (target.image != nullptr) mirrored_ |= 1U << count_;
      picks_[count_++] = {l, weight[i]};
      if (count_ == RayScene::kPacket) Trace();
    }
  }
}

// Of the place and eight points of a polygon: cosθ cosθ' / d², 1/m².
FloatLanes PointGather::Kernel(const GatherPlace& place, const FloatPoints& to,
                               const Vec3& normal) const {
  FloatLanes distance2{}, here{}, there{};
  for (int c = 0; c < 3; ++c) {
    const FloatLanes d = to[c] - static_cast<float>(place.position[c]);
    distance2 += d * d;
    here += static_cast<float>(normal_[c]) * d;
    there -= static_cast<float>(normal[c]) * d;
  }
  return Maximum(here / distance2, FloatLanes{}) * Maximum(there / distance2, FloatLanes{});
}

// The rays of the packet that arrive, those to one image together.
uint32_t PointGather::Visible() const {
  if (mirrored_ == 0) return rays_.Visible(packet_);
  RayPacket part = packet_;
  part.valid = packet_.valid & ~mirrored_;
  uint32_t visible = part.valid != 0 ? rays_.Visible(part) : 0;
  const auto image_of = [&](int i) { return looks_[picks_[i].look].target->image; };
  for (uint32_t left = mirrored_; left != 0; left &= ~part.valid) {
    const MirrorImage* image = image_of(std::countr_zero(left));
    part.valid = 0;
    for (int i = 0; i < count_; ++i) {
      if ((left >> i & 1) != 0 && image_of(i) == image) part.valid |= 1U << i;
    }
    visible |= VisibleThrough(rays_, *mirrors_, *image, part, true);
  }
  return visible;
}

void PointGather::Trace() {
  if (count_ == 0) return;
  packet_.valid = (1U << count_) - 1;
  const uint32_t visible = Visible();
  traced_ += static_cast<uint64_t>(count_);
  traced_by_mirrors_ += static_cast<uint64_t>(std::popcount(mirrored_));
  for (int i = 0; i < count_; ++i) {
    Look& look = looks_[picks_[i].look];
    look.total += picks_[i].weight;
    if ((visible >> i & 1) == 0) continue;
    double relative = 1;
    const auto goal = [&] { return Vec3(packet_.to[0][i], packet_.to[1][i], packet_.to[2][i]); };
    if (look.target->varying != kNoNode) {
      Vec3 to = goal();
      if (look.target->image != nullptr) to = look.target->image->back.Point(to);
      relative = sources_.RelativeRadiosityAt(look.target->varying, to);
    }
    look.passed += picks_[i].weight * relative;
    if (panes_ == nullptr || look.target->glazed.kind == Glazed::Kind::kNot) continue;
    const Vec3 from(packet_.from[0][i], packet_.from[1][i], packet_.from[2][i]);
    look.passed_panes +=
        picks_[i].weight * relative * LeftByPanesTo(from, goal(), look.target->image);
  }
  count_ = 0;
  mirrored_ = 0;
}

// Puts what rays saw in the place of the links' visibility. Where one source in so many gets a ray
// it answers for all of them: otherwise the others would keep what the links say, which is wrong
// alike for all where a place is hidden and its surroundings are not.
void PointGather::Correct(const GatherPlace& place) const {
  for (size_t l = 0; l < looks_.size(); ++l) {
    const Look& look = looks_[l];
    if (!(look.total > 0)) continue;
    const float before = look.factor * look.octet->visibility[look.lane];
    const float now = look.factor * static_cast<float>(look.passed / look.total);
    for (int c = 0; c < 3; ++c) {
      float radiosity = look.octet->radiosity[c][look.lane], of_channel = now, known = before;
      if (!left_of_looks_.empty()) {
        const LeftOfLook& left = left_of_looks_[l];
        radiosity *= left.by_medium[static_cast<size_t>(c)];
        known *= left.by_panes[static_cast<size_t>(c)];
        if (look.target->glazed.kind != Glazed::Kind::kNot) {
          of_channel = look.factor * static_cast<float>(look.passed_panes[c] / look.total);
        }
      }
      place.sums[c] += Rounded(look.stands_for * (of_channel - known) * radiosity);
    }
  }
}

}  // namespace isolux
