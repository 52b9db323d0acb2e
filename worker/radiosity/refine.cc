#include "worker/radiosity/refine.h"

#include <algorithm>
#include <cmath>

#include "common/util/random.h"
#include "worker/coupling/coupling.h"
#include "worker/coupling/variation.h"
#include "worker/radiosity/cluster_pair.h"
#include "worker/radiosity/evaluate_through.h"
#include "worker/radiosity/glazed_links.h"
#include "worker/radiosity/transmission.h"

namespace isolux {
namespace {

// What a coupling may err by lies within two shares of the smaller end's area (kCouplingShare).
constexpr double kFinestCoupling = 1e-6;
constexpr double kCoarsestCoupling = 1e-2;
// Weights of the oracle's terms, found by error at equal numbers of links: docs/design.md,
// "Oracle".
constexpr double kSpreadWeight = 1.5;
constexpr double kCovarianceWeight = 3.0;
// The end whose own spread exceeds this share of its radiosity is split for better visibility.
constexpr double kSpreadShare = 0.15;
// Both ends are divided at once where each asks for it with this many times the threshold: halves
// of either would still be divided for the other.
constexpr double kBothFrom = 4;
// Elements smaller than this share of the scene are at the resolution of ray casting in float.
constexpr double kSmallestElement = 1e-6;

constexpr uint32_t kDirect = 0xffffffff;

// A pair still to be evaluated, with what is known of the one it was divided from.
struct Pair {
  uint32_t p = 0, q = 0;
  bool visible = false;      // proved
  bool look = true;          // whether candidates are worth looking for
  uint32_t image = kDirect;  // through mirrors: number of the image of q that p sees
  CandidateList candidates;  // of a pair that holds this one
};

// What evaluation finds of a pair.
struct Evaluation {
  LinkVerdict verdict = LinkVerdict::kDrop;
  Proof proof = Proof::kNone;
  bool looked = false;  // for candidates
  uint8_t rays = 0;
  CandidateList candidates;  // for those it is divided into
};

class Evaluator {
 public:
  Evaluator(double epsilon_w, const RefineScene& scene, const Tree& tree)
      : epsilon_w_(epsilon_w),
        scene_(scene),
        tree_(tree),
        smallest_m_(kSmallestElement * tree.hierarchy().extent_m()) {}

  // Makes the link of a pair and judges it. The link is meaningful only where the verdict is keep.
  Evaluation Evaluate(const Pair& pair, Link& link) const {
    link = Link();
    link.p = pair.p;
    link.q = pair.q;
    Evaluation found;
    if (pair.image != kDirect) {
      found.verdict = EvaluateThrough(
          scene_, tree_, epsilon_w_, pair.image, [this](const Link& l) { return Judge(l); }, link,
          &found.rays);
      return found;
    }
    if (tree_.is_cluster(pair.p) || tree_.is_cluster(pair.q)) {
      found.verdict = EvaluateCluster(link, found);
      return found;
    }
    found.verdict = EvaluateElements(pair, link, found);
    // What is divided hands on what may stand between.
    const bool divided = found.verdict != LinkVerdict::kKeep && found.verdict != LinkVerdict::kDrop;
    if (divided && !found.looked) Prove(pair, found);
    return found;
  }

  // The same of a link that is about to be divided, without making it again.
  Evaluation Divide(const Link& link, LinkVerdict verdict) const {
    Evaluation found;
    found.verdict = verdict;
    if (link.through_mirrors() || tree_.is_cluster(link.p) || tree_.is_cluster(link.q)) {
      return found;
    }
    Pair pair;
    pair.p = link.p;
    pair.q = link.q;
    pair.visible = link.visible_rays == Link::kProved;
    Prove(pair, found);
    return found;
  }

  // Judges a link that exists, by the values of now.
  LinkVerdict Judge(const Link& link) const {
    const LinkError error = ErrorOf(tree_, link, tree_.values(link.p), tree_.values(link.q));
    if (error.total_w <= epsilon_w_) return LinkVerdict::kKeep;
    return Possible(link,
                    error.other_w > kBothFrom * epsilon_w_ ? LinkVerdict::kSplitBoth : error.split);
  }

