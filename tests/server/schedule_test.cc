#include "server/schedule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "common/scene/forecast.h"
#include "server/link_budget.h"
#include "server/output_options.h"

namespace isolux {
namespace {

// A scene as measured: error = 0.05 · (ε/Φ / 1e-2)^0.3, links = 500 · (ε/Φ / 1e-2)^-0.75.
struct Model {
  double emitted_w = 100;
  double error_at_1 = 0.2;
  double links_at_1 = 500;
  double seconds_per_link = 1e-5;
  double seconds_per_element = 2e-4;
  double seconds = 0;

  RoundSummary Run(uint32_t round, double epsilon) {
    RoundSummary row;
    const double relative = epsilon / emitted_w / 1e-2;
    row.round = round;
    row.epsilon = epsilon;
    row.error_estimate = error_at_1 * std::pow(relative, 0.3);
    row.links = static_cast<uint64_t>(links_at_1 * std::pow(relative, -0.75));
    row.elements = row.links / 4;
    row.memory_bytes = row.links * 64;
    row.output_elements = 2 * row.elements;
    row.output_s = seconds_per_element * static_cast<double>(row.output_elements);
    seconds += static_cast<double>(row.links) * seconds_per_link;
    row.seconds = seconds;
    return row;
  }

  // Errors such that a link made into two when ε halves keeps the law: as many below ε as dividing
  // has left there, spread evenly over the four octaves below it.
  ErrorHistogram Histogram(const RoundSummary& row) const {
    ErrorHistogram histogram;
    constexpr int kBins = 4 * ErrorHistogram::kPerOctave;
    for (int i = 0; i < kBins; ++i) {
      const double error = row.epsilon * std::exp2(-(i + 0.5) / ErrorHistogram::kPerOctave);
      for (uint64_t n = 0; n < row.links / kBins; ++n) histogram.Add(error);
    }
    return histogram;
  }
};

struct Course {
  std::vector<RoundSummary> rounds;
  EndReason reason = EndReason::kFinished;
};

Course RunModel(Model model, const SolveOptions& options, uint64_t memory_guard = 0) {
  Course run;
  for (int i = 0; i < 300; ++i) {
    ScheduleInput input;
    input.options = options;
    input.emitted_w = model.emitted_w;
    input.rounds = run.rounds;
    input.memory_limit_bytes = memory_guard;
    input.seconds = model.seconds;
    if (!run.rounds.empty()) input.histogram = model.Histogram(run.rounds.back());
    const ScheduleDecision decision = DecideNext(input);
    if (decision.stop) {
      run.reason = decision.reason;
      return run;
    }
    EXPECT_GT(decision.epsilon, 0);
    EXPECT_GE(decision.accuracy, options.accuracy);
    run.rounds.push_back(model.Run(static_cast<uint32_t>(run.rounds.size() + 1), decision.epsilon));
    if (run.rounds.size() > 1) {
      run.rounds.back().links_per_split =
          MeasureLinksPerSplit(input.histogram, decision.epsilon, run.rounds.back().links, 0.75);
    }
  }
  ADD_FAILURE() << "the schedule never ends";
  return run;
}

TEST(ScheduleTest, ReachesTheAccuracyInFallingSteps) {
  for (const double accuracy : {0.2, 0.1, 0.05, 0.02, 0.01}) {
    SolveOptions options;
    options.accuracy = accuracy;
    const Course run = RunModel({}, options);
    EXPECT_EQ(run.reason, EndReason::kAccuracy) << accuracy;
    EXPECT_GE(run.rounds.size(), 2u);
    EXPECT_LE(run.rounds.size(), 8u) << accuracy;
    EXPECT_LE(run.rounds.back().error_estimate, accuracy);
    EXPECT_GE(run.rounds.back().error_estimate, accuracy / 3) << "far too much work";
    for (size_t i = 1; i < run.rounds.size(); ++i) {
      const double step = run.rounds[i].epsilon / run.rounds[i - 1].epsilon;
      EXPECT_LE(step, kLargestStep);
      EXPECT_GE(step, 1.0 / 16.0001);
    }
  }
}

TEST(ScheduleTest, FollowsAGivenList) {
  SolveOptions options;
  options.epsilons = {5, 1, 0.25};
  options.max_links = 10;  // does not count here
  const Course run = RunModel({}, options);
  ASSERT_EQ(run.rounds.size(), 3u);
  EXPECT_EQ(run.rounds[2].epsilon, 0.25);
  EXPECT_EQ(run.reason, EndReason::kRounds);
}

TEST(ScheduleTest, StopsAtTheMostRounds) {
  SolveOptions options;
  options.accuracy = 1e-4;
  options.max_rounds = 3;
  const Course run = RunModel({}, options);
  EXPECT_EQ(run.rounds.size(), 3u);
  EXPECT_EQ(run.reason, EndReason::kRounds);
}

TEST(ScheduleTest, KeepsWithinALinkBudget) {
  for (const uint64_t budget : {2'000u, 20'000u, 300'000u}) {
    SolveOptions options;
    options.accuracy = 1e-4;
    options.max_links = budget;
    options.max_rounds = 100;
    const Course run = RunModel({}, options);
    EXPECT_EQ(run.reason, EndReason::kLinks);
    EXPECT_LE(run.rounds.back().links, 1.05 * static_cast<double>(budget));
    EXPECT_GE(run.rounds.back().links, 0.9 * static_cast<double>(budget));
    EXPECT_LE(run.rounds.size(), 12u);
  }
}

TEST(ScheduleTest, KeepsWithinMemoryWhoeverSetsTheLimit) {
  SolveOptions options;
  options.accuracy = 1e-4;
  options.max_rounds = 100;
  const Course guarded = RunModel({}, options, uint64_t{64} * 100'000);
  EXPECT_EQ(guarded.reason, EndReason::kMemory);
  EXPECT_LE(guarded.rounds.back().memory_bytes, 1.05 * 64 * 100'000);
  EXPECT_GE(guarded.rounds.back().memory_bytes, 0.9 * 64 * 100'000);
  options.max_memory_bytes = uint64_t{64} * 10'000;
  const Course asked = RunModel({}, options, uint64_t{64} * 100'000);
  EXPECT_EQ(asked.reason, EndReason::kMemory);
  EXPECT_LE(asked.rounds.back().memory_bytes, 1.05 * 64 * 10'000);
  EXPECT_GE(asked.rounds.back().memory_bytes, 0.9 * 64 * 10'000);
}

TEST(ScheduleTest, KeepsWithinTheTime) {
  SolveOptions options;
  options.accuracy = 1e-4;
  options.max_seconds = 20;
  options.max_rounds = 100;
  // Of the gather alone, of the rounds alone, and of both.
  for (const auto& [per_link, per_element] :
       {std::pair{1e-5, 2e-4}, std::pair{1e-4, 0.0}, std::pair{1e-7, 1e-3}}) {
    Model model;
    model.seconds_per_link = per_link;
    model.seconds_per_element = per_element;
    // Small steps near its end are not for want of memory, of which there is enough.
    const Course run = RunModel(model, options, uint64_t{1} << 40);
    EXPECT_EQ(run.reason, EndReason::kSeconds);
    const double rounds_s = run.rounds.back().seconds, gather_s = run.rounds.back().output_s;
    EXPECT_LE(rounds_s + gather_s, 20);
    EXPECT_GE(rounds_s + gather_s, 0.6 * 20);
    // What is left is for rays at points, as many times as many as the gather's time allows.
    ScheduleInput end;
    end.options = options;
    end.rounds = run.rounds;
    end.seconds = rounds_s;
    const double rays = std::pow(PointAccuracyWithin(TimeForGather(end), 0.02) / 0.02, -1.25);
    EXPECT_LE(rounds_s + rays * gather_s, 20);
    if (gather_s > 0.2 * rounds_s) {
      EXPECT_GE(rounds_s + rays * gather_s, 0.85 * 20);
    }
  }
}

TEST(ScheduleTest, SpendsSpareTimeOnPointsUpToALimit) {
  EXPECT_EQ(PointAccuracyWithin(0.5, 0.02), 0.02);  // none is left
  EXPECT_EQ(PointAccuracyWithin(1, 0.02), 0.02);
  EXPECT_NEAR(PointAccuracyWithin(2, 0.02), 0.02 * std::pow(0.5, 0.8), 1e-15);
  EXPECT_NEAR(PointAccuracyWithin(1000, 0.02), 0.02 / 3, 1e-15);
  EXPECT_EQ(PointAccuracyWithin(1, 0.2), 0.2);
  EXPECT_NEAR(PointAccuracyWithin(4, 0.2), kCoarsestOfPoints / 3, 1e-15);
  ScheduleInput input;  // neither a budget nor rounds
  EXPECT_EQ(TimeForGather(input), 1);
  input.options.max_seconds = 10;
  EXPECT_EQ(TimeForGather(input), 1);
  const RoundSummary row = Model{}.Run(1, 1);
  input.rounds = {&row, 1};
  EXPECT_GT(TimeForGather(input), 1);
  input.seconds = 10;  // all is spent
  EXPECT_EQ(TimeForGather(input), 1);
  input.options.max_seconds = 0;
  input.seconds = 0;
  EXPECT_EQ(TimeForGather(input), 1);
}

TEST(ScheduleTest, StopsWherePrecisionEnds) {
  SolveOptions options;
  options.accuracy = 1e-6;
  options.max_rounds = 256;
  Model model;
  model.links_at_1 = 0;  // nothing that could be divided
  const Course run = RunModel(model, options);
  EXPECT_EQ(run.reason, EndReason::kPrecision);
}

// Light that is reflected a thousand times is not looked at a hundred times more closely for it.
TEST(ScheduleTest, StartsFromWhatArrives) {
  ScheduleInput input;
  input.emitted_w = 100;
  const double plain = DecideNext(input).epsilon;
  input.amplification = 5;
  EXPECT_EQ(DecideNext(input).epsilon, plain);
  input.amplification = 1000;
  EXPECT_DOUBLE_EQ(DecideNext(input).epsilon, 100 * plain);
}

TEST(ScheduleTest, StartsAnewWhereHardlyAnyLightArrives) {
  Model model;
  ScheduleInput input;
  input.emitted_w = model.emitted_w;
  input.options.accuracy = 0.5;  // reached by what has seen nothing
  std::vector<RoundSummary> rounds = {model.Run(1, DecideNext(input).epsilon),
                                      model.Run(2, 0.5 * DecideNext(input).epsilon)};
  input.rounds = rounds;
  rounds.back().emitted_w = {20, 20, 20};
  EXPECT_TRUE(DecideNext(input).stop);
  rounds.back().emitted_w = {0.1, 0.1, 0.1};
  const ScheduleDecision anew = DecideNext(input);
  EXPECT_FALSE(anew.stop);
  EXPECT_DOUBLE_EQ(anew.epsilon, 0.02 * 0.3);
  input.options.max_rounds = 2;
  EXPECT_TRUE(DecideNext(input).stop);
}

TEST(ScheduleTest, StopsWhereRowsAloneAreInDoubt) {
  Model model;
  ScheduleInput input;
  input.emitted_w = model.emitted_w;
  input.options.accuracy = 0.02;
  std::vector<RoundSummary> rounds = {model.Run(1, 1), model.Run(2, 0.5)};
  input.rounds = rounds;
  for (RoundSummary& row : rounds) row.error_closure = 0.025;
  rounds[1].error_estimate = 0.03;
  EXPECT_EQ(DecideNext(input).reason, EndReason::kPrecision);
  EXPECT_TRUE(DecideNext(input).stop);
  rounds[0].error_closure = 0.05;  // it still falls
  EXPECT_FALSE(DecideNext(input).stop);
  rounds[0].error_closure = 0.025;
  rounds[1].error_estimate = 0.05;  // links have more to say
  EXPECT_FALSE(DecideNext(input).stop);
}

TEST(ScheduleTest, FinishEndsAfterARoundAtLeast) {
  ScheduleInput input;
  input.emitted_w = 10;
  input.finish = true;
  EXPECT_FALSE(DecideNext(input).stop);
  Model model;
  const std::vector<RoundSummary> rounds{model.Run(1, 0.2)};
  input.rounds = rounds;
  const ScheduleDecision decision = DecideNext(input);
  EXPECT_TRUE(decision.stop);
  EXPECT_EQ(decision.reason, EndReason::kFinished);
}

TEST(ScheduleTest, OneRoundAloneProvesNothing) {
  ScheduleInput input;
  input.emitted_w = 10;
  RoundSummary row;
  row.epsilon = 0.2;
  row.error_estimate = 0;  // too coarse to see anything
  row.links = 6;
  const std::vector<RoundSummary> rounds{row};
  input.rounds = rounds;
  const ScheduleDecision decision = DecideNext(input);
  EXPECT_FALSE(decision.stop);
  EXPECT_LT(decision.epsilon, 0.2);
  EXPECT_GT(decision.epsilon, 0);
}

// Rounds of the model until their links state 5 %, and a gather that finds more.
struct Gathered {
  ScheduleInput input;
  Model model;
  std::vector<RoundSummary> rounds;

  Gathered() {
    input.options.accuracy = 0.05;
    input.emitted_w = model.emitted_w;
    rounds = RunModel(model, input.options).rounds;
    input.rounds = rounds;
  }
  ScheduleDecision Decide() {
    input.rounds = rounds;
    return DecideNext(input);
  }
};

TEST(ScheduleTest, GoesOnAsFarAsTheGatherHasFoundMore) {
  for (const double stated : {0.055, 0.08, 0.5}) {
    Gathered run;
    ASSERT_TRUE(run.Decide().stop);
    const double links = run.rounds.back().error_estimate;
    run.rounds.back().error_unseen = std::sqrt(stated * stated - links * links);
    const ScheduleDecision decision = run.Decide();
    ASSERT_FALSE(decision.stop) << stated;
    // As far as the law of the model has it, and no further than a plain step.
    const double share = 0.9 * 0.05 / stated;
    const double step = std::max(0.25, std::pow(share, 1 / 0.3));
    EXPECT_NEAR(decision.epsilon / run.rounds.back().epsilon, step, 0.1 * step) << stated;
    // Then it is for the gather to say whether that was enough.
    run.rounds.push_back(run.model.Run(9, decision.epsilon));
    EXPECT_TRUE(run.Decide().stop);
    run.rounds.back().error_unseen = 0.02;
    EXPECT_TRUE(run.Decide().stop);
  }
}

TEST(ScheduleTest, EndsWhereTheGatherFindsAsMuchAgain) {
  for (const double then : {0.1, 0.0999, 0.06}) {
    Gathered run;
    run.rounds.back().error_unseen = 0.1;
    run.rounds.push_back(run.model.Run(9, run.Decide().epsilon));
    run.rounds.back().error_unseen = then;
    EXPECT_EQ(run.Decide().stop, then > 0.07) << then;
    EXPECT_EQ(run.Decide().reason, EndReason::kAccuracy);
  }
}

}  // namespace
}  // namespace isolux
