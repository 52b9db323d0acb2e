#include "worker/radiosity/evaluate_through.h"

#include <algorithm>

#include "common/util/random.h"
#include "worker/radiosity/cluster_pair.h"
#include "worker/radiosity/couple_through.h"
#include "worker/radiosity/glazed_links.h"
#include "worker/radiosity/transmission.h"

namespace isolux {
namespace {

void Sample(const RefineScene& scene, const Tree& tree, uint32_t image, Link& link, uint8_t* rays) {
  const SampledVisibility sampled =
      SampleThrough(tree, *scene.rays, image, link.p, link.q, scene.occlusion, scene.seed);
  *rays = static_cast<uint8_t>(sampled.traced);
  link.SetThroughMirrors(image, sampled.share, sampled.visible);
}

}  // namespace

LinkVerdict EvaluateThrough(const RefineScene& scene, const Tree& tree, double epsilon_w,
                            uint32_t image, const std::function<LinkVerdict(const Link&)>& judge,
                            Link& link, uint8_t* rays) {
  link.SetThroughMirrors(image, 1, Link::kRays);
  if (tree.is_cluster(link.p) || tree.is_cluster(link.q)) {
    link.variation_p = static_cast<float>(BoundThrough(tree, image, link.p, link.q));
    if (!(link.variation_p > 0)) return LinkVerdict::kDrop;
    if (const LinkVerdict verdict = judge(link); verdict != LinkVerdict::kKeep) return verdict;
    const Meeting meeting = MeetingOf(tree, link.p, link.q);
    if (meeting == Meeting::kPart) return MixedEnd(tree, link.p, link.q);
    if (meeting == Meeting::kNothing) return LinkVerdict::kKeep;
    link.unoccluded_m2 = static_cast<float>(
        std::min<double>(link.variation_p, ClusterCouplingThrough(tree, image, link.p, link.q)));
    if (link.unoccluded_m2 > 0) Sample(scene, tree, image, link, rays);
    return LinkVerdict::kKeep;
  }
  const double brighter = std::max(tree.values(link.p).radiosity, tree.values(link.q).radiosity);
  const double wanted_m2 = kCouplingShare * epsilon_w / std::max(brighter, 1e-300);
  const ThroughMirrors made = CoupleThrough(tree, image, link.p, link.q, wanted_m2);
  if (!(made.coupling_m2 > 0)) return LinkVerdict::kDrop;
  link.unoccluded_m2 = static_cast<float>(made.coupling_m2);
  link.variation_p = static_cast<float>(made.variation_p);
  link.variation_q = static_cast<float>(made.variation_q);
  if (scene.medium != nullptr) {
    const ConvexPolygon there = tree.mirrors()->images()[image].image.Of(tree.polygon(link.q));
    VaryByMedium(*scene.medium, tree.polygon(link.p), there, &link);
  }
  if (scene.panes != nullptr) {
    const MirrorImage& through = tree.mirrors()->images()[image];
    VaryByPanes(*scene.panes, tree.polygon(link.p), through.image.Of(tree.polygon(link.q)),
                &through, &link);
  }
  if (made.passage == Passage::kAll && !scene.occlusion) {
    link.SetThroughMirrors(image, 1, Link::kProved);
    return judge(link);
  }
  // Whatever stands between, such a link is too uncertain: split it without looking.
  if (kSmallestDeviation * made.coupling_m2 * brighter > epsilon_w) {
    if (const LinkVerdict verdict = judge(link); verdict != LinkVerdict::kKeep) return verdict;
  }
  Sample(scene, tree, image, link, rays);
  const LinkVerdict verdict = judge(link);
  if (verdict != LinkVerdict::kKeep) return verdict;
  // Of other rays than those that judged it: see kValue.
  const SampledVisibility sampled = SampleThrough(tree, *scene.rays, image, link.p, link.q,
                                                  scene.occlusion, Hash(scene.seed, kValue));
  *rays = static_cast<uint8_t>(*rays + sampled.traced);
  link.SetThroughMirrors(image, sampled.share, link.rays());
  return verdict;
}

}  // namespace isolux
