#include "worker/factors/pair_factor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/coupling/clip.h"
#include "worker/factors/sampled_pair.h"

namespace isolux {
namespace {

// Share of the tolerance for the unobstructed coupling. Its errors have one sign for many pairs of
// a row, where those of clipping do not, so they must be the smaller.
constexpr double kCouplingShare = 0.1;
// An unobstructed coupling below this share of the tolerance is nothing, whatever stands between.
constexpr double kNothing = 0.01;
// Clipping may cost this much for each segment that sampling would take, in PointClipper's measure:
// a segment takes about 1 µs.
constexpr double kWorkOfSegment = 20;
constexpr uint64_t kMostWork =
    20'000'000;  // a second: beyond it the error stays above the tolerance

// Segments that sampling is likely to take: its error falls as N^-0.7. Infinite where it is likely
// not to get there.
double LikelySegments(double coupling_over_tolerance) {
  const double segments = 64 + 2 * coupling_over_tolerance * std::sqrt(coupling_over_tolerance);
  return segments > kMostSegments ? std::numeric_limits<double>::infinity() : segments;
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

PairFactor PairSolver::Solve(const PairEnd& p, const PairEnd& q,
                             std::span<const uint32_t> candidates, double tolerance_m2,
                             uint64_t seed) {
  const OccluderSet& set = tree_->set();
  const double on_plane = set.tolerance_m();
  const CouplingEnd &from = p.polygon, &to = q.polygon;
  PairFactor result;
  if (p.region != kNoRegion && p.region == q.region) return result;
  const ClippedPolygon p_front = ClipToFront(*from.polygon, to.centre, to.normal, on_plane);
  if (p_front.count == 0) return result;
  const ClippedPolygon q_front = ClipToFront(*to.polygon, from.centre, from.normal, on_plane);
  if (q_front.count == 0) return result;

  const ShaftEnd p_end{p_front.corners(), from.normal, p.region};
  const ShaftEnd q_end{q_front.corners(), to.normal, q.region};
  Verdict verdict = Verdict::kOutside;
  if (!candidates.empty()) {
    verdict = tree_->Settle(Shaft(p_end, q_end, on_plane), candidates, &own_);
  }
  if (verdict == Verdict::kBlocks) {
    result.way = Way::kHidden;
    return result;
  }
  const PairCoupling whole = Couple(from, to, kCouplingShare * tolerance_m2);
  if (verdict == Verdict::kOutside) return {whole.coupling_m2, whole.error_m2, Way::kVisible};
  if (whole.coupling_m2 <= kNothing * tolerance_m2) {
    return {0, whole.coupling_m2 + whole.error_m2, Way::kHidden};
  }
  return SolvePartial(p_end, q_end, whole, tolerance_m2, seed);
}

// Clips while that is likely to be cheaper than sampling.
PairFactor PairSolver::SolvePartial(const ShaftEnd& p, const ShaftEnd& q, const PairCoupling& whole,
                                    double tolerance_m2, uint64_t seed) {
  const double own_tolerance_m2 = std::max(tolerance_m2 - whole.error_m2, 0.5 * tolerance_m2);
  const double most_work = kWorkOfSegment * LikelySegments(whole.coupling_m2 / own_tolerance_m2);
  PairFactor result;
  PartialResult part;
  part.finished = false;
  if (4.0 * static_cast<double>(own_.size()) < most_work) {
    part = partial_.Integrate(p, q, own_, whole.coupling_m2, own_tolerance_m2,
                              most_work < kMostWork ? static_cast<uint64_t>(most_work) : kMostWork);
    result = {part.coupling_m2, part.error_m2 + whole.error_m2,
              part.divided ? Way::kDivided : Way::kClipped};
  }
  if (part.finished) return result;
  const VisibleShare share = SampleVisibleShare(p, q, *tree_, whole.coupling_m2,
                                                own_tolerance_m2 / whole.coupling_m2, seed);
  const PairFactor sampled{share.value * whole.coupling_m2,
                           share.error * whole.coupling_m2 + whole.error_m2, Way::kSampled};
  return part.points > 0 && result.error_m2 < sampled.error_m2 ? result : sampled;
}

}  // namespace isolux
