#include "client/job_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

#include "client/progress.h"
#include "common/scene/doubts.h"
#include "common/scene/forecast.h"

namespace isolux {
namespace {

using nlohmann::json;

// Of all rounds; the summary's own figure comes with the end.
uint64_t Rays(const SolveSummary& summary) {
  if (summary.rays > 0) return summary.rays;
  uint64_t rays = 0;
  for (const RoundSummary& round : summary.rounds) rays += round.rays;
  return rays;
}

double Seconds(const JobInfo& job) {
  if (job.summary.seconds > 0) return job.summary.seconds;
  return job.summary.rounds.empty() ? job.activity.seconds : job.summary.rounds.back().seconds;
}

uint32_t Workers(const JobInfo& job) {
  return job.summary.workers > 0 ? job.summary.workers : job.activity.workers;
}

std::vector<MeasuredEffect> Measured(const SolveSummary& summary) {
  return summary.rounds.empty() ? std::vector<MeasuredEffect>() : summary.rounds.front().measured;
}

json MeasuredEffects(const SolveSummary& summary) {
  json list = json::array();
  for (const MeasuredEffect& effect : Measured(summary)) {
    list.push_back({{"name", effect.name},
                    {"decision", effect.off ? "off" : "on"},
                    {"measured", effect.Neglect()},
                    {"bound", effect.bound ? json(*effect.bound) : json()}});
  }
  return list;
}

// Whether the rounds reached the accuracy and the output showed more: error_unseen, or what lies
// between its points.
bool ShortOfAccuracy(const JobInfo& job) {
  return job.state == JobState::kDone && job.summary.end_reason == EndReason::kAccuracy &&
         !job.summary.rounds.empty() &&
         job.summary.rounds.back().error_estimate > job.options.accuracy;
}

json ErrorParts(const RoundSummary& round) {
  return {{"spread", round.error_spread},
          {"visibility", round.error_visibility},
          {"coupling", round.error_coupling},
          {"solver", round.error_solver},
          {"closure", round.error_closure},
          {"gather", round.error_gather},
          {"interpolation", round.error_interpolation},
          {"unseen", round.error_unseen}};
}

json History(const std::vector<RoundSummary>& rounds) {
  json history = json::array();
  for (const RoundSummary& round : rounds) {
    history.push_back({{"round", round.round},
                       {"epsilon", round.epsilon},
                       {"error_estimate", round.error_estimate},
                       {"error_rms", round.error_rms},
                       {"error_p95", round.error_p95},
                       {"error_worst", round.error_worst},
                       {"worst_polygon", round.worst_polygon},
                       {"error_parts", ErrorParts(round)},
                       {"elements", round.elements},
                       {"links", round.links},
                       {"memory_bytes", round.memory_bytes},
                       {"seconds", round.seconds},
                       {"output_elements", round.output_elements},
                       {"output_seconds", round.output_s}});
  }
  return history;
}

// Of a job that runs.
json ForecastOf(const JobInfo& job) {
  const auto forecast = ForecastRun(job.summary.rounds, job.options.accuracy);
  if (job.state != JobState::kRunning || !forecast) return {};
  const auto range = [](const Range& r) {
    return json{{"low", r.low}, {"likely", r.likely}, {"high", r.high}};
  };
  return {{"accuracy", forecast->accuracy},
          {"rounds", forecast->rounds},
          {"links", range(forecast->links)},
          {"elements", range(forecast->elements)},
          {"memory_bytes", range(forecast->memory_bytes)},
          {"remaining_seconds", range(forecast->remaining_seconds)},
          {"seconds", range(forecast->seconds)}};
}

}  // namespace

json ToJson(const JobInfo& job) {
  const bool some = !job.summary.rounds.empty();
  const RoundSummary last = some ? job.summary.rounds.back() : RoundSummary();
  const auto known = [&](auto value) { return some ? json(value) : json(); };
  json epsilons = json::array();
  for (const RoundSummary& round : job.summary.rounds) epsilons.push_back(round.epsilon);
  json repairs = json::array();
  for (const RepairReport::Entry& entry : job.repairs.entries) {
    repairs.push_back({{"kind", entry.kind}, {"count", entry.count}, {"example", entry.example}});
  }
  return {
      {"job", job.id},
      {"name", job.name},
      {"state", ToText(job.state)},
      {"message", job.error.ok() ? job.message : job.error.message()},
      {"end_reason", job.state == JobState::kDone ? json(ToText(job.summary.end_reason)) : json()},
      {"accuracy", job.options.accuracy},
      {"error_estimate", known(last.error_estimate)},
      {"error_rms", known(last.error_rms)},
      {"error_p95", known(last.error_p95)},
      {"error_worst", known(last.error_worst)},
      {"worst_polygon", known(last.worst_polygon)},
      {"doubts", DoubtsOf(job.summary)},
      {"error_parts", some ? ErrorParts(last) : json()},
      {"forecast", ForecastOf(job)},
      {"history", History(job.summary.rounds)},
      {"measured_effects", MeasuredEffects(job.summary)},
      {"finishing", job.finishing},
      {"polygons", job.polygons},
      {"elements", known(last.elements)},
      {"links", known(last.links)},
      {"rounds", job.summary.rounds.size()},
      {"epsilons", epsilons},
      {"rays", Rays(job.summary)},
      {"seconds", Seconds(job)},
      {"gather_seconds", job.summary.gather_s},
      {"energy_imbalance", known(last.energy_imbalance)},
      {"leaks", known(last.leaks)},
      {"leak_area", known(last.leak_area)},
      {"residual", known(last.residual)},
      {"memory_bytes", known(last.memory_bytes)},
      {"workers", Workers(job)},
      {"request_id", job.request_id},
      {"scene_hash", job.digest},
      {"result_bytes", job.result_bytes},
      {"repairs", repairs}};
}

std::string TimeText(int64_t unix_ms) {
  if (unix_ms == 0) return "-";
  const std::time_t seconds = unix_ms / 1000;
  std::tm local{};
  ::localtime_r(&seconds, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &local);
  return text;
}

std::string Summarize(const JobInfo& job) {
  std::string line = fmt::format("job {} {}", job.id, ToText(job.state));
  const std::string& why = job.error.ok() ? job.message : job.error.message();
  if (!why.empty()) line += ": " + why;
  if (!job.summary.rounds.empty()) {
    const RoundSummary& last = job.summary.rounds.back();
    line += fmt::format(", error {:.2f} %{}, {} rounds, {} links, {} elements",
                        100 * last.error_estimate,
                        ShortOfAccuracy(job) ? " with the output gathered" : "",
                        job.summary.rounds.size(), last.links, last.elements);
  }
  return line + fmt::format(", {:.1f} s", Seconds(job));
}

std::string Describe(const JobInfo& job) {
  std::string text;
  const auto row = [&](const char* name, const std::string& value) {
    text += fmt::format("{:<18} {}\n", name, value);
  };
  row("job", fmt::format("{} ({})", job.id, job.name));
  row("state", ToText(job.state));
  const std::string& why = job.error.ok() ? job.message : job.error.message();
  if (!why.empty()) row("because", why);
  if (job.state == JobState::kRunning) {
    row("doing", job.activity.phase + (job.finishing ? ", to finish after this round" : ""));
    const double since_s =
        job.summary.rounds.empty() ? 0 : job.activity.seconds - job.summary.rounds.back().seconds;
    const std::string forecast =
        ForecastText(job.summary.rounds, job.options.accuracy, std::max(0.0, since_s));
    if (!forecast.empty()) row("forecast", forecast);
  }
  row("submitted", TimeText(job.submitted_ms));
  row("started", TimeText(job.started_ms));
  row("ended", TimeText(job.finished_ms));
  row("polygons", std::to_string(job.polygons));
  row("accuracy", fmt::format("{:g} %", 100 * job.options.accuracy));
  if (!job.summary.rounds.empty()) {
    const RoundSummary& last = job.summary.rounds.back();
    row("error estimate", fmt::format("{:.3f} %", 100 * last.error_estimate));
    for (const std::string& doubt : DoubtsOf(job.summary)) row("in doubt", doubt);
    row("error, RMS", fmt::format("{:.3f} %", 100 * last.error_rms));
    row("local error", fmt::format("below {:.3g} % on 95 % of the area", 100 * last.error_p95));
    row("energy imbalance", fmt::format("{:.3f} %", 100 * last.energy_imbalance));
    row("leaks",
        fmt::format("{} elements, {:.3g} % of the area", last.leaks, 100 * last.leak_area));
    row("residual", fmt::format("{:.3g}", last.residual));
    row("rounds", std::to_string(job.summary.rounds.size()));
    row("elements", std::to_string(last.elements));
    row("links", std::to_string(last.links));
  }
  for (const MeasuredEffect& effect : Measured(job.summary)) row("effect", ToText(effect));
  row("rays", std::to_string(Rays(job.summary)));
  row("seconds", fmt::format("{:.2f}", Seconds(job)));
  row("workers", std::to_string(Workers(job)));
  if (job.state == JobState::kDone) row("result", fmt::format("{} bytes", job.result_bytes));
  return text;
}

}  // namespace isolux
