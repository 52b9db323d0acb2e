// Refinement: the oracle that judges a link, and the wavefront that replaces links by finer ones
// until none has an error above ε.
//
// A link is judged by its own geometry and by the values its ends had at the start of the round, as
// the tree holds them; so the links after a round do not depend on who refined them in what order.
//
// The oracle (Hanrahan et al. 1991; Lischinski et al. 1994, two-sided): error of incident power, W,
//   e(p←q) = B_q (A_p ΔF_p + ΔC + C σ_V) + 3/2 s_q A_q ΔF_q + 3 C σ_V σ_q
// ΔF_p: variation of F(x→q) over p; s_q, σ_q: range and deviation of B over q; σ_V: deviation of
// visibility. Receivers count whether or not they reflect.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/hierarchy/panes.h"
#include "common/scene/effect_costs.h"
#include "common/scene/medium.h"
#include "common/util/parallel.h"
#include "common/util/status.h"
#include "worker/radiosity/link.h"
#include "worker/radiosity/link_proof.h"
#include "worker/radiosity/placement.h"
#include "worker/radiosity/ray_scene.h"
#include "worker/radiosity/tree.h"
#include "worker/radiosity/visibility.h"

namespace isolux {

// What to do with a link.
enum class LinkVerdict : uint8_t { kKeep, kDrop, kSplitP, kSplitQ, kSplitBoth };

// What a coupling may err by: a share of the threshold, so small that its error splits hardly any
// link. Measured: with 3 % of the threshold there are 0.5 % more links than with exact couplings,
// with 1e-2 of the smaller area alone 70 % more.
inline constexpr double kCouplingShare = 0.03;
// Deviation of visibility when all rays agree: nothing sampled can have less.
inline constexpr double kSmallestDeviation = 0.3;
// A link is kept by rays that agree, which are no fair sample of what passes: through a small hole
// none does, and where one did the link was divided. So its value is that of other rays, whose seed
// this tells from that of those that judge. Power through a hole of a tenth of a wall's width, over
// the exact: .72 with one packet at 12,000 links, .82 at 94,000; with two .99 and 1.00.
inline constexpr uint64_t kValue = 0x7a10e;

// The terms of a link's error that remain when irradiance is gathered point by point, and the
// whole.
struct LinkError {
  double total_w = 0;                             // larger of the two directions
  double spread_p_w = 0, spread_q_w = 0;          // source variation, in power at p and at q
  double visibility_p_w = 0, visibility_q_w = 0;  // with the covariance of visibility and source
  double coupling_p_w = 0, coupling_q_w = 0;
  LinkVerdict split = LinkVerdict::kSplitP;  // what the largest term asks for
  double other_w = 0;  // what the end not named there asks with, if that is half as much at least
};
LinkError ErrorOf(const Tree& tree, const Link& link, const NodeValues& p, const NodeValues& q);

struct RefineCounters {
  uint64_t evaluations = 0, image_evaluations = 0;  // of them, through mirrors
  uint64_t rays = 0, image_rays = 0;                // straight, and through mirrors
  LightRays light_rays;
  uint64_t proved_visible = 0, proved_hidden = 0;  // evaluations, without a ray
  std::vector<uint64_t> evaluations_of_cut;        // by owner
};

// What refinement reads but never changes.
struct RefineScene {
  const RayScene* rays = nullptr;
  uint64_t seed = 1;
  bool occlusion = true;               // whether anything may stand between
  const LinkProver* prover = nullptr;  // null: rays alone
  const Medium* medium = nullptr;      // null: none
  const Panes* panes = nullptr;        // likewise
};

// The links of one worker: those of its own blocks, and the crown's, which every worker keeps.
struct LinkSet {
  std::vector<Link> own;
  std::vector<Link> crown;
};

// Replaces every link whose error exceeds epsilon_w, until none does. An empty set starts from the
// root's link to itself. Returns kCancelled when `cancelled` says so.
Status Refine(double epsilon_w, const RefineScene& scene, Tree& tree, Placement& placement,
              ThreadPool& pool, LinkSet& links, RefineCounters& counters,
              const std::function<bool()>& cancelled);

}  // namespace isolux