 private:
  LinkVerdict EvaluateCluster(Link& link, Evaluation& found) const {
    const double bound = ClusterBound(tree_, link.p, link.q);
    if (bound <= 0) return LinkVerdict::kDrop;
    link.variation_p = static_cast<float>(bound);
    if (const LinkVerdict verdict = Judge(link); verdict != LinkVerdict::kKeep) return verdict;
    const Meeting meeting = MeetingOf(tree_, link.p, link.q);
    if (meeting == Meeting::kPart) return MixedEnd(tree_, link.p, link.q);
    if (meeting == Meeting::kNothing) return LinkVerdict::kKeep;
    link.unoccluded_m2 =
        static_cast<float>(std::min(bound, ClusterCoupling(tree_, link.p, link.q)));
    if (link.unoccluded_m2 > 0) Sample(nullptr, link, found);
    return LinkVerdict::kKeep;
  }

  LinkVerdict EvaluateElements(const Pair& pair, Link& link, Evaluation& found) const {
    const Hierarchy& hierarchy = tree_.hierarchy();
    if (hierarchy.plane_of(tree_.surface_of(link.p).polygon) ==
        hierarchy.plane_of(tree_.surface_of(link.q).polygon)) {
      return LinkVerdict::kDrop;
    }
    const CouplingEnd p = tree_.end(link.p), q = tree_.end(link.q);
    const FormFactorRanges ranges = RangesOver(p, q);
    const LinkVerdict at_least = JudgeAtLeast(pair, ranges, link);
    if (at_least != LinkVerdict::kKeep) return at_least;
    const double brighter =
        std::max(tree_.values(link.p).radiosity, tree_.values(link.q).radiosity);
    const double smaller_m2 = std::min(p.area_m2, q.area_m2);
    const double wanted_m2 = kCouplingShare * epsilon_w_ / std::max(brighter, 1e-300);
    const PairCoupling coupling = Couple(
        p, q, std::clamp(wanted_m2, kFinestCoupling * smaller_m2, kCoarsestCoupling * smaller_m2));
    if (!(coupling.coupling_m2 > 0)) return LinkVerdict::kDrop;
    link.unoccluded_m2 = static_cast<float>(coupling.coupling_m2);
    const FormFactorVariation variation = VariationWith(ranges, p, q, coupling.coupling_m2);
    link.variation_p = static_cast<float>(variation.over_p);
    link.variation_q = static_cast<float>(variation.over_q);
    if (scene_.medium != nullptr) VaryByMedium(*scene_.medium, *p.polygon, *q.polygon, &link);
    if (scene_.panes != nullptr) {
      VaryByPanes(*scene_.panes, *p.polygon, *q.polygon, nullptr, &link);
    }
    link.visible_rays = 0;
    link.error_code = EncodeCouplingError(coupling.error_m2, coupling.coupling_m2);
    link.visible_share = 65535;
    // Whatever stands between, such a link is too uncertain: split it without looking.
    if (scene_.occlusion && !pair.visible &&
        kSmallestDeviation * coupling.coupling_m2 * brighter > epsilon_w_) {
      link.visible_rays = Link::kRays;
      if (const LinkVerdict verdict = Judge(link); verdict != LinkVerdict::kKeep) return verdict;
    }
    if (pair.visible || (pair.candidates && pair.candidates->size() <= LinkProver::kShort)) {
      Prove(pair, found);
    }
    if (found.proof == Proof::kHidden) return LinkVerdict::kDrop;
    const CandidateList& among = found.candidates ? found.candidates : pair.candidates;
    if (found.proof == Proof::kVisible) {
      link.visible_rays = Link::kProved;
    } else {
      Sample(among, link, found);
    }
    const LinkVerdict verdict = Judge(link);
    if (verdict == LinkVerdict::kKeep && link.visible_rays != Link::kProved) {
      SampleAgain(among, link, found);
    }
    return verdict;
  }

  // By how much form factors vary, whatever the coupling is and whatever rays will see: most pairs
  // that are divided need no more.
  LinkVerdict JudgeAtLeast(const Pair& pair, const FormFactorRanges& ranges, Link& link) const {
    const FormFactorVariation least = ranges.Variation();
    link.variation_p = static_cast<float>(least.over_p);
    link.variation_q = static_cast<float>(least.over_q);
    link.visible_rays = pair.visible || !scene_.occlusion ? Link::kProved : 0;
    return Judge(link);
  }

  // What stands between the ends of a pair of elements.
  void Prove(const Pair& pair, Evaluation& found) const {
    found.looked = true;
    if (pair.visible || scene_.prover == nullptr) {
      found.proof = pair.visible ? Proof::kVisible : Proof::kNone;
      return;
    }
    if (!pair.candidates && !pair.look) return;
    found.proof = scene_.prover->Settle(tree_, pair.p, pair.q, pair.candidates, &found.candidates);
  }

