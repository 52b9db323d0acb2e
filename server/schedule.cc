#include "server/schedule.h"

#include <algorithm>
#include <cmath>

#include "common/scene/forecast.h"
#include "server/link_budget.h"

namespace isolux {
namespace {

constexpr double kFirst = 0.02;  // ε_1 over emitted power: some hundred links in a plain room
// Where light is reflected more often than that, ε_1 is over what arrives in all and over this.
constexpr double kOrdinaryAmplification = 10;
// Where more than so many times as much would arrive from lights unhindered, as in a closed house
// in the sun, ε_1 was far too large to see the lamps inside: it is taken anew.
constexpr double kHindered = 4;
constexpr double kLeast = 1e-13;  // ε over emitted power that single precision cannot resolve
constexpr double kPlainStep = 1.0 / 4;
constexpr double kWorthARound = 0.85;  // a time budget that allows no smaller step ends the rounds
constexpr double kTimeUsed = 0.97;     // of a time budget: the rest is for writing the patch file
// A large step may take far more than is likely, so it keeps all that in hand; steps above this
// then come nearer to the end, and keep only so much of it.
constexpr double kNearerStep = 0.5;
constexpr double kSpareWhenNear = 0.35;

// Once the gather has found more error than was asked for, the next rounds aim at no less than this
// over what their links have stated,
constexpr double kLeastAfterGather = 0.5;
// and are not worth it where the links to come are more than so many times those there are.
constexpr double kWorthLinks = 8;
constexpr size_t kMostGathers = 4;  // of the sources, in a run

// What rows may lack no longer falls, as where the room reflects so much that openings which
// millions of rays have not found would matter; and the rest is small enough.
bool IsNoLongerUpToLinks(const ScheduleInput& input) {
  constexpr double kFalls = 0.9;
  if (input.rounds.size() < 2) return false;
  const RoundSummary& last = input.rounds.back();
  const double half = 0.5 * input.options.accuracy;
  return last.error_closure > half && last.error_estimate - last.error_closure < half &&
         last.error_closure > kFalls * input.rounds[input.rounds.size() - 2].error_closure;
}

double Stated(const RoundSummary& row) { return std::hypot(row.error_estimate, row.error_unseen); }

// What the next round's links should state for the output to have the accuracy: less than that,
// once the gather has found what they miss.
double AccuracyOfLinks(const ScheduleInput& input) {
  const double asked = input.options.accuracy;
  double accuracy = asked;
  for (const RoundSummary& row : input.rounds) {
    if (!(row.error_unseen > 0) || Stated(row) <= asked) continue;
    accuracy =
        std::min(accuracy, row.error_estimate * std::max(kLeastAfterGather, asked / Stated(row)));
  }
  return accuracy;
}

// Whether what the gather of the last round has found is worth further rounds: at first it is;
// then as it has fallen with the links since the time before.
bool IsWorthRounds(const ScheduleInput& input) {
  const RoundSummary& last = input.rounds.back();
  const RoundSummary* before = nullptr;
  size_t gathers = 0;
  for (const RoundSummary& row : input.rounds) {
    if (!(row.error_unseen > 0)) continue;
    if (&row != &last) before = &row;
    ++gathers;
  }
  if (before == nullptr) return true;
  const double fallen = std::log(Stated(*before) / Stated(last));
  const double grown =
      std::log(static_cast<double>(last.links) / static_cast<double>(before->links));
  const double to_fall = std::log(Stated(last) / input.options.accuracy);
  return gathers < kMostGathers && fallen > 0 && to_fall * grown <= std::log(kWorthLinks) * fallen;
}

bool IsAccurate(const ScheduleInput& input) {
  const RoundSummary& last = input.rounds.back();
  // One round alone may not have looked closely enough to see its own error.
  if (input.rounds.size() < 2) return false;
  if (Stated(last) <= input.options.accuracy) return true;
  return last.error_unseen > 0 && last.error_estimate <= input.options.accuracy &&
         !IsWorthRounds(input);
}

// Factor by which ε should fall to reach the accuracy.
double WantedStep(const ScheduleInput& input, const RunFit& fit) {
  const size_t count = input.rounds.size();
  const RoundSummary& last = input.rounds.back();
  if (count >= 2 && last.links == input.rounds[count - 2].links) {
    return kSmallestStep;  // ε is far above every link's error
  }
  const double step = fit.EpsilonFor(kAimAt * AccuracyOfLinks(input)) / last.epsilon;
  if (!(last.error_estimate > 0) || !std::isfinite(step)) return kPlainStep;
  // A small step is for the last bit of the way; where one has not reached, the next is a plain
  // one.
  const bool after_small_step =
      count >= 2 && last.epsilon > kPlainStep * 1.01 * input.rounds[count - 2].epsilon;
  // What the gather has found may take less than it seems.
  if (last.error_unseen > 0) return std::clamp(step, kPlainStep, kLargestStep);
  const double largest = count == 1 || after_small_step ? kPlainStep : kLargestStep;
  return std::clamp(step, kSmallestStep, largest);
}

double TimeLeft(const ScheduleInput& input) {
  return kTimeUsed * input.options.max_seconds - input.seconds;
}

// The smallest ε not below `wanted` at which the time that is left is enough for a round and the
// gather; nothing where not even a small step is.
std::optional<double> StepWithinTime(const ScheduleInput& input, const RunFit& fit, double wanted) {
  const double last = input.rounds.back().epsilon, most = kWorthARound * last;
  for (double epsilon = std::min(wanted, most);; epsilon = std::min(most, 1.25 * epsilon)) {
    const Range round = fit.RoundSeconds(epsilon), gather = fit.GatherSeconds(epsilon);
    const double spare_s = std::hypot(round.high - round.likely, gather.high - gather.likely);
    const double kept = epsilon >= kNearerStep * last ? kSpareWhenNear : 1;
    if (round.likely + gather.likely + kept * spare_s <= TimeLeft(input)) return epsilon;
    if (epsilon >= most) return std::nullopt;
  }
}

// Bytes that one more link takes, with its nodes.
double BytesPerLink(std::span<const RoundSummary> rounds) {
  const RoundSummary& last = rounds.back();
  if (rounds.size() > 1) {
    const RoundSummary& before = rounds[rounds.size() - 2];
    if (last.links > before.links && last.memory_bytes > before.memory_bytes) {
      return static_cast<double>(last.memory_bytes - before.memory_bytes) /
             static_cast<double>(last.links - before.links);
    }
  }
  return last.links > 0 ? static_cast<double>(last.memory_bytes) / static_cast<double>(last.links)
                        : 0.0;
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

double AmplificationIn(const Hierarchy& hierarchy) {
  double area_m2 = 0, reflecting_m2 = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Rgb& rho = hierarchy.surfaces()[s].reflectance;
    area_m2 += hierarchy.surface_area_m2(s);
    reflecting_m2 += hierarchy.surface_area_m2(s) * std::max({rho.x, rho.y, rho.z});
  }
  return 1 / std::max(1e-6, 1 - reflecting_m2 / area_m2);
}

double TimeForGather(const ScheduleInput& input) {
  if (!(input.options.max_seconds > 0) || input.rounds.empty()) return 1;
  const Range gather = RunFit(input.rounds).GatherSeconds(input.rounds.back().epsilon);
  const double most_s = gather.likely + kSpareWhenNear * (gather.high - gather.likely);
  return most_s > 0 ? std::max(1.0, TimeLeft(input) / most_s) : 1;
}

ScheduleDecision DecideNext(const ScheduleInput& input) {
  const SolveOptions& options = input.options;
  const double accuracy = RoundAccuracy(input);
  if (input.finish && !input.rounds.empty()) return Stop(EndReason::kFinished);
  if (!options.epsilons.empty()) return FollowList(input, accuracy);
  const double first = kFirst * std::max(1.0, input.amplification / kOrdinaryAmplification);
  if (input.rounds.empty()) return {false, {}, first * input.emitted_w, accuracy};

  const RoundSummary& last = input.rounds.back();
  const double arrived_w = last.emitted_w[0] + last.emitted_w[1] + last.emitted_w[2];
  const bool hindered = arrived_w > 0 && last.epsilon > kHindered * first * arrived_w;
  if (hindered && input.rounds.size() < options.max_rounds) {
    return {false, {}, first * arrived_w, accuracy};
  }
  if (IsAccurate(input)) return Stop(EndReason::kAccuracy);
  if (input.rounds.size() >= options.max_rounds) return Stop(EndReason::kRounds);

  if (IsNoLongerUpToLinks(input)) return Stop(EndReason::kPrecision);

  const RunFit fit(input.rounds);
  double epsilon = last.epsilon * WantedStep(input, fit);
  if (epsilon < kLeast * input.emitted_w) return Stop(EndReason::kPrecision);
  const auto step_within = [&](const Budget& budget) {
    return StepWithin(budget, input.histogram, input.rounds, epsilon, -fit.links().slope);
  };
  if (options.max_links > 0) {
    const auto step =
        step_within({static_cast<double>(last.links), static_cast<double>(options.max_links), 1.0});
    if (!step) return Stop(EndReason::kLinks);
    epsilon = *step;
  }
  if (const uint64_t limit = MemoryLimit(input); limit > 0 && last.memory_bytes > 0) {
    const auto step = step_within({static_cast<double>(last.memory_bytes),
                                   static_cast<double>(limit), BytesPerLink(input.rounds)});
    if (!step) return Stop(EndReason::kMemory);
    epsilon = *step;
  }
  if (options.max_seconds > 0) {
    const auto step = StepWithinTime(input, fit, epsilon);
    if (!step) return Stop(EndReason::kSeconds);
    epsilon = *step;
  }
  return {false, {}, epsilon, accuracy};
}

}  // namespace isolux
