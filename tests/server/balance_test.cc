#include "server/balance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/util/random.h"
#include "server/partition.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

// Every element splits in two halves, down to level 8.
std::vector<CutChild> Halves(const NodeId& node) {
  if (node.is_cluster() || node.level() >= 8) return {};
  return {{node.Child(0), 0.5}, {node.Child(1), 0.5}};
}

BalanceInput MakeInput(const std::vector<double>& load, const std::vector<uint32_t>& home,
                       uint32_t workers) {
  BalanceInput input;
  input.assignment.worker_count = workers;
  for (uint32_t i = 0; i < load.size(); ++i) input.assignment.cut.push_back({i, 1});
  input.assignment.home = home;
  input.load = load;
  input.links.assign(load.size(), 100);
  input.available.assign(workers, true);
  return input;
}

TEST(BalanceTest, NoneMovesNothing) {
  BalanceInput input = MakeInput({9, 1, 1}, {0, 1, 2}, 3);
  input.strategy = BalanceStrategy::kNone;
  const BalancePlan plan = Balance(input, Halves);
  EXPECT_EQ(plan.assignment, input.assignment);
  EXPECT_EQ(plan.moved, 0u);
  EXPECT_NEAR(plan.before, 9.0 * 3 / 11, 1e-12);
}

TEST(BalanceTest, RotateMovesEverythingToTheNextWorkerThatStays) {
  BalanceInput input = MakeInput({1, 1, 1, 1}, {0, 1, 2, 0}, 3);
  input.strategy = BalanceStrategy::kRotate;
  BalancePlan plan = Balance(input, Halves);
  EXPECT_EQ(plan.assignment.home, (std::vector<uint32_t>{1, 2, 0, 1}));
  EXPECT_EQ(plan.moved, 4u);
  input.available[1] = false;
  plan = Balance(input, Halves);
  EXPECT_EQ(plan.assignment.home, (std::vector<uint32_t>{2, 2, 0, 2}));
}

TEST(BalanceTest, GreedyRefineLeavesWhatIsBalanced) {
  const BalanceInput input = MakeInput({1, 1.1, 1, 1}, {0, 1, 0, 1}, 2);
  const BalancePlan plan = Balance(input, Halves);
  EXPECT_EQ(plan.assignment, input.assignment);
}

TEST(BalanceTest, GreedyRefineEvensOut) {
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    const auto workers = static_cast<uint32_t>(2 + random.Bits() % 6);
    std::vector<double> load;
    std::vector<uint32_t> home;
    for (int i = 0; i < 64; ++i) {
      load.push_back(std::exp(4 * random.Unit()));
      home.push_back(static_cast<uint32_t>(random.Bits() % workers));
    }
    BalanceInput input = MakeInput(load, home, workers);
    input.threshold = 1.05;
    const BalancePlan plan = Balance(input, Halves);
    EXPECT_LE(plan.after, plan.before) << "seed " << seed;
    EXPECT_LE(plan.after, 1.1) << "seed " << seed << ", " << workers << " workers";
    const std::set<NodeId> nodes(plan.assignment.cut.begin(), plan.assignment.cut.end());
    EXPECT_EQ(nodes.size(), plan.assignment.cut.size());
    EXPECT_TRUE(std::is_sorted(plan.assignment.cut.begin(), plan.assignment.cut.end()));
  }
}

TEST(BalanceTest, ANodeTooHeavyForAnyWorkerIsSplit) {
  const BalanceInput input = MakeInput({100, 1, 1, 1}, {0, 1, 2, 3}, 4);
  const BalancePlan plan = Balance(input, Halves);
  EXPECT_GT(plan.split, 0u);
  EXPECT_LT(plan.after, 1.2);
}

TEST(BalanceTest, WhatCannotBeSplitStays) {
  const BalanceInput input = MakeInput({100, 1}, {0, 1}, 2);
  const BalancePlan plan = Balance(input, [](const NodeId&) { return std::vector<CutChild>{}; });
  EXPECT_EQ(plan.assignment, input.assignment);
}

