// Who should have which node of the cut in the next round. Pure functions: loads in, an assignment
// out; the strategies differ in what they move, never in the answer of the solve.
//
// Load of a node: the cost of the blocks counted for it, in any unit.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/solve_options.h"

namespace isolux {

// What is known of each node of the cut after a round, in the order of the cut.
struct CutLoads {
  std::vector<double> cost;  // measured, ns
  std::vector<uint64_t> links, elements;
};

// Ways to predict the load of the next round; all but kMeasured are for comparison.
//   measured  cost of the last round × growth of the node's links from the round before to the last
//   elements  elements below the node
//   links     links counted for the node
//   bound     Şireli's bound: with P(a) the nodes that binary subdivision down to the smallest leaf
//             makes of area a, P(a_i) Σ_j P(a_j) b_j, where b_j is node j's share of the radiosity
enum class LoadEstimator { kMeasured, kElements, kLinks, kBound };

// `links_before`: links of nodes of the cut in the round before, where known.
std::vector<double> PredictLoads(LoadEstimator estimator, const Assignment& assignment,
                                 const CutLoads& loads,
                                 const std::map<NodeId, uint64_t>& links_before,
                                 const Hierarchy& hierarchy, const Snapshot& snapshot);

// Largest over mean of the load of the workers that may have nodes; 1 where there is no load.
double MaxOverMean(std::span<const uint32_t> home, std::span<const double> load,
                   const std::vector<bool>& available);

struct BalanceInput {
  Assignment assignment;
  std::vector<double> load;     // predicted, of each node of the cut
  std::vector<uint64_t> links;  // what moving the node would move
  std::vector<bool> available;  // workers that may get nodes; the others lose theirs
  BalanceStrategy strategy = BalanceStrategy::kGreedyRefine;
  double threshold = 1.15;     // max/mean above which nodes are moved
  uint32_t forced_splits = 0;  // heaviest nodes to split whatever their load
  uint32_t most_nodes = 1024;  // of the cut, when splitting for balance
};

struct BalancePlan {
  Assignment assignment;
  double before = 1, after = 1;   // max/mean of the predicted load
  uint32_t moved = 0, split = 0;  // nodes
};

// How a node of the cut splits: children and the share of its load each takes; empty where it
// cannot.
struct CutChild {
  NodeId id;
  double share = 0;
};
using SplitFunction = std::function<std::vector<CutChild>(const NodeId&)>;

// Splits by the tree, shares by leaves.
SplitFunction MakeSplitFunction(const Hierarchy& hierarchy, const Snapshot& snapshot);

// At least one worker is available.
BalancePlan Balance(const BalanceInput& input, const SplitFunction& split);

}  // namespace isolux
