#include "worker/radiosity/link_counts.h"

#include <bit>

#include "common/util/random.h"

namespace isolux {
namespace {

uint64_t HashOfLink(const Tree& tree, const Link& link) {
  const NodeId& p = tree.node(link.p).id;
  const NodeId& q = tree.node(link.q).id;
  return Hash(Hash(Hash(p.surface, p.path), Hash(q.surface, q.path)),
              std::bit_cast<uint32_t>(link.unoccluded_m2), link.visible_share);
}

}  // namespace

void CountLinks(const Tree& tree, const Placement& placement, const LinkSet& links,
                const ActiveNodes& nodes, const RefineCounters& counters, double refine_cpu_s,
                double solve_cpu_s, RoundReport& report) {
  const uint32_t cut_size = placement.cut_size();
  report.evaluations = counters.evaluations;
  report.proved_visible = counters.proved_visible;
  report.proved_hidden = counters.proved_hidden;
  report.rays += counters.rays + counters.image_rays + counters.light_rays.Total();
  report.cut_links.assign(cut_size, 0);
  report.cut_elements.assign(cut_size, 0);
  report.cut_cost_ns.assign(cut_size, 0);
  const auto count = [&](const Link& link) {
    ++report.links;
    if (link.through_mirrors()) ++report.costs["mirrors"].links;
    ++report.cut_links[placement.OwnerCut(link.p, link.q)];
  };
  for (const Link& link : links.own) count(link);
  for (const Link& link : links.crown) {
    report.crown_hash += HashOfLink(tree, link);
    if (placement.HomeOfLink(link.p, link.q) == placement.self()) count(link);
  }
  for (const uint32_t node : nodes.leaves) ++report.cut_elements[placement.CutOf(node)];
  report.leaves = nodes.leaves.size();
  for (uint32_t c = 0; c < cut_size; ++c) {
    const double evaluated = counters.evaluations > 0
                                 ? static_cast<double>(counters.evaluations_of_cut[c]) /
                                       static_cast<double>(counters.evaluations)
                                 : 0.0;
    const double linked = report.links > 0 ? static_cast<double>(report.cut_links[c]) /
                                                 static_cast<double>(report.links)
                                           : 0.0;
    report.cut_cost_ns[c] = 1e9 * (refine_cpu_s * evaluated + solve_cpu_s * linked);
  }
}

}  // namespace isolux
