#include "common/scene/forecast.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace isolux {
namespace {

// Four of five outcomes of a normal distribution lie within so many deviations.
constexpr double kDeviations = 1.28;
// Weight of a round against the one after it. The first one's estimate counts for little: without a
// solution to look at it cannot know how values vary within a link.
constexpr double kFade = 0.5, kFirstWeight = 0.01;
// Of the rate at which links are made and solved, from round to round.
constexpr double kRateDeviation = 0.25;

// What is known of a law before it is looked at: the slope (over rooms with and without furniture)
// with its deviation, how far it may go, and how far single rounds are off the line.
struct Prior {
  double slope, deviation, least, most, noise;
};
constexpr Prior kError{0.3, 0.1, 0.15, 0.8, 0.08};
constexpr Prior kLinks{-0.69, 0.12, -1.2, -0.3, 0.05};
constexpr Prior kElements{-0.55, 0.12, -1.2, -0.1, 0.08};
constexpr Prior kMemory{-0.7, 0.12, -1.2, -0.1, 0.05};
constexpr Prior kOutput{-0.4, 0.2, -1.2, 0.0, 0.15};
constexpr Prior kGather{-0.6, 0.25, -1.5, 0.1, 0.25};

using Value = std::function<double(const RoundSummary&)>;

PowerLaw Fit(std::span<const RoundSummary> rounds, const Prior& prior, const Value& value) {
  struct Point {
    double x, y, weight;
  };
  std::vector<Point> points;
  double weight = 1, total = 0;
  PowerLaw law;
  for (size_t i = rounds.size(); i-- > 0; weight *= kFade) {
    const double y = value(rounds[i]);
    if (!(y > 0) || !std::isfinite(y) || !(rounds[i].epsilon > 0)) continue;
    const double w = i == 0 && !points.empty() ? kFirstWeight * weight : weight;
    points.push_back({std::log(rounds[i].epsilon), std::log(y), w});
    law.mean_x += w * points.back().x;
    law.mean_y += w * points.back().y;
    total += w;
  }
  law.slope = prior.slope;
  law.slope_variance = prior.deviation * prior.deviation;
  if (points.empty()) return law;
  law.mean_x /= total;
  law.mean_y /= total;
  double xx = 0, xy = 0;
  for (const Point& p : points) {
    xx += p.weight * (p.x - law.mean_x) * (p.x - law.mean_x);
    xy += p.weight * (p.x - law.mean_x) * (p.y - law.mean_y);
  }
  // Twice: the second time with the scatter that the first line leaves.
  double noise2 = prior.noise * prior.noise;
  const double believed = 1 / (prior.deviation * prior.deviation);
  for (int pass = 0; pass < 2; ++pass) {
    const double known = xx / noise2 + believed;
    law.slope = std::clamp((xy / noise2 + prior.slope * believed) / known, prior.least, prior.most);
    law.slope_variance = 1 / known;
    law.mean_variance = noise2 / total;
    double scatter = 0;
    for (const Point& p : points) {
      const double off = p.y - law.mean_y - law.slope * (p.x - law.mean_x);
      scatter += p.weight * off * off / total;
    }
    noise2 = std::max(noise2, scatter);
  }
  return law;
}

double RoundSecondsOf(std::span<const RoundSummary> rounds, size_t i) {
  if (i > 0) return std::max(0.0, rounds[i].seconds - rounds[i - 1].seconds);
  // Before the first one the workers have built the scene.
  const RoundSummary& row = rounds[0];
  const double parts = row.refine_s + row.exchange_s + row.solve_s + row.snapshot_s;
  return parts > 0 ? std::min(parts, row.seconds) : row.seconds;
}

Range Times(const Range& a, double factor) {
  return {a.low * factor, a.likely * factor, a.high * factor};
}

Range Sum(const Range& a, const Range& b) {
  return {a.low + b.low, a.likely + b.likely, a.high + b.high};
}

}  // namespace

double PowerLaw::At(double epsilon) const {
  return std::exp(mean_y + slope * (std::log(epsilon) - mean_x));
}

double PowerLaw::VarianceAt(double epsilon) const {
  const double dx = std::log(epsilon) - mean_x;
  return mean_variance + slope_variance * dx * dx;
}

Range PowerLaw::RangeAt(double epsilon, double more_variance) const {
  const double likely = At(epsilon);
  const double factor = std::exp(kDeviations * std::sqrt(VarianceAt(epsilon) + more_variance));
  return {likely / factor, likely, likely * factor};
}