TEST(BalanceTest, TheCutStaysWithinItsLimit) {
  BalanceInput input = MakeInput({100, 1, 1}, {0, 1, 2}, 3);
  input.most_nodes = 5;
  EXPECT_LE(Balance(input, Halves).assignment.cut.size(), 5u);
}

TEST(BalanceTest, WorkersThatLeaveKeepNothing) {
  for (const BalanceStrategy strategy :
       {BalanceStrategy::kNone, BalanceStrategy::kRotate, BalanceStrategy::kGreedyRefine}) {
    BalanceInput input = MakeInput({5, 4, 3, 2, 1, 6}, {0, 1, 2, 0, 1, 2}, 3);
    input.strategy = strategy;
    input.available[2] = false;
    const BalancePlan plan = Balance(input, Halves);
    for (const uint32_t home : plan.assignment.home) EXPECT_NE(home, 2u);
    EXPECT_LE(plan.after, 1.5);
  }
}

TEST(BalanceTest, ForcedSplitsTakeTheHeaviest) {
  BalanceInput input = MakeInput({1, 7, 3, 5}, {0, 1, 0, 1}, 2);
  input.strategy = BalanceStrategy::kNone;
  input.forced_splits = 2;
  const BalancePlan plan = Balance(input, Halves);
  EXPECT_EQ(plan.split, 2u);
  EXPECT_EQ(plan.assignment.cut,
            (std::vector<NodeId>{{0, 1}, {1, 2}, {1, 3}, {2, 1}, {3, 2}, {3, 3}}));
  EXPECT_EQ(plan.assignment.home, (std::vector<uint32_t>{0, 1, 1, 0, 1, 1}));
}

TEST(BalanceTest, LightLinksTravelFirst) {
  BalanceInput input = MakeInput({2, 2, 2, 2}, {0, 0, 0, 0}, 2);
  input.links = {1000, 10, 1000, 10};
  const BalancePlan plan = Balance(input, [](const NodeId&) { return std::vector<CutChild>{}; });
  EXPECT_EQ(plan.assignment.home, (std::vector<uint32_t>{0, 1, 0, 1}));
}

TEST(BalanceTest, EstimatorsGiveTheirFigures) {
  const Scene scene = testing::CornellBox(false);
  const Hierarchy hierarchy(scene);
  Snapshot snapshot;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    LeafRecord leaf;
    leaf.id = {s, 1};
    leaf.irradiance = {1, 1, 1};
    snapshot.leaves.push_back(leaf);
  }
  const Assignment assignment = Partition(hierarchy, {}, 2);
  CutLoads loads;
  for (size_t i = 0; i < assignment.cut.size(); ++i) {
    loads.cost.push_back(100);
    loads.links.push_back(10 + i);
    loads.elements.push_back(i);
  }
  const std::map<NodeId, uint64_t> before{{assignment.cut[0], 4}, {assignment.cut[1], 1000}};
  const auto predict = [&](LoadEstimator estimator) {
    return PredictLoads(estimator, assignment, loads, before, hierarchy, snapshot);
  };
  EXPECT_EQ(predict(LoadEstimator::kElements)[3], 3.0);
  EXPECT_EQ(predict(LoadEstimator::kLinks)[3], 13.0);
  const auto measured = predict(LoadEstimator::kMeasured);
  EXPECT_NEAR(measured[0], 100 * 11.0 / 5, 1e-9);
  EXPECT_EQ(measured[1], 50.0);  // no node shrinks to nothing
  EXPECT_EQ(measured[2], 100.0);
  // The bound follows the area: a wall beats a side of a block.
  const auto bound = predict(LoadEstimator::kBound);
  for (size_t i = 0; i < assignment.cut.size(); ++i) {
    for (size_t j = 0; j < assignment.cut.size(); ++j) {
      if (AreaOf(hierarchy, assignment.cut[i]) > 4 * AreaOf(hierarchy, assignment.cut[j])) {
        EXPECT_GT(bound[i], bound[j]);
      }
    }
  }
}

}  // namespace
}  // namespace isolux
