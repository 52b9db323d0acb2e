#include "server/link_budget.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

constexpr double kUsualLinksPerSplit = 2;
constexpr double kFewest = 0.25, kMost = 16;  // links per split that are believed
// Relative uncertainty of a predicted growth: where no round has measured κ, where one has, and
// where two have, of which it is the difference.
constexpr double kBlind = 1.0, kMeasuredOnce = 0.4, kLeastUncertain = 0.25;
constexpr double kAimAtLimit = 0.97;   // of the limit, likely
constexpr double kNeverAbove = 1.0;    // of the limit, with the uncertainty added
constexpr double kWorthARound = 0.01;  // of the limit: a step that has used less is the last
constexpr double kLimited = 0.7;       // steps of ε above this were cut short by a budget
constexpr double kRise = 4;            // ε may rise so much: old links can be worse than they were

// Sum over the links above ε of r^q, and the number of links at or below it. Within a bin errors
// are spread evenly in their logarithm.
struct Above {
  double growth = 0, kept = 0, divided = 0;
};
Above Split(const ErrorHistogram& histogram, double epsilon, double power) {
  constexpr double kWidth = 1.0 / ErrorHistogram::kPerOctave;  // octaves
  const double at = std::log2(epsilon);
  Above above;
  for (size_t bin = 0; bin < histogram.count.size(); ++bin) {
    if (histogram.count[bin] == 0) continue;
    const auto count = static_cast<double>(histogram.count[bin]);
    const double low = ErrorHistogram::kLowest + static_cast<double>(bin) * kWidth - at;
    const double share = std::clamp((low + kWidth) / kWidth, 0.0, 1.0);
    const double centre = std::max(low, 0.0) + 0.5 * share * kWidth;
    above.kept += (1 - share) * count;
    above.divided += share * count;
    above.growth += share * count * std::exp2(power * centre);
  }
  return above;
}

double LinksPerSplit(const RoundSummary& round) {
  return round.links_per_split > 0 ? std::clamp(round.links_per_split, kFewest, kMost)
                                   : kUsualLinksPerSplit;
}

double Uncertainty(std::span<const RoundSummary> rounds) {
  if (!(rounds.back().links_per_split > 0)) return kBlind;
  if (rounds.size() < 2 || !(rounds[rounds.size() - 2].links_per_split > 0)) return kMeasuredOnce;
  const double change = LinksPerSplit(rounds.back()) / LinksPerSplit(rounds[rounds.size() - 2]);
  return std::clamp(std::abs(std::log(change)), kLeastUncertain, kBlind);
}

}  // namespace

double PredictLinks(const ErrorHistogram& histogram, double epsilon, double links_per_split,
                    double power) {
  const Above above = Split(histogram, epsilon, power);
  return above.kept + links_per_split * above.growth;
}

double MeasureLinksPerSplit(const ErrorHistogram& before, double epsilon, uint64_t links,
                            double power) {
  const Above above = Split(before, epsilon, power);
  if (!(above.divided >= 1)) return 0;
  return std::max(0.0, static_cast<double>(links) - above.kept) / above.growth;
}

std::optional<double> StepWithin(const Budget& budget, const ErrorHistogram& histogram,
                                 std::span<const RoundSummary> rounds, double wanted,
                                 double power) {
  const RoundSummary& last = rounds.back();
  if (budget.used >= kBudgetUsed * budget.limit) return std::nullopt;
  const double uncertain = Uncertainty(rounds);
  const auto fits = [&](double epsilon) {
    const double links = PredictLinks(histogram, epsilon, LinksPerSplit(last), power);
    const double more = budget.per_link * std::max(0.0, links - static_cast<double>(last.links));
    return budget.used + more <= kAimAtLimit * budget.limit &&
           budget.used + more * (1 + uncertain) <= kNeverAbove * budget.limit;
  };
  if (fits(wanted)) return wanted;
  if (rounds.size() > 1) {
    const RoundSummary& before = rounds[rounds.size() - 2];
    const double added = static_cast<double>(last.links) - static_cast<double>(before.links);
    if (last.epsilon > kLimited * before.epsilon &&
        added * budget.per_link < kWorthARound * budget.limit) {
      return std::nullopt;
    }
  }
  double low = wanted, high = std::max(wanted, kRise * last.epsilon);
  if (!fits(high)) return std::nullopt;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    (fits(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace isolux
