#include "client/commands/factors_text.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace isolux {
namespace {

bool HasBacks(const FactorTable& table) {
  return std::any_of(table.ends.begin(), table.ends.end(),
                     [](const FactorEnd& end) { return end.side == Side::kBack; });
}

const char* ToText(Side side) { return side == Side::kFront ? "front" : "back"; }

// Both directions of every factor, sorted by the end that F is from.
class Directions {
 public:
  explicit Directions(const FactorTable& table) : of_(table.ends.size()) {
    for (const Factor& factor : table.factors) {
      of_[factor.p].emplace_back(factor.q, &factor);
      if (factor.q != factor.p) of_[factor.q].emplace_back(factor.p, &factor);
    }
    for (auto& row : of_) std::sort(row.begin(), row.end());
  }

  template <typename Use>
  void ForEach(const Use& use) const {
    for (uint32_t p = 0; p < of_.size(); ++p) {
      for (const auto& [q, factor] : of_[p]) use(p, q, *factor);
    }
  }

 private:
  std::vector<std::vector<std::pair<uint32_t, const Factor*>>> of_;
};

struct Worst {
  double missing = 0, beyond = 0;
  uint32_t polygon = 0;
};

// The largest |row sum - 1| of the rows that see anything, and the largest excess as integrated.
Worst WorstRow(const FactorTable& table) {
  Worst worst;
  for (const FactorEnd& end : table.ends) {
    worst.beyond = std::max(worst.beyond, end.row_sum_before - 1);
    if (end.row_sum == 0 || std::abs(end.row_sum - 1) <= worst.missing) continue;
    worst.missing = std::abs(end.row_sum - 1);
    worst.polygon = end.polygon;
  }
  return worst;
}

uint64_t PairCount(const FactorTable& table) {
  uint64_t count = 0;
  for (const uint64_t pairs : table.pairs) count += pairs;
  return count;
}

}  // namespace

std::string FactorsAsCsv(const FactorTable& table) {
  const bool sides = HasBacks(table);
  std::string text = sides ? "p,q,F_pq,C_pq_m2,error,side_p,side_q\n" : "p,q,F_pq,C_pq_m2,error\n";
  const auto out = std::back_inserter(text);
  Directions(table).ForEach([&](uint32_t p, uint32_t q, const Factor& factor) {
    const FactorEnd &from = table.ends[p], &to = table.ends[q];
    fmt::format_to(out, "{},{},{:.12g},{:.12g},{:.3g}", from.polygon, to.polygon,
                   factor.coupling_m2 / from.area_m2, factor.coupling_m2,
                   factor.error_m2 / from.area_m2);
    if (sides) fmt::format_to(out, ",{},{}", ToText(from.side), ToText(to.side));
    text += '\n';
  });
  return text;
}

std::string RowsAsCsv(const FactorTable& table) {
  const bool sides = HasBacks(table);
  std::string text = "polygon,area_m2,row_sum,missing,row_sum_before,row_error";
  text += sides ? ",side\n" : "\n";
  const auto out = std::back_inserter(text);
  for (const FactorEnd& end : table.ends) {
    fmt::format_to(out, "{},{:.12g},{:.12g},{:.6g},{:.12g},{:.3g}", end.polygon, end.area_m2,
                   end.row_sum, 1 - end.row_sum, end.row_sum_before, end.row_error);
    if (sides) fmt::format_to(out, ",{}", ToText(end.side));
    text += '\n';
  }
  return text;
}

std::string FactorsAsJson(const FactorTable& table, uint32_t polygons, double tolerance,
                          double seconds) {
  const bool sides = HasBacks(table);
  const Worst worst = WorstRow(table);
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out,
                 "{{\"polygons\":{},\"tolerance\":{:.6g},\"seconds\":{:.4g},\"pairs\":{},"
                 "\"above_tolerance\":{},\"max_row_deviation\":{:.6g},\"rows_lowered\":{},"
                 "\"settled\":{{",
                 polygons, tolerance, seconds, PairCount(table), table.above_tolerance,
                 worst.missing, table.rows_lowered);
  for (int way = 0; way < kWayCount; ++way) {
    fmt::format_to(out, "{}\"{}\":{}", way > 0 ? "," : "", ToText(static_cast<Way>(way)),
                   table.pairs[way]);
  }
  text += "},\"rows\":[";
  const char* comma = "";
  for (const FactorEnd& end : table.ends) {
    fmt::format_to(out,
                   "{}{{\"polygon\":{},\"row_sum\":{:.12g},\"row_sum_before\":{:.12g},"
                   "\"row_error\":{:.3g},\"area_m2\":{:.12g}",
                   comma, end.polygon, end.row_sum, end.row_sum_before, end.row_error, end.area_m2);
    if (sides) fmt::format_to(out, ",\"side\":\"{}\"", ToText(end.side));
    text += '}';
    comma = ",";
  }
  text += "],\"factors\":[";
  comma = "";
  Directions(table).ForEach([&](uint32_t p, uint32_t q, const Factor& factor) {
    const FactorEnd &from = table.ends[p], &to = table.ends[q];
    fmt::format_to(out, "{}[{},{},{:.12g},{:.3g}", comma, from.polygon, to.polygon,
                   factor.coupling_m2 / from.area_m2, factor.error_m2 / from.area_m2);
    if (sides) fmt::format_to(out, ",\"{}\",\"{}\"", ToText(from.side), ToText(to.side));
    text += ']';
    comma = ",";
  });
  text += "]}\n";
  return text;
}

std::string FactorsSummary(const FactorTable& table, double tolerance, double seconds) {
  const auto pairs = static_cast<double>(std::max<uint64_t>(1, PairCount(table)));
  const Worst worst = WorstRow(table);
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{} pairs in {:.3g} s, {:.3g} pairs a second\n", PairCount(table), seconds,
                 pairs / std::max(seconds, 1e-9));
  for (int way = 0; way < kWayCount; ++way) {
    fmt::format_to(out, "  {:5.1f} %  {}\n", 100 * static_cast<double>(table.pairs[way]) / pairs,
                   ToText(static_cast<Way>(way)));
  }
  if (table.above_tolerance > 0) {
    fmt::format_to(out, "{} pairs have a stated error above the tolerance of {:g}\n",
                   table.above_tolerance, tolerance);
  }
  fmt::format_to(out, "largest |row sum - 1|: {:.3g}, polygon {}\n", worst.missing, worst.polygon);
  if (table.rows_lowered > 0) {
    fmt::format_to(out, "{} rows were above 1, by up to {:.2g}, and were lowered to it\n",
                   table.rows_lowered, worst.beyond);
  }
  if (table.rows_beyond > 0) {
    fmt::format_to(
        out,
        "{} of them were above 1 by far more than their errors: do polygons overlap in one "
        "plane, or stand inside each other?\n",
        table.rows_beyond);
  }
  fmt::format_to(out, "reciprocity: exact, one coupling for both directions\n");
  return text;
}

}  // namespace isolux
