#include "client/report/forecasts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace isolux {
namespace {

using nlohmann::json;

// Rounds that follow power laws: ε falls by 4, error ~ ε^½, links ~ ε^-¾.
json Rounds(int count) {
  json rounds = json::array();
  double seconds = 0;
  for (int k = 1; k <= count; ++k) {
    const double epsilon = std::pow(0.25, k);
    const double links = 1000 * std::pow(epsilon, -0.75);
    seconds += 1e-5 * links;
    rounds.push_back({{"round", k},
                      {"epsilon", epsilon},
                      {"error", 0.4 * std::sqrt(epsilon)},
                      {"links", std::round(links)},
                      {"elements", std::round(links / 10)},
                      {"memory_bytes", std::round(links * 24)},
                      {"seconds", seconds},
                      {"refine_s", 1e-5 * links}});
  }
  return rounds;
}

TEST(ReportForecasts, AreMadeWhileTheAccuracyIsNotReached) {
  // Errors 20, 10, 5, 2.5, 1.25 %.
  const json forecasts = MakeForecasts(Rounds(5), 0.026);
  ASSERT_EQ(forecasts.size(), 3u);
  double last = 0;
  for (size_t i = 0; i < forecasts.size(); ++i) {
    EXPECT_EQ(forecasts[i]["round"], i + 1);
    for (const char* key : {"seconds", "links", "elements", "memory_bytes"}) {
      const json& range = forecasts[i][key];
      EXPECT_LE(range["low"].get<double>(), range["likely"].get<double>()) << key;
      EXPECT_LE(range["likely"].get<double>(), range["high"].get<double>()) << key;
    }
    last = forecasts[i]["links"]["likely"].get<double>();
  }
  // The last comes close: the accuracy is reached with 1000 · 4^(4 · ¾) = 64,000 links, aimed at a
  // little below it.
  EXPECT_GT(last, 40'000);
  EXPECT_LT(last, 130'000);
}

TEST(ReportForecasts, EndWhereRoundsLackWhatTheyNeed) {
  EXPECT_EQ(MakeForecasts(json::array(), 0.02), json::array());
  json rounds = Rounds(4);
  rounds[2].erase("links");
  EXPECT_EQ(MakeForecasts(rounds, 0.02).size(), 2u);
  for (const json& odd : {json("x"), json(-1), json(1e300), json(), json::array({1})}) {
    rounds = Rounds(3);
    rounds[1]["epsilon"] = odd;
    rounds[2]["seconds"] = odd;
    rounds[0]["memory_bytes"] = odd;
    EXPECT_TRUE(MakeForecasts(rounds, 0.02).is_array()) << odd.dump();
  }
}

}  // namespace
}  // namespace isolux