RunFit::RunFit(std::span<const RoundSummary> rounds) : rounds_(rounds) {
  error_ = Fit(rounds, kError, [](const RoundSummary& r) { return r.error_estimate; });
  links_ = Fit(rounds, kLinks, [](const RoundSummary& r) { return static_cast<double>(r.links); });
  elements_ =
      Fit(rounds, kElements, [](const RoundSummary& r) { return static_cast<double>(r.elements); });
  memory_ = Fit(rounds, kMemory,
                [](const RoundSummary& r) { return static_cast<double>(r.memory_bytes); });
  output_elements_ = Fit(rounds, kOutput, [](const RoundSummary& r) {
    return static_cast<double>(r.output_elements);
  });
  gather_ = Fit(rounds, kGather, [](const RoundSummary& r) { return r.output_s; });
  double seconds = 0, links = 0, weight = 1;
  for (size_t i = rounds.size(); i-- > 0; weight *= kFade) {
    seconds += weight * RoundSecondsOf(rounds, i);
    links += weight * static_cast<double>(rounds[i].links);
  }
  seconds_per_link_ = links > 0 ? seconds / links : 0;
  rate_variance_ = kRateDeviation * kRateDeviation;
}

double RunFit::EpsilonFor(double accuracy, double* variance) const {
  const double dy = std::log(accuracy) - error_.mean_y;
  const double epsilon = std::exp(error_.mean_x + dy / error_.slope);
  if (variance != nullptr) *variance = error_.VarianceAt(epsilon) / (error_.slope * error_.slope);
  return epsilon;
}

Range RunFit::RoundSeconds(double epsilon) const {
  return Times(links_.RangeAt(epsilon, rate_variance_), seconds_per_link_);
}

Range RunFit::GatherSeconds(double epsilon) const {
  const bool known = std::any_of(rounds_.begin(), rounds_.end(),
                                 [](const RoundSummary& r) { return r.output_s > 0; });
  return known ? gather_.RangeAt(epsilon) : Range();
}

// The rounds to come until ε.
Range RunFit::Spend(double epsilon, double variance, uint32_t* rounds) const {
  Range sum;
  double at = rounds_.back().epsilon;
  const double slope2 = links_.slope * links_.slope;
  while (at > epsilon) {
    at = std::max(epsilon, kSmallestStep * at);
    const double more = rate_variance_ + (at == epsilon ? slope2 * variance : 0.0);
    sum = Sum(sum, Times(links_.RangeAt(at, more), seconds_per_link_));
    ++*rounds;
  }
  return sum;
}

Forecast RunFit::To(double accuracy) const {
  Forecast forecast;
  forecast.accuracy = accuracy;
  double variance = 0;
  double epsilon = EpsilonFor(kAimAt * accuracy, &variance);
  const RoundSummary& last = rounds_.back();
  if (last.error_estimate > accuracy) {
    epsilon = std::min(epsilon, kLargestStep * last.epsilon);
  } else if (rounds_.size() > 1) {
    epsilon = std::max(epsilon, last.epsilon);
  }
  forecast.epsilon = epsilon;
  const auto range = [&](const PowerLaw& law) {
    return law.RangeAt(epsilon, law.slope * law.slope * variance);
  };
  forecast.links = range(links_);
  forecast.elements = range(elements_);
  forecast.memory_bytes = range(memory_);
  if (last.output_elements > 0) forecast.output_elements = range(output_elements_);
  if (GatherSeconds(epsilon).likely > 0) forecast.gather_seconds = range(gather_);
  const Range rounds_s = Spend(epsilon, variance, &forecast.rounds);
  forecast.remaining_seconds = Sum(rounds_s, forecast.gather_seconds);
  // Of the rounds that there were, those that a run to this accuracy needs.
  double spent = rounds_.front().seconds;
  for (size_t i = 1; i < rounds_.size() && rounds_[i - 1].epsilon > epsilon; ++i) {
    const double share = rounds_[i].epsilon >= epsilon
                             ? 1.0
                             : std::min(1.0, links_.At(epsilon) / links_.At(rounds_[i].epsilon));
    spent += share * RoundSecondsOf(rounds_, i);
  }
  forecast.seconds = Sum({spent, spent, spent}, forecast.remaining_seconds);
  return forecast;
}

std::optional<Forecast> ForecastRun(std::span<const RoundSummary> rounds, double accuracy) {
  const bool told = std::any_of(rounds.begin(), rounds.end(), [](const RoundSummary& r) {
    return r.error_estimate > 0 && std::isfinite(r.error_estimate) && r.links > 0;
  });
  if (!told || !(accuracy > 0)) return std::nullopt;
  return RunFit(rounds).To(accuracy);
}

}  // namespace isolux