  // By rays, of the ends of a link; `among`: all that may stand between, where that is known.
  SampledVisibility Look(const Link& link, const CandidateList& among, uint64_t seed) const {
    if (!among) return SampleVisibility(tree_, *scene_.rays, link.p, link.q, seed);
    const Obstacles known{scene_.prover->rays(), *among};
    return SampleVisibility(tree_, *scene_.rays, link.p, link.q, seed, &known);
  }

  void Sample(const CandidateList& among, Link& link, Evaluation& found) const {
    if (!scene_.occlusion) {
      link.visible_share = 65535;
      link.visible_rays = Link::kProved;
      return;
    }
    const SampledVisibility sampled = Look(link, among, scene_.seed);
    found.rays = static_cast<uint8_t>(sampled.traced);
    link.visible_share = static_cast<uint16_t>(std::lround(sampled.share * 65535));
    link.visible_rays = static_cast<uint8_t>(sampled.visible);
  }

  // See kValue.
  void SampleAgain(const CandidateList& among, Link& link, Evaluation& found) const {
    const SampledVisibility sampled = Look(link, among, Hash(scene_.seed, kValue));
    found.rays = static_cast<uint8_t>(found.rays + sampled.traced);
    link.visible_share = static_cast<uint16_t>(std::lround(sampled.share * 65535));
  }

  // The split asked for, or that of one end, or none: what the numbers can still resolve.
  LinkVerdict Possible(const Link& link, LinkVerdict wanted) const {
    const auto divisible = [&](uint32_t node) {
      return tree_.is_cluster(node) ||
             (tree_.node(node).id.level() < kMaxLevel && SizeOf(tree_, node) > smallest_m_);
    };
    if (wanted == LinkVerdict::kSplitBoth) {
      if (divisible(link.p) && divisible(link.q)) return wanted;
      wanted = LinkVerdict::kSplitP;
    }
    const bool first = wanted == LinkVerdict::kSplitP;
    if (divisible(first ? link.p : link.q)) return wanted;
    if (divisible(first ? link.q : link.p))
      return first ? LinkVerdict::kSplitQ : LinkVerdict::kSplitP;
    return LinkVerdict::kKeep;
  }

  double epsilon_w_;
  const RefineScene& scene_;
  const Tree& tree_;
  double smallest_m_;
};

// Wave after wave: evaluates pairs in parallel, then divides nodes and makes the next pairs alone.
class Wavefront {
 public:
  Wavefront(double epsilon_w, const RefineScene& scene, Tree& tree, Placement& placement,
            ThreadPool& pool, LinkSet& links, RefineCounters& counters)
      : evaluator_(epsilon_w, scene, tree),
        tree_(tree),
        placement_(placement),
        pool_(pool),
        links_(links),
        counters_(counters) {}

  void Start() {
    if (links_.own.empty() && links_.crown.empty()) {
      frontier_.push_back({0, 0, false, true, kDirect, nullptr});
      const size_t images = tree_.mirrors() == nullptr ? 0 : tree_.mirrors()->images().size();
      for (uint32_t i = 0; i < images; ++i) frontier_.push_back({0, 0, false, false, i, nullptr});
      return;
    }
    Rejudge(links_.own);
    Rejudge(links_.crown);
  }

  bool Done() const { return frontier_.empty(); }

  // One wave, or a part of it where it is long.
  void Step() {
    constexpr size_t kMost = 1 << 18;
    std::vector<Pair> wave;
    if (frontier_.size() <= kMost) {
      wave.swap(frontier_);
    } else {
      wave.assign(std::make_move_iterator(frontier_.end() - kMost),
                  std::make_move_iterator(frontier_.end()));
      frontier_.resize(frontier_.size() - kMost);
    }
    result_.resize(wave.size());
    found_.resize(wave.size());
    pool_.For(wave.size(), 128, [&](size_t begin, size_t end, int) {
      for (size_t i = begin; i < end; ++i) found_[i] = evaluator_.Evaluate(wave[i], result_[i]);
    });
    for (size_t i = 0; i < wave.size(); ++i) {
      Count(wave[i], found_[i]);
      if (found_[i].verdict == LinkVerdict::kKeep) {
        (placement_.IsCrownLink(wave[i].p, wave[i].q) ? links_.crown : links_.own)
            .push_back(result_[i]);
      } else if (found_[i].verdict != LinkVerdict::kDrop) {
        Expand(wave[i], found_[i]);
      }
    }
  }

