#include "client/report/forecasts.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "common/scene/forecast.h"

namespace isolux {
namespace {

using nlohmann::json;

// More rounds than a solve may have; a file that claims them is not worth a forecast of each.
constexpr size_t kMostRounds = 1000;
// Counts above this are not exact as numbers of JSON.
constexpr double kMostCount = 9e15;

double Number(const json& round, const char* key) {
  const auto it = round.find(key);
  if (it == round.end() || !it->is_number()) return 0;
  const double value = it->get<double>();
  return std::isfinite(value) ? value : 0;
}

uint64_t Count(const json& round, const char* key) {
  const double value = Number(round, key);
  return value > 0 && value < kMostCount ? static_cast<uint64_t>(value) : 0;
}

// What forecasts are made from; nothing where an essential figure is missing.
std::optional<RoundSummary> ToSummary(const json& round) {
  RoundSummary row;
  row.round = static_cast<uint32_t>(Count(round, "round"));
  row.epsilon = Number(round, "epsilon");
  row.error_estimate = Number(round, "error");
  row.links = Count(round, "links");
  row.elements = Count(round, "elements");
  row.memory_bytes = Count(round, "memory_bytes");
  row.seconds = Number(round, "seconds");
  row.refine_s = Number(round, "refine_s");
  row.exchange_s = Number(round, "exchange_s");
  row.solve_s = Number(round, "solve_s");
  row.snapshot_s = Number(round, "snapshot_s");
  row.balance_s = Number(round, "balance_s");
  row.sample_s = Number(round, "sample_s");
  row.output_elements = Count(round, "output_elements");
  row.output_points = Count(round, "output_points");
  row.output_rays = Count(round, "output_rays");
  row.output_s = Number(round, "output_s");
  row.links_per_split = Number(round, "links_per_split");
  const bool enough = row.epsilon > 0 && row.error_estimate > 0 && row.links > 0 && row.seconds > 0;
  return enough ? std::optional(row) : std::nullopt;
}

json ToJson(const Range& range) {
  return {{"low", range.low}, {"likely", range.likely}, {"high", range.high}};
}

}  // namespace

json MakeForecasts(const json& rounds, double accuracy) {
  json forecasts = json::array();
  std::vector<RoundSummary> known;
  for (const json& round : rounds) {
    const auto row = ToSummary(round);
    if (!row || known.size() == kMostRounds) break;
    known.push_back(*row);
    if (row->error_estimate <= accuracy) continue;
    const auto forecast = ForecastRun(known, accuracy);
    if (!forecast) continue;
    forecasts.push_back({{"round", row->round},
                         {"seconds", ToJson(forecast->seconds)},
                         {"links", ToJson(forecast->links)},
                         {"elements", ToJson(forecast->elements)},
                         {"memory_bytes", ToJson(forecast->memory_bytes)}});
  }
  return forecasts;
}

}  // namespace isolux
