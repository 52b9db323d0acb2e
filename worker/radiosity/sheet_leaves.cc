#include "worker/radiosity/sheet_leaves.h"

#include <algorithm>

#include "worker/radiosity/slots.h"

namespace isolux {
namespace {

void SortOnce(std::vector<NodeId>& ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

bool IsOfSheet(const Tree& tree, uint32_t node) {
  return !tree.is_cluster(node) &&
         tree.sheets()->PartnerOf(tree.node(node).id.surface) != TranslucentSheets::kNone;
}

// The same piece on the other side, made where it is not there.
uint32_t MakeBehind(Tree& tree, Placement& placement, uint32_t node) {
  const uint32_t behind = tree.FindOrMake(tree.sheets()->PartnerOf(tree.node(node).id));
  placement.Extend(tree);
  return behind;
}

}  // namespace

void AskBehind(Tree& tree, Placement& placement, std::vector<uint8_t>& ends,
               std::vector<std::vector<NodeId>>& wanted) {
  const auto ask = [&](uint32_t node) {
    if (!IsOfSheet(tree, node)) return;
    const uint32_t behind = MakeBehind(tree, placement, node);
    ends.resize(tree.size(), 0);
    if (placement.InCrown(behind)) return;  // the cut's nodes below it are there
    if (placement.IsMine(behind)) {
      ends[behind] = 1;
    } else {
      wanted[placement.HomeOf(behind)].push_back(tree.node(behind).id);
    }
  };
  const auto count = static_cast<uint32_t>(ends.size());
  for (uint32_t node = 0; node < count; ++node) {
    if (ends[node] != 0) ask(node);
  }
  for (uint32_t c = 0; c < placement.cut_size(); ++c) ask(placement.cut_node(c));
  for (auto& ids : wanted) SortOnce(ids);
}

Status SubscribeBehind(Tree& tree, Placement& placement, std::vector<std::vector<NodeId>> wanted,
                       Exchange& exchange, ActiveNodes& nodes) {
  const Slots slots(tree);
  nodes.behind.assign(nodes.leaves.size(), kNoNode);
  for (size_t i = 0; i < nodes.leaves.size(); ++i) {
    const uint32_t leaf = nodes.leaves[i];
    if (!IsOfSheet(tree, leaf)) continue;
    const uint32_t behind = MakeBehind(tree, placement, leaf);
    nodes.behind[i] = slots.OfElement(behind);
    if (!placement.IsMine(behind)) {
      wanted[placement.HomeOf(behind)].push_back(tree.node(behind).id);
    }
  }
  for (auto& ids : wanted) SortOnce(ids);
  ASSIGN_OR_RETURN(const std::vector<NodeId> exported, exchange.Subscribe(wanted));
  nodes.exported.clear();
  for (const NodeId& id : exported) {
    const uint32_t slot = slots.Find(tree, id);
    if (slot == kNoNode || !placement.IsMine(slots.NodeOf(slot))) {
      return MakeStatus(StatusCode::kInternal, "another worker wants node {}:{}, which is no leaf",
                        id.surface, id.path);
    }
    nodes.exported.push_back(slot);
  }
  nodes.proxies.clear();
  for (const auto& ids : wanted) {
    for (const NodeId& id : ids) nodes.proxies.push_back(slots.Find(tree, id));
  }
  return {};
}

}  // namespace isolux