 private:
  // Work that every worker repeats is counted by one.
  void Count(const Pair& pair, const Evaluation& found) {
    const uint32_t owner = placement_.OwnerCut(pair.p, pair.q);
    if (placement_.assignment().home[owner] != placement_.self()) return;
    ++counters_.evaluations;
    ++counters_.evaluations_of_cut[owner];
    (pair.image == kDirect ? counters_.rays : counters_.image_rays) += found.rays;
    counters_.image_evaluations += pair.image == kDirect ? 0 : 1;
    counters_.proved_visible += found.proof == Proof::kVisible ? 1 : 0;
    counters_.proved_hidden += found.proof == Proof::kHidden ? 1 : 0;
  }

  // Takes out of `links` those that need splitting.
  void Rejudge(std::vector<Link>& links) {
    found_.resize(links.size());
    pool_.For(links.size(), 4096, [&](size_t begin, size_t end, int) {
      for (size_t i = begin; i < end; ++i) {
        const LinkVerdict verdict = evaluator_.Judge(links[i]);
        found_[i] = Evaluation();
        found_[i].verdict = verdict;
        if (verdict != LinkVerdict::kKeep) found_[i] = evaluator_.Divide(links[i], verdict);
      }
    });
    size_t kept = 0;
    for (size_t i = 0; i < links.size(); ++i) {
      if (found_[i].verdict == LinkVerdict::kKeep) {
        links[kept++] = links[i];
      } else {
        const uint32_t image = links[i].through_mirrors() ? links[i].image() : kDirect;
        Expand({links[i].p, links[i].q, false, true, image, nullptr}, found_[i]);
      }
    }
    links.resize(kept);
  }

  void Expand(const Pair& pair, const Evaluation& found) {
    if (found.proof == Proof::kHidden) return;
    Pair part;
    part.visible = found.proof == Proof::kVisible;
    part.candidates = found.candidates;
    // Where there were too many candidates, half the shaft will not have few.
    part.look = !(found.looked && pair.look && !found.candidates);
    if (found.verdict == LinkVerdict::kSplitBoth) return ExpandBoth(pair, part);
    const bool first = found.verdict == LinkVerdict::kSplitP;
    const uint32_t split = first ? pair.p : pair.q, other = first ? pair.q : pair.p;
    part.image = first || pair.p == pair.q ? pair.image : ReverseOf(pair.image);
    MakeChildren(split);
    tree_.ForEachChild(split, [&](uint32_t child) {
      if (pair.p != pair.q) return Add(child, other, part);
      // A node with itself: each pair of children once.
      tree_.ForEachChild(split, [&](uint32_t sibling) {
        if (!(tree_.node(sibling).id < tree_.node(child).id)) Add(child, sibling, part);
      });
    });
  }

  void ExpandBoth(const Pair& pair, Pair part) {
    part.image = pair.image;
    MakeChildren(pair.p);
    MakeChildren(pair.q);
    tree_.ForEachChild(pair.p, [&](uint32_t of_p) {
      tree_.ForEachChild(pair.q, [&](uint32_t of_q) { Add(of_p, of_q, part); });
    });
  }

  void MakeChildren(uint32_t node) {
    if (tree_.is_cluster(node)) return;
    tree_.MakeChildren(node);
    placement_.Extend(tree_);
  }

  uint32_t ReverseOf(uint32_t image) const {
    return image == kDirect ? image : tree_.mirrors()->images()[image].reverse;
  }

  void Add(uint32_t a, uint32_t b, Pair pair) {
    // A plane does not see itself.
    if (a == b && !tree_.is_cluster(a) && pair.image == kDirect) return;
    const bool ordered = tree_.node(a).id < tree_.node(b).id;
    pair.p = ordered ? a : b;
    pair.q = ordered ? b : a;
    if (!ordered && a != b) pair.image = ReverseOf(pair.image);
    if (!placement_.IsCrownLink(a, b) && placement_.HomeOfLink(a, b) != placement_.self()) return;
    frontier_.push_back(std::move(pair));
  }

