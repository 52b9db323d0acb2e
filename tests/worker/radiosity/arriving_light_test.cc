#include "worker/radiosity/arriving_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/util/random.h"

namespace isolux {
namespace {

// An element of equal parts, each with form factors to senders of some radiosity.
struct Element {
  std::vector<double> radiosity;
  std::vector<std::vector<double>> factors;  // of each part to each sender

  static Element Draw(uint64_t seed) {
    Random random(seed);
    Element element;
    const int senders = 1 + static_cast<int>(6 * random.Unit());
    for (int k = 0; k < senders; ++k) {
      element.radiosity.push_back(std::exp(12 * random.Unit() - 6));
    }
    const int parts = 2 + static_cast<int>(30 * random.Unit());
    const double often = random.Unit();
    for (int i = 0; i < parts; ++i) {
      double left = 1;
      auto& to = element.factors.emplace_back();
      for (int k = 0; k < senders; ++k) {
        to.push_back(random.Unit() < often ? left * random.Unit() : 0);
        left -= to.back();
      }
    }
    return element;
  }

  // As links would have it.
  ArrivingLight Light() const {
    ArrivingLight light;
    for (size_t k = 0; k < radiosity.size(); ++k) {
      double mean = 0, least = 1, most = 0;
      for (const auto& to : factors) {
        mean += to[k] / static_cast<double>(factors.size());
        least = std::min(least, to[k]);
        most = std::max(most, to[k]);
      }
      light.irradiance += radiosity[k] * mean;
      light.squares += radiosity[k] * radiosity[k] * mean;
      light.range += radiosity[k] * (most - least);
      light.from_absorbers += radiosity[k] * mean;
    }
    return light;
  }

  double Variance() const {
    double sum = 0, squares = 0;
    for (const auto& to : factors) {
      double h = 0;
      for (size_t k = 0; k < radiosity.size(); ++k) h += radiosity[k] * to[k];
      sum += h;
      squares += h * h;
    }
    const auto n = static_cast<double>(factors.size());
    return squares / n - sum / n * sum / n;
  }
};

TEST(ArrivingLight, DeviatesByHalfTheLargestRangeAtMost) {
  double worst = 0;
  for (uint64_t seed = 1; seed <= 10000; ++seed) {
    const Element element = Element::Draw(seed);
    const double half = 0.5 * element.Light().LargestRange();
    ASSERT_LE(element.Variance(), half * half * (1 + 1e-9) + 1e-12) << "seed " << seed;
    if (half > 0) worst = std::max(worst, std::sqrt(element.Variance()) / half);
  }
  std::printf("largest deviation over half of the range: %.3f\n", worst);
  EXPECT_GT(worst, 0.9);
}

TEST(ArrivingLight, OfASenderThatCoversAPartOfAnElement) {
  for (const double covered : {0.1, 0.5, 0.9}) {
    ArrivingLight light;
    light.irradiance = 4 * covered;
    light.squares = 16 * covered;
    light.range = 4;
    light.from_absorbers = 3 * covered;  // the sender reflects a quarter
    EXPECT_DOUBLE_EQ(light.BrightnessOfSenders(), 4);
    EXPECT_NEAR(light.LargestRange(), 8 * std::sqrt(covered * (1 - covered)), 1e-12);
    // Half of ρ (mean H² − (mean H)²) / B, as measured scenes have it, and of that the three
    // quarters that it absorbs.
    const double whole = 0.6 * 16 * covered * (1 - covered) / 4;
    EXPECT_NEAR(light.UnevenReturn(0.6), 0.5 * 0.75 * whole, 1e-12);
  }
}

// A lamp that covers an element with many of its own, each of which lights a part.
TEST(ArrivingLight, OfManySendersThatTogetherLightEvenly) {
  constexpr int kSenders = 16;
  ArrivingLight light;
  for (int k = 0; k < kSenders; ++k) {
    light.irradiance += 10.0 / kSenders;
    light.squares += 100.0 / kSenders;
    light.range += 10;
    light.from_absorbers += 10.0 / kSenders;
  }
  EXPECT_NEAR(light.LargestRange(), 0, 1e-6);
  EXPECT_NEAR(light.UnevenReturn(0.9), 0, 1e-12);
}

TEST(ArrivingLight, NothingOfNothing) {
  const ArrivingLight dark;
  EXPECT_EQ(dark.BrightnessOfSenders(), 0);
  EXPECT_EQ(dark.LargestRange(), 0);
  EXPECT_EQ(dark.UnevenReturn(0.9), 0);
}

}  // namespace
}  // namespace isolux
