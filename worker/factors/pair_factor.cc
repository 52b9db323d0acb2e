#include "worker/factors/pair_factor.h"

#include <algorithm>

#include "worker/coupling/clip.h"
#include "worker/factors/sampled_pair.h"

namespace isolux {
namespace {

// Share of the tolerance for the unobstructed coupling. Its errors have one sign for many pairs of
// a row, where those of clipping do not, so they must be the smaller.
constexpr double kCouplingShare = 0.1;
// An unobstructed coupling below this share of the tolerance is nothing, whatever stands between.
constexpr double kNothing = 0.01;
// Up to here occluders are always clipped.
constexpr size_t kFewCandidates = 8;

// Whether segments cost less than clipping. Measured: 0.25 µs for an occluder at a point, 32 points
// at least; 0.8 µs for a segment, whose error falls as N^-0.7 from half the coupling.
bool SamplingIsCheaper(size_t candidates, double unobstructed_m2, double tolerance_m2) {
  if (candidates <= kFewCandidates) return false;
  const double ratio = 0.5 * unobstructed_m2 / tolerance_m2;
  return 0.8 * ratio * std::max(ratio, 1.0) < 32 * 0.25 * static_cast<double>(candidates);
}

}  // namespace

const char* ToText(Way way) {
  switch (way) {
    case Way::kFacingAway:
      return "facing away";
    case Way::kVisible:
      return "proved visible";
    case Way::kHidden:
      return "proved hidden";
    case Way::kClipped:
      return "clipped";
    case Way::kDivided:
      return "divided and clipped";
    case Way::kSampled:
      return "sampled";
  }
  return "unknown";
}

PairFactor PairSolver::Solve(const CouplingEnd& p, const CouplingEnd& q,
                             std::span<const uint32_t> candidates, double tolerance_m2,
                             uint64_t seed) {
  const OccluderSet& set = tree_->set();
  const double on_plane = set.tolerance_m();
  PairFactor result;
  const ClippedPolygon p_front = ClipToFront(*p.polygon, q.centre, q.normal, on_plane);
  if (p_front.count == 0) return result;
  const ClippedPolygon q_front = ClipToFront(*q.polygon, p.centre, p.normal, on_plane);
  if (q_front.count == 0) return result;

  const ShaftEnd p_end{{p_front.v.data(), static_cast<size_t>(p_front.count)}, p.normal};
  const ShaftEnd q_end{{q_front.v.data(), static_cast<size_t>(q_front.count)}, q.normal};
  Verdict verdict = Verdict::kOutside;
  if (!candidates.empty()) {
    verdict = tree_->Settle(Shaft(p_end, q_end, on_plane), candidates, &own_);
  }
  if (verdict == Verdict::kBlocks) {
    result.way = Way::kHidden;
    return result;
  }
  const PairCoupling whole = Couple(p, q, kCouplingShare * tolerance_m2);
  if (verdict == Verdict::kOutside) return {whole.coupling_m2, whole.error_m2, Way::kVisible};
  if (whole.coupling_m2 <= kNothing * tolerance_m2) {
    return {0, whole.coupling_m2 + whole.error_m2, Way::kHidden};
  }
  if (SamplingIsCheaper(own_.size(), whole.coupling_m2, tolerance_m2)) {
    const VisibleShare share =
        SampleVisibleShare(p_end, q_end, *tree_, tolerance_m2 / whole.coupling_m2, seed);
    return {share.value * whole.coupling_m2, share.error * whole.coupling_m2 + whole.error_m2,
            Way::kSampled};
  }
  const PartialResult part =
      partial_.Integrate(p_end, q_end, own_, whole.coupling_m2, tolerance_m2);
  return {part.coupling_m2, part.error_m2 + whole.error_m2,
          part.divided ? Way::kDivided : Way::kClipped};
}

}  // namespace isolux