  Evaluator evaluator_;
  Tree& tree_;
  Placement& placement_;
  ThreadPool& pool_;
  LinkSet& links_;
  RefineCounters& counters_;
  std::vector<Pair> frontier_;
  std::vector<Link> result_;
  std::vector<Evaluation> found_;
};

}  // namespace

LinkError ErrorOf(const Tree& tree, const Link& link, const NodeValues& p, const NodeValues& q) {
  LinkError error;
  if (tree.is_cluster(link.p) || tree.is_cluster(link.q)) {
    // Judged by all that could be exchanged at most. What is likely wrong is half of what is
    // exchanged, since few directions stand for all, and what eight rays do not tell.
    const double exchanged = link.coupling_m2();
    const double unseen = link.unoccluded_m2 * link.visibility_deviation();
    error.coupling_p_w = exchanged * q.radiosity;
    error.coupling_q_w = exchanged * p.radiosity;
    error.visibility_p_w = unseen * q.radiosity;
    error.visibility_q_w = unseen * p.radiosity;
    error.total_w = link.variation_p * static_cast<double>(std::max(p.radiosity, q.radiosity));
    error.split =
        SizeOf(tree, link.p) >= SizeOf(tree, link.q) ? LinkVerdict::kSplitP : LinkVerdict::kSplitQ;
    return error;
  }
  const double deviation = link.visibility_deviation();
  const double share =
      link.rays() == Link::kProved
          ? 1.0
          : (link.rays() + 1.0) / (Link::kRays + 2.0);  // of the rays that judge: SampleAgain
  const double unoccluded = link.unoccluded_m2;
  const double flux_p = tree.area_m2(link.p) * link.variation_p * share;  // A ΔF V, m²
  const double flux_q = tree.area_m2(link.q) * link.variation_q * share;

  const double receiver_p = q.radiosity * flux_p;
  const double receiver_q = p.radiosity * flux_q;
  error.spread_p_w = kSpreadWeight * q.spread * flux_q;
  error.spread_q_w = kSpreadWeight * p.spread * flux_p;
  const double covariance_p = kCovarianceWeight * unoccluded * deviation * q.deviation;
  const double covariance_q = kCovarianceWeight * unoccluded * deviation * p.deviation;
  const double sampling_p = unoccluded * deviation * q.radiosity;
  const double sampling_q = unoccluded * deviation * p.radiosity;
  error.visibility_p_w = sampling_p + covariance_p;
  error.visibility_q_w = sampling_q + covariance_q;
  error.coupling_p_w = link.coupling_error_m2() * q.radiosity;
  error.coupling_q_w = link.coupling_error_m2() * p.radiosity;
  error.total_w =
      std::max(receiver_p + error.spread_p_w + error.visibility_p_w + error.coupling_p_w,
               receiver_q + error.spread_q_w + error.visibility_q_w + error.coupling_q_w);

  // The largest term decides which end to split. Better visibility: the end that varies, else the
  // larger one.
  const double for_p = std::max({receiver_p, error.spread_q_w, covariance_q});
  const double for_q = std::max({receiver_q, error.spread_p_w, covariance_p});
  const double for_visibility =
      std::max(sampling_p, sampling_q) + std::max(error.coupling_p_w, error.coupling_q_w);
  if (for_visibility > std::max(for_p, for_q)) {
    const bool p_varies = p.spread > kSpreadShare * p.radiosity;
    const bool q_varies = q.spread > kSpreadShare * q.radiosity;
    const bool p_larger = tree.area_m2(link.p) >= tree.area_m2(link.q);
    error.split =
        (p_varies != q_varies ? p_varies : p_larger) ? LinkVerdict::kSplitP : LinkVerdict::kSplitQ;
  } else {
    error.split = for_p >= for_q ? LinkVerdict::kSplitP : LinkVerdict::kSplitQ;
    const double smaller = std::min(for_p, for_q);
    if (2 * smaller >= std::max(for_p, for_q) && link.p != link.q) error.other_w = smaller;
  }
  return error;
}

Status Refine(double epsilon_w, const RefineScene& scene, Tree& tree, Placement& placement,
              ThreadPool& pool, LinkSet& links, RefineCounters& counters,
              const std::function<bool()>& cancelled) {
  counters.evaluations_of_cut.resize(placement.cut_size(), 0);
  Wavefront wavefront(epsilon_w, scene, tree, placement, pool, links, counters);
  wavefront.Start();
  while (!wavefront.Done()) {
    if (cancelled && cancelled()) return {StatusCode::kCancelled, "refinement was cancelled"};
    wavefront.Step();
  }
  return {};
}

}  // namespace isolux
