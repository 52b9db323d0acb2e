#include "server/link_budget.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isolux {
namespace {

ErrorHistogram Links(double error_w, uint64_t count) {
  ErrorHistogram histogram;
  for (uint64_t i = 0; i < count; ++i) histogram.Add(error_w);
  return histogram;
}

TEST(LinkBudgetTest, ErrorsFallIntoEighthsOfOctaves) {
  for (int eighth = -300; eighth <= 300; ++eighth) {
    const double edge = std::exp2(eighth / 8.0);
    EXPECT_EQ(EighthOctave(edge * (1 + 1e-12)), eighth);
    EXPECT_EQ(EighthOctave(edge * (1 - 1e-12)), eighth - 1);
  }
  ErrorHistogram histogram;
  for (const double error : {0.0, 1e-300, HUGE_VAL, 1e300, 1.0}) histogram.Add(error);
  EXPECT_EQ(histogram.count.front(), 2u);
  EXPECT_EQ(histogram.count.back(), 2u);
  EXPECT_EQ(histogram.count[8 * 64], 1u);
}

TEST(LinkBudgetTest, LinksWithinTheThresholdStayAndOthersGrowAsTheirErrorIsAboveIt) {
  const ErrorHistogram histogram = Links(1.05, 100);
  EXPECT_NEAR(PredictLinks(histogram, 2, 3, 0.75), 100, 1e-9);
  EXPECT_NEAR(PredictLinks(histogram, 1, 3, 0), 300, 1e-9);
  const double octave_more =
      PredictLinks(histogram, 0.5, 3, 0.75) / PredictLinks(histogram, 1, 3, 0.75);
  EXPECT_NEAR(octave_more, std::exp2(0.75), 1e-9);
  // Through the middle of a bin: a share of its links.
  EXPECT_NEAR(PredictLinks(histogram, std::exp2(0.0625), 2, 0), 150, 1e-9);
}

TEST(LinkBudgetTest, WhatIsMeasuredPredictsWhatWasSeen) {
  ErrorHistogram histogram = Links(0.3, 1000);
  histogram.Add(Links(0.02, 500));
  for (const double epsilon : {0.2, 0.05, 0.01}) {
    const double split = MeasureLinksPerSplit(histogram, epsilon, 7000, 0.8);
    EXPECT_NEAR(PredictLinks(histogram, epsilon, split, 0.8), 7000, 1e-6);
  }
  EXPECT_EQ(MeasureLinksPerSplit(histogram, 1, 1500, 0.8), 0) << "nothing was divided";
}

TEST(LinkBudgetTest, StepsKeepWithinTheBudgetAndEndWhenItIsUsed) {
  const ErrorHistogram histogram = Links(0.9, 1000);
  RoundSummary first, second;
  first.epsilon = 4;
  first.links = 500;
  second.epsilon = 1;
  second.links = 1000;
  second.links_per_split = 2;
  const std::vector<RoundSummary> rounds{first, second};
  const auto step = StepWithin({1000, 1800, 1}, histogram, rounds, 0.1, 0.75);
  ASSERT_TRUE(step.has_value());
  const double predicted = PredictLinks(histogram, *step, 2, 0.75);
  EXPECT_LE(predicted, 1800);
  EXPECT_GE(predicted, 1000 + 0.5 * 800);
  EXPECT_EQ(StepWithin({1000, 1e9, 1}, histogram, rounds, 0.1, 0.75), 0.1) << "more than enough";
  EXPECT_FALSE(StepWithin({1650, 1800, 1}, histogram, rounds, 0.1, 0.75).has_value());
  // Links that have become worse than they were: ε rises.
  const auto up = StepWithin({1000, 1800, 1}, Links(1.9, 1000), rounds, 0.1, 0.75);
  ASSERT_TRUE(up.has_value());
  EXPECT_GT(*up, 1);
  // A small step that has brought nothing is the last.
  std::vector<RoundSummary> stuck = rounds;
  stuck[0].epsilon = 1.1;
  stuck[0].links = 999;
  EXPECT_FALSE(StepWithin({1000, 1800, 1}, histogram, stuck, 0.1, 0.75).has_value());
}

TEST(LocalErrorsTest, TheQuantileIsThatOfNormalErrorsWhateverTheOrder) {
  // One error all over: 95 % of a normal variable of mean |x| = 0.1 are within 1.96 · 0.1/0.798.
  LocalErrors even;
  for (int i = 0; i < 10; ++i) even.Add({0, 16 + static_cast<uint64_t>(i)}, 0.1, 0.1);
  EXPECT_NEAR(even.Quantile(0.95), 1.96 * 0.1 / 0.798, 0.012);
  // A tenth of the area with ten times the error.
  LocalErrors a, b, both;
  a.Add({1, 1}, 0.02, 0.9);
  b.Add({2, 1}, 0.2, 0.1);
  both.Add({2, 1}, 0.2, 0.1);
  both.Add({1, 1}, 0.02, 0.9);
  a.Add(b);
  EXPECT_EQ(a.area, both.area);
  EXPECT_EQ(a.Quantile(0.95), both.Quantile(0.95));
  EXPECT_GT(a.Quantile(0.95), 0.1);
  EXPECT_LT(a.Quantile(0.95), 0.25);
  EXPECT_EQ(a.worst, 0.2);
  EXPECT_EQ(a.worst_leaf, (NodeId{2, 1}));
  EXPECT_EQ(LocalErrors().Quantile(0.95), 0);
}

}  // namespace
}  // namespace isolux
