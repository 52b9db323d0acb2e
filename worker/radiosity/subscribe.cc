#include "worker/radiosity/subscribe.h"

#include <algorithm>

#include "worker/radiosity/sheet_leaves.h"
#include "worker/radiosity/slots.h"

namespace isolux {
namespace {

// Walks the active nodes below one cut node, parents first.
void ListActive(const Tree& tree, const std::vector<uint8_t>& active, uint32_t top,
                ActiveNodes& nodes) {
  std::vector<uint32_t> stack{top};
  while (!stack.empty()) {
    const uint32_t node = stack.back();
    stack.pop_back();
    std::vector<uint32_t> children;
    tree.ForEachChild(node, [&](uint32_t child) {
      if (tree.is_cluster(node) || active[child] != 0) children.push_back(child);
    });
    nodes.own.push_back(node);
    nodes.is_leaf.push_back(children.empty() ? 1 : 0);
    if (children.empty()) nodes.leaves.push_back(node);
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
}

// An element that is an end of a link is there, with its sibling and all above.
void Activate(const Tree& tree, uint32_t node, std::vector<uint8_t>& active) {
  while (!tree.is_cluster(node) && active[node] == 0) {
    active[node] = 1;
    const Node& n = tree.node(node);
    if (n.id.is_surface()) return;
    active[tree.node(n.parent).first_child + ((n.id.path & 1) ^ 1)] = 1;
    node = n.parent;
  }
}

// Directions in which the values of clusters are needed: those asked for, and the same of all
// clusters below.
void NeedBelow(const Tree& tree, std::vector<uint16_t>& directions) {
  for (uint32_t c = 0; c < directions.size(); ++c) {  // parents come first
    const Cluster& cluster = tree.cluster(c);
    for (uint32_t i = 0; i < cluster.child_count; ++i) {
      directions[cluster.first_child + i] |= directions[c];
    }
  }
}

// What the links here need of others, by home: ids of slots, sorted. `ends` gets, for each node,
// whether it is the end of a link.
std::vector<std::vector<NodeId>> ListWanted(const Tree& tree, const Placement& placement,
                                            const LinkSet& links, std::vector<uint8_t>& ends,
                                            std::vector<uint16_t>& directions) {
  const Slots slots(tree);
  const Assignment& assignment = placement.assignment();
  ends.assign(tree.size(), 0);
  std::vector<uint8_t> needed(slots.count(tree), 0);  // of slots
  const auto need = [&](const Link& link) {
    const Slots::Ends e = slots.Of(tree, link);
    needed[e.p] = needed[e.q] = 1;
  };
  for (const Link& link : links.own) {
    ends[link.p] = ends[link.q] = 1;
    need(link);
  }
  for (const Link& link : links.crown) {
    ends[link.p] = ends[link.q] = 1;
    if (placement.HomeOfLink(link.p, link.q) == placement.self()) need(link);
  }
  directions.assign(tree.hierarchy().clusters().size(), 0);
  for (uint32_t slot = 0; slots.is_cluster(slot); ++slot) {
    if (needed[slot] != 0) {
      directions[slots.NodeOf(slot)] |= static_cast<uint16_t>(1U << slots.DirectionOf(slot));
    }
  }
  // A crown cluster's value is pulled from the cut here, so those of the cut below are needed too.
  std::vector<uint16_t> crown(directions.size(), 0);
  for (uint32_t c = 0; c < crown.size(); ++c) {
    if (placement.InCrown(c)) crown[c] = directions[c];
  }
  for (uint32_t c = 0; c < crown.size(); ++c) {
    const Cluster& cluster = tree.cluster(c);
    if (!placement.InCrown(c)) continue;
    for (uint32_t i = 0; i < cluster.child_count; ++i) {
      crown[cluster.first_child + i] |= crown[c];
    }
  }
  std::vector<std::vector<NodeId>> wanted(assignment.worker_count);
  for (uint32_t slot = 0; slot < needed.size(); ++slot) {
    const uint32_t node = slots.NodeOf(slot);
    if (placement.InCrown(node)) continue;
    const bool above = slots.is_cluster(slot) &&
                       placement.cut_node(placement.CutOf(node)) == node &&
                       (crown[node] >> slots.DirectionOf(slot) & 1) != 0;
    const uint32_t home = placement.HomeOf(node);
    if ((needed[slot] != 0 || above) && home != placement.self()) {
      wanted[home].push_back(slots.IdOf(tree, slot));
    }
  }
  for (auto& ids : wanted) std::sort(ids.begin(), ids.end());
  return wanted;
}

}  // namespace

Result<ActiveNodes> Subscribe(Tree& tree, Placement& placement, const LinkSet& links,
                              std::span<const uint32_t> asked, Exchange& exchange) {
  const Slots slots(tree);
  ActiveNodes nodes;
  std::vector<uint8_t> ends;
  std::vector<std::vector<NodeId>> wanted =
      ListWanted(tree, placement, links, ends, nodes.directions);
  for (const uint32_t node : asked) ends[node] = 1;
  const bool sheets = tree.sheets() != nullptr;
  if (sheets) AskBehind(tree, placement, ends, wanted);
  ASSIGN_OR_RETURN(const std::vector<NodeId> exported, exchange.Subscribe(wanted));
  for (const NodeId& id : exported) {
    if (!id.is_cluster() && id.surface < tree.hierarchy().surfaces().size() &&
        id.level() <= kMaxLevel) {
      tree.FindOrMake(id);
      placement.Extend(tree);
    }
    const uint32_t slot = slots.Find(tree, id);
    if (slot == kNoNode) {
      return Error(StatusCode::kInternal, "another worker wants node {}:{}", id.surface, id.path);
    }
    const uint32_t node = slots.NodeOf(slot);
    if (!placement.IsMine(node)) {
      return Error(StatusCode::kInternal, "node {}:{} is wanted from the wrong worker", id.surface,
                   id.path);
    }
    nodes.exported.push_back(slot);
    ends.resize(tree.size(), 0);
    ends[node] = 1;
    if (slots.is_cluster(slot)) {
      nodes.directions[node] |= static_cast<uint16_t>(1U << slots.DirectionOf(slot));
    }
  }
  NeedBelow(tree, nodes.directions);
  for (const auto& ids : wanted) {
    for (const NodeId& id : ids) nodes.proxies.push_back(slots.Find(tree, id));
  }
  std::vector<uint8_t> active(tree.size(), 0);
  for (uint32_t node = 0; node < ends.size(); ++node) {
    if (ends[node] != 0) Activate(tree, node, active);
  }
  // The cut's own nodes exist whatever the links say.
  for (uint32_t c = 0; c < placement.cut_size(); ++c) Activate(tree, placement.cut_node(c), active);
  for (uint32_t c = 0; c < placement.cut_size(); ++c) {
    if (placement.assignment().home[c] == placement.self())
      ListActive(tree, active, placement.cut_node(c), nodes);
  }
  if (sheets) {
    RETURN_IF_ERROR(SubscribeBehind(tree, placement, std::move(wanted), exchange, nodes));
  }
  return nodes;
}

std::vector<uint32_t> OwnLeaves(const Tree& tree, const Placement& placement) {
  std::vector<uint32_t> leaves;
  for (uint32_t node = 0; node < tree.size(); ++node) {
    const bool leaf = !tree.is_cluster(node) && tree.node(node).first_child == kNoNode;
    if (leaf && placement.IsMine(node)) leaves.push_back(node);
  }
  return leaves;
}

}  // namespace isolux
