// Where nodes and links live under an assignment. Work is placed by this and nothing else depends
// on it.
#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/util/status.h"
#include "worker/radiosity/tree.h"

namespace isolux {

class Placement {
 public:
  static constexpr uint32_t kCrown = 0xffffffffu;

  // Fails where the cut is not an antichain of existing nodes that covers every surface.
  static Result<Placement> Make(const Tree& tree, const Assignment& assignment, uint32_t self);

  uint32_t self() const { return self_; }
  const Assignment& assignment() const { return assignment_; }
  uint32_t cut_size() const { return static_cast<uint32_t>(assignment_.cut.size()); }
  uint32_t cut_node(uint32_t cut) const { return cut_nodes_[cut]; }  // tree index
  const std::vector<uint32_t>& crown() const { return crown_; }      // tree indices, parents first

  // Takes in nodes made since.
  void Extend(const Tree& tree);

  // Place in the cut of the cut node at or above `node`; kCrown for nodes above the cut.
  uint32_t CutOf(uint32_t node) const { return cut_of_[node]; }
  bool InCrown(uint32_t node) const { return cut_of_[node] == kCrown; }
  uint32_t HomeOf(uint32_t node) const { return assignment_.home[FirstCut(node)]; }
  bool IsMine(uint32_t node) const { return !InCrown(node) && HomeOf(node) == self_; }

  // The cut node whose home keeps and counts the links between p and q: that of the larger of the
  // two cut nodes; where one end is in the crown, the other's; where both are, the first below p.
  uint32_t OwnerCut(uint32_t p, uint32_t q) const;
  uint32_t HomeOfLink(uint32_t p, uint32_t q) const { return assignment_.home[OwnerCut(p, q)]; }
  // Links with an end in the crown are known to every worker.
  bool IsCrownLink(uint32_t p, uint32_t q) const { return InCrown(p) || InCrown(q); }

 private:
  uint32_t FirstCut(uint32_t node) const {
    return InCrown(node) ? first_cut_[node] : cut_of_[node];
  }

  Assignment assignment_;
  uint32_t self_ = 0;
  std::vector<uint32_t> cut_nodes_;
  std::vector<double> cut_area_m2_;
  std::vector<uint32_t> cut_of_;     // of each node
  std::vector<uint32_t> first_cut_;  // of crown nodes
  std::vector<uint32_t> crown_;
};

}  // namespace isolux
