#include "common/scene/doubts.h"

#include <gtest/gtest.h>

namespace isolux {
namespace {

SolveSummary OneRound(double estimate) {
  SolveSummary summary;
  summary.rounds.emplace_back();
  summary.rounds.back().error_estimate = estimate;
  return summary;
}

TEST(DoubtsTest, NamesWhatRulesTheEstimateTheLargestFirst) {
  SolveSummary summary = OneRound(0.1);
  RoundSummary& last = summary.rounds.back();
  last.error_visibility = 0.06;
  last.error_unseen = 0.08;
  last.unseen_polygon = 42;
  last.error_spread = 0.04;
  const auto doubts = DoubtsOf(summary);
  ASSERT_EQ(doubts.size(), 2u);
  EXPECT_TRUE(doubts[0].starts_with("8 %: light that links missed")) << doubts[0];
  EXPECT_NE(doubts[0].find("polygon 42"), std::string::npos);
  EXPECT_TRUE(doubts[1].starts_with("6 %: visibility")) << doubts[1];
}

TEST(DoubtsTest, NothingRulesEvenParts) {
  SolveSummary summary = OneRound(0.1);
  summary.rounds.back().error_spread = summary.rounds.back().error_coupling = 0.05;
  EXPECT_TRUE(DoubtsOf(summary).empty());
  EXPECT_TRUE(DoubtsOf({}).empty());
  EXPECT_TRUE(DoubtsOf(OneRound(0)).empty());
}

TEST(DoubtsTest, SaysWhereRowsDoNotAddUp) {
  SolveSummary summary = OneRound(0.02);
  summary.rounds.back().leak_area = 0.25;
  const auto doubts = DoubtsOf(summary);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_TRUE(doubts[0].starts_with("25 % of the area")) << doubts[0];
}

}  // namespace
}  // namespace isolux
