#include "worker/radiosity/placement.h"

namespace isolux {

Result<Placement> Placement::Make(const Tree& tree, const Assignment& assignment, uint32_t self) {
  if (assignment.cut.size() != assignment.home.size() || assignment.cut.empty() ||
      self >= assignment.worker_count) {
    return Error(StatusCode::kInvalidArgument, "assignment: {} nodes, {} homes, worker {} of {}",
                 assignment.cut.size(), assignment.home.size(), self, assignment.worker_count);
  }
  Placement placement;
  placement.assignment_ = assignment;
  placement.self_ = self;
  constexpr uint32_t kUnset = kCrown - 1;
  placement.cut_of_.assign(tree.size(), kUnset);
  for (uint32_t c = 0; c < assignment.cut.size(); ++c) {
    const uint32_t node = tree.Find(assignment.cut[c]);
    if (node == kNoNode || assignment.home[c] >= assignment.worker_count) {
      return Error(StatusCode::kInvalidArgument,
                   "assignment: cut node {} does not exist or has no home", c);
    }
    placement.cut_nodes_.push_back(node);
    placement.cut_area_m2_.push_back(tree.area_m2(node));
    placement.cut_of_[node] = c;
    // Everything above is crown.
    for (uint32_t up = tree.node(node).parent; up != kNoNode; up = tree.node(up).parent) {
      if (placement.cut_of_[up] == kCrown) break;
      if (placement.cut_of_[up] != kUnset) {
        return Error(StatusCode::kInvalidArgument, "assignment: cut node {} lies below another", c);
      }
      placement.cut_of_[up] = kCrown;
    }
  }
  // Down from the root: the crown in order, and everything below cut nodes.
  placement.first_cut_.assign(tree.size(), kUnset);
  std::vector<uint32_t> stack{0};
  bool covered = true;
  while (!stack.empty()) {
    const uint32_t node = stack.back();
    stack.pop_back();
    const uint32_t cut = placement.cut_of_[node];
    if (cut == kUnset) covered = false;
    if (cut == kCrown) placement.crown_.push_back(node);
    tree.ForEachChild(node, [&](uint32_t child) {
      if (cut != kCrown) placement.cut_of_[child] = cut;
      stack.push_back(child);
    });
  }
  if (!covered)
    return Error(StatusCode::kInvalidArgument, "assignment: the cut leaves surfaces out");
  for (uint32_t c = placement.cut_size(); c-- > 0;) {
    for (uint32_t up = tree.node(placement.cut_nodes_[c]).parent; up != kNoNode;
         up = tree.node(up).parent) {
      placement.first_cut_[up] = c;
    }
  }
  return placement;
}

void Placement::Extend(const Tree& tree) {
  for (auto node = static_cast<uint32_t>(cut_of_.size()); node < tree.size(); ++node) {
    cut_of_.push_back(cut_of_[tree.node(node).parent]);
  }
}

uint32_t Placement::OwnerCut(uint32_t p, uint32_t q) const {
  if (InCrown(p)) return FirstCut(InCrown(q) ? p : q);
  if (InCrown(q)) return cut_of_[p];
  const uint32_t a = cut_of_[p];
  const uint32_t b = cut_of_[q];
  if (cut_area_m2_[a] != cut_area_m2_[b]) return cut_area_m2_[a] > cut_area_m2_[b] ? a : b;
  return a < b ? a : b;
}

}  // namespace isolux
