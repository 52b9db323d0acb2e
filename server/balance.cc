#include "server/balance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/partition.h"

namespace isolux {
namespace {

constexpr double kMostGrowth = 8, kLeastGrowth = 0.5;  // of a node's links from round to round
constexpr double kWorthMoving = 0.01;  // of the mean load: smaller gains do not pay for a message

struct Piece {
  NodeId id;
  uint32_t home = 0;
  double load = 0;
  double links = 0;
  bool whole = false;  // known to have no children
  bool moved = false;
};

class Planner {
 public:
  Planner(const BalanceInput& input, const SplitFunction& split)
      : input_(input), split_(split), load_(input.assignment.worker_count, 0.0) {
    for (size_t i = 0; i < input.assignment.cut.size(); ++i) {
      const uint32_t home = input.assignment.home[i];
      pieces_.push_back(
          {input.assignment.cut[i], home, input.load[i], static_cast<double>(input.links[i])});
      load_[home] += input.load[i];
    }
    for (size_t w = 0; w < load_.size(); ++w) workers_ += input.available[w] ? 1 : 0;
  }

  void ForceSplits() {
    std::vector<size_t> order(pieces_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return pieces_[a].load > pieces_[b].load; });
    uint32_t left = input_.forced_splits;
    for (size_t i = 0; i < order.size() && left > 0; ++i) left -= Split(order[i]) ? 1 : 0;
  }

  void Rotate() {
    const auto count = static_cast<uint32_t>(load_.size());
    for (Piece& piece : pieces_) {
      uint32_t next = (piece.home + 1) % count;
      while (!input_.available[next]) next = (next + 1) % count;
      Move(piece, next);
    }
  }

  // Nodes of workers that leave, heaviest first, each to the lightest worker.
  void Evacuate() {
    std::vector<size_t> order;
    for (size_t i = 0; i < pieces_.size(); ++i) {
      if (!input_.available[pieces_[i].home]) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return pieces_[a].load > pieces_[b].load; });
    for (const size_t i : order) Move(pieces_[i], Lightest());
  }

  void Refine() {
    if (workers_ < 2 || Mean() <= 0 || load_[Heaviest()] <= input_.threshold * Mean()) return;
    SplitLargePieces();
    // Every step moves or splits one node; far fewer steps than this are ever needed.
    for (size_t step = 0; step < 4 * pieces_.size() + 64; ++step) {
      const uint32_t from = Heaviest(), to = Lightest();
      if (load_[from] <= (1 + kWorthMoving) * Mean()) return;
      if (Piece* best = BestMove(from, to)) {
        Move(*best, to);
      } else if (!SplitHeaviestOf(from)) {
        return;
      }
    }
  }

  BalancePlan Finish() const {
    std::vector<Piece> pieces = pieces_;
    std::sort(pieces.begin(), pieces.end(),
              [](const Piece& a, const Piece& b) { return a.id < b.id; });
    BalancePlan plan;
    plan.assignment.worker_count = input_.assignment.worker_count;
    std::vector<double> load;
    for (const Piece& piece : pieces) {
      plan.assignment.cut.push_back(piece.id);
      plan.assignment.home.push_back(piece.home);
      load.push_back(piece.load);
      plan.moved += piece.moved ? 1 : 0;
    }
    plan.before = MaxOverMean(input_.assignment.home, input_.load, input_.available);
    plan.after = MaxOverMean(plan.assignment.home, load, input_.available);
    plan.split = splits_;
    return plan;
  }

 private:
  double Mean() const { return std::accumulate(load_.begin(), load_.end(), 0.0) / workers_; }

  uint32_t Lightest() const {
    uint32_t best = 0;
    while (!input_.available[best]) ++best;
    for (uint32_t w = best; w < load_.size(); ++w) {
      if (input_.available[w] && load_[w] < load_[best]) best = w;
    }
    return best;
  }
  uint32_t Heaviest() const {
    return static_cast<uint32_t>(std::max_element(load_.begin(), load_.end()) - load_.begin());
  }

