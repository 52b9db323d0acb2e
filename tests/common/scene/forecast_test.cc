#include "common/scene/forecast.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/util/random.h"

namespace isolux {
namespace {

// A run that follows power laws, each figure off by up to `noise` either way.
std::vector<RoundSummary> MakeRun(double error_power, double link_power, double noise, int count,
                                  uint64_t seed = 1) {
  Random random(seed);
  const auto off = [&] { return std::exp(noise * (2 * random.Unit() - 1)); };
  std::vector<RoundSummary> rounds;
  double seconds = 0.5, epsilon = 1;
  for (int i = 0; i < count; ++i, epsilon /= i % 2 == 0 ? 4 : 12) {
    RoundSummary row;
    row.round = static_cast<uint32_t>(i + 1);
    row.epsilon = epsilon;
    row.error_estimate = 0.3 * std::pow(epsilon, error_power) * off();
    row.links = static_cast<uint64_t>(1000 * std::pow(epsilon, -link_power) * off());
    row.elements = row.links / 5;
    row.memory_bytes = 100 * row.links;
    row.output_elements = 2 * row.elements;
    row.output_s = 1e-4 * static_cast<double>(row.output_elements);
    seconds += 2e-6 * static_cast<double>(row.links);
    row.seconds = seconds;
    rounds.push_back(row);
  }
  return rounds;
}

TEST(ForecastTest, FollowsThePowerLawsOfTheRun) {
  for (const double error_power : {0.25, 0.35, 0.5}) {
    for (const double link_power : {0.6, 0.8, 0.95}) {
      const auto rounds = MakeRun(error_power, link_power, 0, 5);
      const std::span<const RoundSummary> known(rounds.data(), 4);
      const double error = rounds[4].error_estimate;
      const Forecast forecast = *ForecastRun(known, error / kAimAt);
      const auto links = static_cast<double>(rounds[4].links);
      EXPECT_NEAR(std::log(forecast.links.likely / links), 0, std::log(1.25))
          << error_power << " " << link_power;
      EXPECT_LE(forecast.links.low, links);
      EXPECT_GE(forecast.links.high, links);
      const double total_s = rounds[4].seconds + rounds[4].output_s;
      EXPECT_NEAR(std::log(forecast.seconds.likely / total_s), 0, std::log(1.5));
      EXPECT_NEAR(forecast.seconds.likely - rounds[3].seconds, forecast.remaining_seconds.likely,
                  1e-9 * total_s);
      EXPECT_EQ(forecast.rounds, 1u);
    }
  }
}

TEST(ForecastTest, FourOfFiveOutcomesLieWithinTheRange) {
  int within = 0, count = 0;
  for (uint64_t seed = 1; seed <= 400; ++seed) {
    const auto rounds = MakeRun(0.35, 0.75, 0.1, 6, seed);
    const std::span<const RoundSummary> known(rounds.data(), 5);
    // The law at the last threshold, not what noise made of it.
    const double error = 0.3 * std::pow(rounds[5].epsilon, 0.35);
    const double links = 1000 * std::pow(rounds[5].epsilon, -0.75);
    const Forecast forecast = *ForecastRun(known, error / kAimAt);
    within += forecast.links.low <= links && links <= forecast.links.high ? 1 : 0;
    ++count;
  }
  EXPECT_GE(within, count * 3 / 4);
}

TEST(ForecastTest, TheNewestRoundsCountMost) {
  auto rounds = MakeRun(0.35, 0.75, 0, 5);
  auto bent = rounds;
  for (int i = 0; i < 2; ++i) bent[static_cast<size_t>(i)].error_estimate *= 3;
  const double straight_links = ForecastRun(rounds, 0.01)->links.likely;
  const double bent_links = ForecastRun(bent, 0.01)->links.likely;
  EXPECT_NEAR(std::log(bent_links / straight_links), 0, std::log(1.5));
}

TEST(ForecastTest, AnyAccuracyCoarseOrFine) {
  const auto rounds = MakeRun(0.35, 0.75, 0, 5);
  double links = 0, seconds = 0;
  for (const double accuracy : {0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005}) {
    const Forecast forecast = *ForecastRun(rounds, accuracy);
    EXPECT_GT(forecast.links.likely, links);
    EXPECT_GT(forecast.seconds.likely, seconds);
    EXPECT_LE(forecast.seconds.low, forecast.seconds.likely);
    EXPECT_GE(forecast.seconds.high, forecast.seconds.likely);
    links = forecast.links.likely;
    seconds = forecast.seconds.likely;
  }
  // What is reached already costs the gather alone.
  const Forecast done = *ForecastRun(rounds, rounds.back().error_estimate * 1.01);
  EXPECT_EQ(done.rounds, 0u);
  EXPECT_NEAR(done.remaining_seconds.likely, rounds.back().output_s, 0.3 * rounds.back().output_s);
}

TEST(ForecastTest, LittleIsKnownOfOneRoundAndNothingOfNone) {
  EXPECT_FALSE(ForecastRun({}, 0.02).has_value());
  const auto rounds = MakeRun(0.35, 0.75, 0, 3);
  const std::span<const RoundSummary> all(rounds);
  const auto spread = [](const Range& range) { return range.high / range.low; };
  const auto one = ForecastRun(all.first(1), 0.02), three = ForecastRun(all, 0.02);
  ASSERT_TRUE(one && three);
  EXPECT_GT(spread(one->links), 1.5 * spread(three->links));
  // A round that is too coarse to see its own error tells nothing.
  RoundSummary blind;
  blind.epsilon = 1;
  blind.links = 6;
  EXPECT_FALSE(ForecastRun({{blind}}, 0.02).has_value());
}

}  // namespace
}  // namespace isolux
