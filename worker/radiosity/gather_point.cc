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

// From one point to one source: at first, at least, and with those that follow where the first
// disagree, at most.
constexpr int kFirstRays = 16, kMostRays = 128;
// So many first rays that what all of them may miss, a strip at the edge of the source, brings no
// more than this many times what a point may be off by. Where no such number is to be had, as
// behind a pinhole, none follow: to ask for more only where some pass would lose light.
constexpr float kMissed = 4;
// More than so many times what a source asked for at first do not follow, but kFirstRays may.
constexpr float kMostMore = 4;
// Of a source that gets a ray by a small chance, what it sees counts for those that get none; but
// not for more than this, lest single rays decide.
constexpr float kMostStandFor = 8;

// A shifted additive sequence: even over a polygon whatever the number of points ([Roberts18]).
// Terms from `at` on, eight at most; `at` is moved past them.
constexpr double kStepU = 0.75487766624669276, kStepV = 0.56984029099805327;
FloatLanes Sequence(double step, int count, double& at) {
  FloatLanes terms{};
  for (int i = 0; i < count; ++i) {
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

void PointGather::Evaluate(const GatherPlace& place, std::span<SourceBlock* const> blocks) {
  looks_.clear();
  left_of_looks_.clear();
  const auto place_seed = static_cast<uint32_t>(place.seed);
  for (SourceBlock* block : blocks) {
    if (medium_ == nullptr && panes_ == nullptr) {
      AddBlock(*block, block->At(place.position), place_seed, place.sums);
    } else {
      AddBlockThrough(place, *block);
    }
  }
  for (int c = 0; c < 3; ++c) {
    packet_.from[c] = SplatFloat(static_cast<float>(place.position[c]));
  }
  packet_.from_polygon.fill(own_polygon_);
  for (uint32_t l = 0; l < looks_.size(); ++l) {
    Look& look = looks_[l];
    if (look.exactly && SeeExactly(place, look)) continue;
    Random random(Hash(look.target->seed, place.seed));
    look.u = random.Unit();
    look.v = random.Unit();
    Aim(place, l,
        static_cast<int>(std::min(look.wanted, std::max<float>(kFirstRays, CarefulRays(look)))));
  }
  Trace();
  for (uint32_t l = 0; l < looks_.size(); ++l) Aim(place, l, MoreRays(looks_[l]));
  Trace();
  Correct(place);
}

void PointGather::AddBlock(SourceBlock& block, PlanePoint at, uint32_t place_seed, int64_t* sums) {
  const UInt32Lanes seeds = UInt32Lanes{} + place_seed;
  std::array<int64_t, 3> total = block.even();
  const std::span<const SourceOctet> octets = block.octets();
  for (size_t o = 0; o < octets.size(); ++o) {
    const SourceOctet& octet = octets[o];
    const FloatLanes factor = FormFactors(octet, at);
    const FloatLanes seen = factor * octet.visibility;
    for (int c = 0; c < 3; ++c) total[c] += SumOfRounded(seen * octet.radiosity[c]);
    ListLooks(block, o, factor, seeds);
  }
  for (const ClusterOctet& octet : block.clusters()) {
    const FloatLanes factor = FormFactors(octet, at);
    for (int c = 0; c < 3; ++c) total[c] += SumOfRounded(factor * octet.radiosity[c]);
  }
  for (int c = 0; c < 3; ++c) sums[c] += total[c];
}

// Wanted rays, rounded at random to whole ones.
void PointGather::ListLooks(SourceBlock& block, size_t octet, FloatLanes factor,
                            UInt32Lanes place_seed) {
  const SourceOctet& sources = block.octets()[octet];
  const FloatLanes wanted =
      Maximum(sources.doubt * factor * rays_per_doubt_,
              Minimum(sources.brings * factor * rays_per_w_m2_, SplatFloat(1)));
  const FloatLanes rays = wanted + UnitFromHash(sources.seed ^ place_seed);
  const Int32Lanes exact = (factor > 0.0F) & (factor >= exact_from_w_m2_ * sources.exact_per_w_m2);
  const int exactly = view_ ? Bits(exact) : 0;
  for (int chosen = Bits(rays >= 1.0F) | exactly; chosen != 0; chosen &= chosen - 1) {
    const int lane = std::countr_zero(static_cast<unsigned>(chosen));
    looks_.push_back({&block.target(8 * octet + static_cast<size_t>(lane)), &sources, lane,
                      rays[lane], factor[lane], std::clamp(1 / wanted[lane], 1.0F, kMostStandFor),
                      (exactly >> lane & 1) != 0});
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

float PointGather::Brings(const Look& look) const {
  const auto& radiosity = look.octet->radiosity;
  return look.factor *
         (radiosity[0][look.lane] + radiosity[1][look.lane] + radiosity[2][look.lane]);
}

float PointGather::CarefulRays(const Look& look) const {
  return Brings(look) / (kMissed * static_cast<float>(tolerance_));
}

// Points that are spread evenly err by about the power −4/5 of their number.
int PointGather::MoreRays(const Look& look) const {
  if (look.rays < 2 || !(look.total > 0)) return 0;
  if (CarefulRays(look) > look.wanted) return 0;
  const double mean = look.passed / look.total;
  const double variance = look.squares / look.total - mean * mean;
  if (!(variance > 0)) return 0;
  const double off = Brings(look) * std::sqrt(variance) / tolerance_;
  const double most = std::clamp<double>(kMostMore * look.wanted, kFirstRays, kMostRays);
  return static_cast<int>(std::min(most, off * std::sqrt(std::sqrt(off)))) - look.rays;
}

void PointGather::Aim(const GatherPlace& place, uint32_t l, int rays) {
  if (rays <= 0) return;
  Look& look = looks_[l];
  RayTarget& target = *look.target;
  if (!target.sampler) {
    target.sampler.emplace(DrawnIn(target.polygon, rays_.coordinate_noise_m()));
  }
  look.rays += rays;
  for (; rays > 0; rays -= RayScene::kPacket) {
    const int count = std::min(rays, RayScene::kPacket);
    const FloatLanes u = Sequence(kStepU, count, look.u);
    const FloatPoints to = target.sampler->At(u, Sequence(kStepV, count, look.v));
    const FloatLanes weight = Kernel(place, to, target.normal);
    for (int i = 0; i < count; ++i) {
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
    look.squares += picks_[i].weight * relative * relative;
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