  void Move(Piece& piece, uint32_t to) {
    if (to == piece.home) return;
    load_[piece.home] -= piece.load;
    load_[to] += piece.load;
    piece.home = to;
    piece.moved = true;
  }

  // Replaces a piece by its children, at the same home.
  bool Split(size_t index) {
    if (pieces_[index].whole) return false;
    const std::vector<CutChild> children = split_(pieces_[index].id);
    if (children.empty()) {
      pieces_[index].whole = true;
      return false;
    }
    const Piece parent = pieces_[index];
    for (size_t i = 0; i < children.size(); ++i) {
      Piece child = parent;
      child.id = children[i].id;
      child.load = parent.load * children[i].share;
      child.links = parent.links * children[i].share;
      if (i == 0) {
        pieces_[index] = child;
      } else {
        pieces_.push_back(child);
      }
    }
    ++splits_;
    return true;
  }

  bool SplitHeaviestOf(uint32_t worker) {
    while (pieces_.size() < input_.most_nodes) {
      size_t heaviest = pieces_.size();
      for (size_t i = 0; i < pieces_.size(); ++i) {
        if (pieces_[i].home != worker || pieces_[i].whole) continue;
        if (heaviest == pieces_.size() || pieces_[i].load > pieces_[heaviest].load) heaviest = i;
      }
      if (heaviest == pieces_.size() || pieces_[heaviest].load < kWorthMoving * Mean())
        return false;
      if (Split(heaviest)) return true;
    }
    return false;
  }

  // So that every worker can have several pieces, none is to be more than its share of that.
  void SplitLargePieces() {
    const double large = Mean() / kCutNodesPerWorker;
    for (size_t i = 0; i < pieces_.size() && pieces_.size() < input_.most_nodes;) {
      if (pieces_[i].load <= large || !Split(i)) ++i;
    }
  }

  // The piece whose move lowers the larger of the two loads most for the links it takes along.
  Piece* BestMove(uint32_t from, uint32_t to) {
    const double mean_links =
        std::accumulate(pieces_.begin(), pieces_.end(), 0.0,
                        [](double sum, const Piece& piece) { return sum + piece.links; }) /
        static_cast<double>(pieces_.size());
    Piece* best = nullptr;
    double best_score = 0;
    for (Piece& piece : pieces_) {
      if (piece.home != from) continue;
      const double gain = load_[from] - std::max(load_[from] - piece.load, load_[to] + piece.load);
      if (gain < kWorthMoving * Mean()) continue;
      const double score = gain / (piece.links + mean_links + 1);
      if (score > best_score) {
        best = &piece;
        best_score = score;
      }
    }
    return best;
  }

  const BalanceInput& input_;
  const SplitFunction& split_;
  std::vector<Piece> pieces_;
  std::vector<double> load_;  // of each worker
  double workers_ = 0;        // available
  uint32_t splits_ = 0;
};

// Nodes of the binary tree that divides `area` until its leaves are no larger than `smallest`.
double NodesOfSubdivision(double area, double smallest) {
  double nodes = 1;
  for (int level = 0; area > smallest && level < kMaxLevel; ++level, area /= 2)
    nodes = 2 * nodes + 1;
  return nodes;
}

