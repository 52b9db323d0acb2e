#include "common/scene/solve_options.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace isolux {
namespace {

TEST(SolveOptions, DefaultsAreValid) { EXPECT_TRUE(SolveOptions().Validate().ok()); }

TEST(SolveOptions, RefusesWhatMakesNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](auto change, const char* word) {
    SolveOptions options;
    change(options);
    const Status status = options.Validate();
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_NE(status.message().find(word), std::string::npos) << status.message();
  };
  refused([](auto& o) { o.accuracy = 0; }, "accuracy");
  refused([](auto& o) { o.accuracy = 1.5; }, "accuracy");
  refused([&](auto& o) { o.accuracy = nan; }, "accuracy");
  refused([](auto& o) { o.max_seconds = -1; }, "max_seconds");
  refused([&](auto& o) { o.max_seconds = nan; }, "max_seconds");
  refused([](auto& o) { o.max_rounds = 0; }, "max_rounds");
  refused([](auto& o) { o.cut_size = 0; }, "cut_size");
  refused([](auto& o) { o.forced_splits = 1'000'000; }, "forced_splits");
  refused([](auto& o) { o.balance_threshold = 0.9; }, "balance_threshold");
  refused([](auto& o) { o.epsilons = {1, 2}; }, "epsilon");
  refused([](auto& o) { o.epsilons = {1, 0}; }, "epsilon");
  refused([&](auto& o) { o.epsilons = {nan}; }, "epsilon");
  refused([](auto& o) { o.epsilons.assign(1000, 1.0); }, "epsilons");
  refused([](auto& o) { o.effects = "+ghosts"; }, "ghosts");
}

TEST(SolveOptions, AcceptsFallingEpsilons) {
  SolveOptions options;
  options.epsilons = {4, 1, 0.25, 0.25};
  EXPECT_TRUE(options.Validate().ok());
}

TEST(SolveOptions, ParsesNames) {
  EXPECT_EQ(ParseDistribution("octree"), Distribution::kOctree);
  EXPECT_EQ(ParseDistribution("random"), Distribution::kRandom);
  EXPECT_EQ(ParseDistribution("input"), Distribution::kInput);
  EXPECT_EQ(ParseDistribution("balanced"), Distribution::kBalanced);
  EXPECT_EQ(ParseBalanceStrategy("none"), BalanceStrategy::kNone);
  EXPECT_EQ(ParseBalanceStrategy("rotate"), BalanceStrategy::kRotate);
  EXPECT_EQ(ParseBalanceStrategy("greedy-refine"), BalanceStrategy::kGreedyRefine);
  EXPECT_NE(ParseDistribution("tree").error().message().find("octree"), std::string::npos);
  EXPECT_NE(ParseBalanceStrategy("greedy").error().message().find("greedy-refine"),
            std::string::npos);
}

TEST(SolveOptions, NamesSolversAsItParsesThem) {
  for (const char* name : {"cg", "jacobi", "gauss-seidel", "chebyshev", "southwell"}) {
    const auto method = ParseSolverMethod(name);
    ASSERT_TRUE(method.has_value()) << name;
    EXPECT_STREQ(ToText(*method), name);
  }
  EXPECT_EQ(ParseSolverMethod("cg"), SolveOptions().solver);
  EXPECT_NE(ParseSolverMethod("sor").error().message().find("southwell"), std::string::npos);
}

TEST(SolveOptions, EveryEndHasItsOwnText) {
  std::set<std::string> texts;
  for (int reason = 0; reason <= static_cast<int>(EndReason::kFinished); ++reason) {
    texts.insert(ToText(static_cast<EndReason>(reason)));
  }
  EXPECT_EQ(texts.size(), 7U);
  EXPECT_EQ(texts.count("unknown"), 0U);
}

}  // namespace
}  // namespace isolux
