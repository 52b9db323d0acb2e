#include "server/schedule.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

constexpr double kFirst = 0.02;   // ε_1 over emitted power: some hundred links in a plain room
constexpr double kLeast = 1e-13;  // ε over emitted power that single precision cannot resolve
constexpr double kPlainStep = 1.0 / 4;
constexpr double kSmallestStep = 1.0 / 16, kLargestStep = 1.0 / 2;
constexpr double kWorthARound = 0.7;  // a budget that allows no smaller step ends the rounds
constexpr double kAimAt = 0.9;        // of the accuracy asked for
constexpr double kErrorPower = 0.3, kLeastPower = 0.2, kMostPower = 0.5;  // error ~ ε^power
constexpr double kLinkPower = 0.75;                                       // links ~ ε^-power
constexpr double kLinkPowerBlind = 1.0;            // the same, to be safe, without a histogram
constexpr double kGatherSecondsPerElement = 2e-4;  // of one worker

// Factor by which ε should fall to reach the accuracy. The first round's estimate counts for
// little: without a solution to look at it cannot know how values vary within a link.
double WantedStep(const ScheduleInput& input) {
  const size_t count = input.rounds.size();
  const RoundSummary& last = input.rounds.back();
  double power = kErrorPower;
  if (count >= 2) {
    const RoundSummary& before = input.rounds[count - 2];
    if (last.links == before.links) return kSmallestStep;  // ε is far above every link's error
    const double falls = std::log(before.error_estimate / last.error_estimate) /
                         std::log(before.epsilon / last.epsilon);
    if (count >= 3 && std::isfinite(falls)) power = std::clamp(falls, kLeastPower, kMostPower);
  }
  const double missing = kAimAt * input.options.accuracy / last.error_estimate;
  const double step = std::pow(missing, 1 / power);
  if (!std::isfinite(step)) return kPlainStep;
  // A small step is for the last bit of the way; where one has not reached, the next is a plain
  // one.
  const bool after_small_step =
      count >= 2 && last.epsilon > kPlainStep * 1.01 * input.rounds[count - 2].epsilon;
  const double largest = count == 1 || after_small_step ? kPlainStep : kLargestStep;
  return std::clamp(step, kSmallestStep, largest);
}

// Whether ε would keep the links (or their memory) within `budget`, both counted in links. The
// histogram knows which links are about to be divided, the law what becomes of those that are made.
bool Fits(const ScheduleInput& input, double epsilon, double budget) {
  const RoundSummary& last = input.rounds.back();
  const double falls = last.epsilon / epsilon;
  const double by_law = static_cast<double>(last.links) *
                        std::pow(falls, input.has_histogram ? kLinkPower : kLinkPowerBlind);
  const double by_histogram = input.has_histogram ? PredictLinks(input.histogram, epsilon) : 0;
  return std::max(by_law, by_histogram) <= budget;
}

// The smallest ε not below `wanted` that fits; nothing where not even a small step does.
std::optional<double> Largen(const ScheduleInput& input, double wanted, double budget) {
  const double most = kWorthARound * input.rounds.back().epsilon;
  for (double epsilon = wanted; epsilon <= most; epsilon *= std::sqrt(2.0)) {
    if (Fits(input, epsilon, budget)) return epsilon;
  }
  return Fits(input, most, budget) ? std::optional(most) : std::nullopt;
}

double RoundSeconds(const ScheduleInput& input) {
  const double before = input.rounds.size() < 2 ? 0 : input.rounds[input.rounds.size() - 2].seconds;
  return std::max(0.0, input.rounds.back().seconds - before);
}

// The same for the time that is left.
std::optional<double> LargenForTime(const ScheduleInput& input, double wanted) {
  const RoundSummary& last = input.rounds.back();
  const double most = kWorthARound * last.epsilon;
  for (double epsilon = std::min(wanted, most);; epsilon = std::min(most, 2 * epsilon)) {
    const double growth = std::pow(last.epsilon / epsilon, kLinkPower);
    const double round_s = RoundSeconds(input) * growth;
    const auto elements = static_cast<uint64_t>(static_cast<double>(last.elements) * growth);
    const double gather_s = PredictGatherSeconds(elements, input.workers);
    if (input.seconds + round_s + gather_s <= input.options.max_seconds) return epsilon;
    if (epsilon >= most) return std::nullopt;
  }
}