std::vector<double> BoundLoads(const Assignment& assignment, const Hierarchy& hierarchy,
                               const Snapshot& snapshot) {
  double smallest = hierarchy.clusters()[0].area_m2;
  std::vector<double> radiosity_w(hierarchy.surfaces().size(), 0.0);  // power leaving a surface
  for (const LeafRecord& leaf : snapshot.leaves) {
    const Surface& surface = hierarchy.surfaces()[leaf.id.surface];
    const double area = std::ldexp(hierarchy.surface_area_m2(leaf.id.surface), -leaf.id.level());
    smallest = std::min(smallest, area);
    for (int c = 0; c < 3; ++c) {
      radiosity_w[leaf.id.surface] +=
          area * (surface.exitance[c] + surface.reflectance[c] * leaf.irradiance[c]);
    }
  }
  const auto power_of = [&](const NodeId& node) {
    if (!node.is_cluster()) return std::ldexp(radiosity_w[node.surface], -node.level());
    const Cluster& cluster = hierarchy.clusters()[node.path];
    double power = 0;
    for (uint32_t i = 0; i < cluster.surface_count; ++i) {
      power += radiosity_w[hierarchy.surface_order()[cluster.first_surface + i]];
    }
    return power;
  };
  std::vector<double> nodes, power;
  for (const NodeId& id : assignment.cut) {
    nodes.push_back(NodesOfSubdivision(AreaOf(hierarchy, id), smallest));
    power.push_back(power_of(id));
  }
  const double total = std::max(std::accumulate(power.begin(), power.end(), 0.0), 1e-300);
  double partners = 0;
  for (size_t j = 0; j < nodes.size(); ++j) partners += nodes[j] * power[j] / total;
  for (double& n : nodes) n *= partners;
  return nodes;
}

}  // namespace

std::vector<double> PredictLoads(LoadEstimator estimator, const Assignment& assignment,
                                 const CutLoads& loads,
                                 const std::map<NodeId, uint64_t>& links_before,
                                 const Hierarchy& hierarchy, const Snapshot& snapshot) {
  switch (estimator) {
    case LoadEstimator::kElements:
      return {loads.elements.begin(), loads.elements.end()};
    case LoadEstimator::kLinks:
      return {loads.links.begin(), loads.links.end()};
    case LoadEstimator::kBound:
      return BoundLoads(assignment, hierarchy, snapshot);
    case LoadEstimator::kMeasured:
      break;
  }
  std::vector<double> predicted = loads.cost;
  for (size_t i = 0; i < predicted.size(); ++i) {
    const auto before = links_before.find(assignment.cut[i]);
    if (before == links_before.end()) continue;
    const double growth =
        (static_cast<double>(loads.links[i]) + 1) / (static_cast<double>(before->second) + 1);
    predicted[i] *= std::clamp(growth, kLeastGrowth, kMostGrowth);
  }
  return predicted;
}

double MaxOverMean(std::span<const uint32_t> home, std::span<const double> load,
                   const std::vector<bool>& available) {
  std::vector<double> of_worker(available.size(), 0.0);
  double total = 0;
  for (size_t i = 0; i < home.size(); ++i) {
    of_worker[home[i]] += load[i];
    total += load[i];
  }
  const auto workers = static_cast<double>(std::count(available.begin(), available.end(), true));
  if (!(total > 0) || workers == 0) return 1;
  return *std::max_element(of_worker.begin(), of_worker.end()) * workers / total;
}

SplitFunction MakeSplitFunction(const Hierarchy& hierarchy, const Snapshot& snapshot) {
  return [&hierarchy, &snapshot](const NodeId& node) {
    std::vector<CutChild> children;
    double total = 0;
    for (const NodeId& child : ChildrenOf(hierarchy, &snapshot, node)) {
      const auto leaves = static_cast<double>(CountLeaves(hierarchy, snapshot, child));
      children.push_back({child, leaves});
      total += leaves;
    }
    for (CutChild& child : children) child.share /= std::max(total, 1.0);
    return children;
  };
}

BalancePlan Balance(const BalanceInput& input, const SplitFunction& split) {
  Planner planner(input, split);
  planner.ForceSplits();
  if (input.strategy == BalanceStrategy::kRotate) planner.Rotate();
  planner.Evacuate();
  if (input.strategy == BalanceStrategy::kGreedyRefine) planner.Refine();
  return planner.Finish();
}

}  // namespace isolux
