#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "client/commands/cost.h"

namespace isolux {
namespace {

using nlohmann::json;

json ToJson(const Range& range) {
  return {{"low", range.low}, {"likely", range.likely}, {"high", range.high}};
}

// 1234567 as "1.23 M".
std::string Short(double count) {
  const char* units[] = {"", " k", " M", " G", " T"};
  size_t unit = 0;
  for (; count >= 9999.5 && unit + 1 < std::size(units); ++unit) count /= 1000;
  return count < 10 ? fmt::format("{:.2g}{}", count, units[unit])
                    : fmt::format("{:.0f}{}", count, units[unit]);
}

std::string Spread(const Range& range) {
  return fmt::format("{} ({} … {})", Short(range.likely), Short(range.low), Short(range.high));
}

}  // namespace

std::string ToText(const CostTable& table) {
  std::string text = fmt::format(
      "what accuracy should cost with {} {}, from {} rounds down to {:.2g} %; in brackets: what "
      "four of five runs should stay between\n",
      table.workers, table.workers == 1 ? "worker" : "workers", table.rounds, 100 * table.reached);
  text += fmt::format("{:>8}  {:<26} {:<30} {:<30} {}\n", "accuracy", "seconds", "links",
                      "elements", "memory, bytes");
  for (const Forecast& f : table.forecasts) {
    text += fmt::format("{:>6g} %  {:<26} {:<30} {:<30} {}\n", 100 * f.accuracy, Spread(f.seconds),
                        Spread(f.links), Spread(f.elements), Spread(f.memory_bytes));
  }
  return text;
}

json ToJson(const CostTable& table) {
  json rows = json::array();
  for (const Forecast& f : table.forecasts) {
    rows.push_back({{"accuracy", f.accuracy},
                    {"seconds", ToJson(f.seconds)},
                    {"links", ToJson(f.links)},
                    {"elements", ToJson(f.elements)},
                    {"memory_bytes", ToJson(f.memory_bytes)}});
  }
  return {{"workers", table.workers},
          {"rounds", table.rounds},
          {"error_estimate", table.reached},
          {"accuracies", rows}};
}

}  // namespace isolux