uint64_t MemoryLimit(const ScheduleInput& input) {
  const uint64_t asked = input.options.max_memory_bytes;
  if (asked == 0) return input.memory_limit_bytes;
  if (input.memory_limit_bytes == 0) return asked;
  return std::min(asked, input.memory_limit_bytes);
}

ScheduleDecision Stop(EndReason reason) { return {true, reason, 0, 0}; }

// Thresholds that were given: one a round, whatever the error and the budgets.
ScheduleDecision FollowList(const ScheduleInput& input, double accuracy) {
  const auto& list = input.options.epsilons;
  if (input.rounds.size() < list.size()) return {false, {}, list[input.rounds.size()], accuracy};
  const bool reached = input.rounds.back().error_estimate <= input.options.accuracy;
  return Stop(reached ? EndReason::kAccuracy : EndReason::kRounds);
}

// How well a round is to be solved: no better than what its links are worth.
double RoundAccuracy(const ScheduleInput& input) {
  const double last = input.rounds.empty() ? 1.0 : input.rounds.back().error_estimate;
  if (!std::isfinite(last)) return input.options.accuracy;
  return std::clamp(0.3 * last, input.options.accuracy, std::max(0.1, input.options.accuracy));
}

}  // namespace

double PredictLinks(const ErrorHistogram& histogram, double epsilon) {
  double links = 0;
  for (size_t bin = 0; bin < histogram.count.size(); ++bin) {
    if (histogram.count[bin] == 0) continue;
    const double error = std::ldexp(1.0, static_cast<int>(bin) + ErrorHistogram::kLowest + 1);
    const double halvings = std::max(0.0, std::log2(error / epsilon));
    links += static_cast<double>(histogram.count[bin]) * std::pow(kChildrenPerSplit, halvings);
  }
  return links;
}

double PredictGatherSeconds(uint64_t elements, uint32_t workers) {
  return kGatherSecondsPerElement * static_cast<double>(elements) / std::max(1u, workers);
}

ScheduleDecision DecideNext(const ScheduleInput& input) {
  const SolveOptions& options = input.options;
  const double accuracy = RoundAccuracy(input);
  if (input.finish && !input.rounds.empty()) return Stop(EndReason::kFinished);
  if (!options.epsilons.empty()) return FollowList(input, accuracy);
  if (input.rounds.empty()) return {false, {}, kFirst * input.emitted_w, accuracy};

  const RoundSummary& last = input.rounds.back();
  // One round alone may not have looked closely enough to see its own error.
  if (last.error_estimate <= options.accuracy && input.rounds.size() >= 2) {
    return Stop(EndReason::kAccuracy);
  }
  if (input.rounds.size() >= options.max_rounds) return Stop(EndReason::kRounds);

  double epsilon = last.epsilon * WantedStep(input);
  if (epsilon < kLeast * input.emitted_w) return Stop(EndReason::kPrecision);
  if (options.max_links > 0) {
    const auto fitting = Largen(input, epsilon, static_cast<double>(options.max_links));
    if (!fitting) return Stop(EndReason::kLinks);
    epsilon = *fitting;
  }
  if (const uint64_t limit = MemoryLimit(input); limit > 0 && last.links > 0) {
    const double bytes_per_link =
        static_cast<double>(last.memory_bytes) / static_cast<double>(last.links);
    if (bytes_per_link > 0) {
      const auto fitting = Largen(input, epsilon, static_cast<double>(limit) / bytes_per_link);
      if (!fitting) return Stop(EndReason::kMemory);
      epsilon = *fitting;
    }
  }
  if (options.max_seconds > 0) {
    const auto fitting = LargenForTime(input, epsilon);
    if (!fitting) return Stop(EndReason::kSeconds);
    epsilon = *fitting;
  }
  return {false, {}, epsilon, accuracy};
}

}  // namespace isolux
