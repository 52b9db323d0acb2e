#include "server/job_report.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "common/scene/doubts.h"
#include "common/scene/forecast.h"
#include "common/util/build_info.h"

namespace isolux {
namespace {

// What the collective operations make equal everywhere; a difference means that workers have
// computed different things.
bool Agree(const RoundReport& a, const RoundReport& b) {
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return a.crown_hash == b.crown_hash && a.iterations == b.iterations &&
         same(a.error_estimate, b.error_estimate) && same(a.error_rms, b.error_rms) &&
         same(a.error_closure, b.error_closure) && same(a.residual, b.residual) &&
         a.leaks.leaves == b.leaks.leaves && same(a.leaks.area_share, b.leaks.area_share) &&
         same(a.energy_imbalance, b.energy_imbalance) && a.emitted_w == b.emitted_w &&
         a.absorbed_w == b.absorbed_w && a.escaped_w == b.escaped_w && a.medium_w == b.medium_w &&
         a.glass_w == b.glass_w && a.measured == b.measured;
}

void AddTo(const RoundReport& report, RoundSummary* row) {
  row->elements += report.leaves;
  row->links += report.links;
  row->evaluations += report.evaluations;
  row->proved_visible += report.proved_visible;
  row->proved_hidden += report.proved_hidden;
  row->rays += report.rays;
  row->memory_bytes += report.memory_bytes;
  row->costs.Add(report.costs);
  row->refine_s = std::max(row->refine_s, report.refine_s);
  row->exchange_s = std::max(row->exchange_s, report.exchange_s);
  row->solve_s = std::max(row->solve_s, report.solve_s);
}

// Figures with their names, side by side.
class Figures {
 public:
  template <typename T>
  Figures& Add(const char* name, const T& value) {
    text_ += fmt::format("{}{} {}", text_.empty() ? "" : " ", name, value);
    return *this;
  }
  Figures& AddSeconds(const char* name, double seconds) {
    text_ += fmt::format(" {} {:.3f}", name, seconds);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string RoundLine(const RoundSummary& row) {
  Figures line;
  line.Add("epsilon", row.epsilon)
      .Add("error", row.error_estimate)
      .Add("spread", row.error_spread)
      .Add("visibility", row.error_visibility)
      .Add("coupling", row.error_coupling)
      .Add("solver", row.error_solver)
      .Add("closure", row.error_closure)
      .Add("gather", row.error_gather)
      .Add("interpolation", row.error_interpolation)
      .Add("unseen", row.error_unseen)
      .Add("rms", row.error_rms)
      .Add("p95", row.error_p95)
      .Add("worst", row.error_worst)
      .Add("worst_polygon", row.worst_polygon)
      .Add("worst_surface", row.worst_surface)
      .Add("worst_path", row.worst_path)
      .Add("elements", row.elements)
      .Add("links", row.links)
      .Add("evaluations", row.evaluations)
      .Add("proved_visible", row.proved_visible)
      .Add("proved_hidden", row.proved_hidden)
      .Add("rays", row.rays)
      .Add("iterations", row.iterations)
      .Add("residual", row.residual)
      .Add("imbalance", row.energy_imbalance)
      .Add("leaks", row.leaks)
      .Add("leak_area", row.leak_area)
      .AddSeconds("seconds", row.seconds)
      .AddSeconds("refine_s", row.refine_s)
      .AddSeconds("exchange_s", row.exchange_s)
      .AddSeconds("solve_s", row.solve_s)
      .AddSeconds("snapshot_s", row.snapshot_s)
      .AddSeconds("balance_s", row.balance_s)
      .AddSeconds("sample_s", row.sample_s)
      .AddSeconds("load", row.load_max_over_mean)
      .Add("bytes_in", row.bytes_in)
      .Add("bytes_out", row.bytes_out)
      .Add("migrated_nodes", row.migrated_nodes)
      .Add("migrated_links", row.migrated_links)
      .Add("memory_bytes", row.memory_bytes)
      .Add("output_elements", row.output_elements)
      .Add("output_points", row.output_points)
      .Add("output_rays", row.output_rays)
      .AddSeconds("output_s", row.output_s)
      .Add("links_per_split", row.links_per_split)
      .Add("cpu_s", fmt::format("{:.3f}", fmt::join(row.worker_cpu_s, ",")));
  return fmt::format("{} {}", row.round, line.text());
}

// What was to be expected of the whole run after the first `count` rounds.
std::string ForecastLine(std::span<const RoundSummary> rounds, double accuracy) {
  const auto forecast = ForecastRun(rounds, accuracy);
  if (!forecast) return {};
  const auto add = [](const char* name, const Range& range) {
    return fmt::format(" {0}_low {1:.4g} {0}_likely {2:.4g} {0}_high {3:.4g}", name, range.low,
                       range.likely, range.high);
  };
  return fmt::format("{}{}{}", rounds.back().round, add("seconds", forecast->seconds),
                     add("links", forecast->links));
}

std::string Epsilons(const SolveSummary& summary) {
  std::string text;
  for (const RoundSummary& row : summary.rounds) {
    text += fmt::format("{}{}", text.empty() ? "" : " ", row.epsilon);
  }
  return text;
}

using Comments = std::vector<std::pair<std::string, std::string>>;

void AddLastRound(const RoundSummary& last, Comments* comments) {
  const auto add = [&](const char* key, const auto& value) {
    comments->emplace_back(key, fmt::format("{}", value));
  };
  add("error_estimate", last.error_estimate);
  add("error_spread", last.error_spread);
  add("error_visibility", last.error_visibility);
  add("error_coupling", last.error_coupling);
  add("error_solver", last.error_solver);
  add("error_closure", last.error_closure);
  add("error_gather", last.error_gather);
  add("error_interpolation", last.error_interpolation);
  add("error_unseen", last.error_unseen);
  add("error_rms", last.error_rms);
  add("error_p95", last.error_p95);
  add("error_worst", last.error_worst);
  add("worst_polygon", last.worst_polygon);
  add("worst_surface", last.worst_surface);
  add("worst_path", last.worst_path);
  add("elements", last.elements);
  add("links", last.links);
  add("residual", last.residual);
  add("energy_imbalance", last.energy_imbalance);
  comments->emplace_back("emitted_w", fmt::format("{}", fmt::join(last.emitted_w, " ")));
  comments->emplace_back("absorbed_w", fmt::format("{}", fmt::join(last.absorbed_w, " ")));
  comments->emplace_back("escaped_w", fmt::format("{}", fmt::join(last.escaped_w, " ")));
  if (last.medium_w != decltype(last.medium_w){}) {
    comments->emplace_back("medium_w", fmt::format("{}", fmt::join(last.medium_w, " ")));
  }
  if (last.glass_w != decltype(last.glass_w){}) {
    comments->emplace_back("glass_w", fmt::format("{}", fmt::join(last.glass_w, " ")));
  }
  add("memory_bytes", last.memory_bytes);
}

void AddBands(const std::vector<BandGroupSummary>& groups, Comments* comments) {
  size_t number = 0, band = 0;
  for (const BandGroupSummary& group : groups) {
    Figures line;
    line.Add("bands", fmt::format("{}-{}", band + 1, band + group.bands.size()))
        .Add("channels", group.channels)
        .Add("error", group.error_estimate)
        .Add("unseen", group.error_unseen)
        .Add("irradiance_w", group.irradiance_w)
        .Add("iterations", group.iterations)
        .Add("residual", group.residual)
        .Add("imbalance", group.energy_imbalance)
        .AddSeconds("seconds", group.seconds);
    if (group.error_handed_on > 0) line.Add("handed_on", group.error_handed_on);
    comments->emplace_back("band_group", fmt::format("{} {}", ++number, line.text()));
    for (const BandSummary& of_band : group.bands) {
      Figures powers;
      powers.Add("emitted_w", of_band.emitted_w)
          .Add("absorbed_w", of_band.absorbed_w)
          .Add("escaped_w", of_band.escaped_w);
      if (of_band.medium_w > 0) powers.Add("medium_w", of_band.medium_w);
      if (of_band.glass_w > 0) powers.Add("glass_w", of_band.glass_w);
      comments->emplace_back("band_power", fmt::format("{} {}", ++band, powers.text()));
    }
  }
}

// In all, then by connection, where anything went. Connections are counted in the order in which
// they were made: a worker that came again is another.
void AddTraffic(const Traffic& traffic, Comments* comments) {
  for (int i = 0; i < kPhaseCount; ++i) {
    const auto phase = static_cast<Phase>(i);
    const PhaseBytes bytes = traffic.Total(phase);
    comments->emplace_back(
        "traffic", fmt::format("{} bytes_in {} bytes_out {}", ToText(phase), bytes.in, bytes.out));
  }
  int connection = 0;
  for (const auto& [id, phases] : traffic.by_worker) {
    ++connection;
    for (int i = 0; i < kPhaseCount; ++i) {
      const PhaseBytes& bytes = phases[static_cast<size_t>(i)];
      if (bytes.in == 0 && bytes.out == 0) continue;
      comments->emplace_back("worker_traffic",
                             fmt::format("{} {} bytes_in {} bytes_out {}", connection,
                                         ToText(static_cast<Phase>(i)), bytes.in, bytes.out));
    }
  }
}

std::string RepairLine(const RepairReport::Entry& entry) {
  return fmt::format("{} {}{}", entry.count, entry.kind,
                     entry.example.empty() ? "" : " (" + entry.example + ")");
}

std::string EffectLine(const Effect& effect, const EffectCosts& costs) {
  const auto number = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.4g}", *value) : std::string("-");
  };
  Figures line;
  line.Add("present", effect.present ? "yes" : "no").Add("bound", number(effect.bound));
  if (effect.measured) line.Add("measured", number(effect.measured));
  if (const EffectCost* cost = costs.Find(effect.name)) {
    line.AddSeconds("cpu_s", cost->cpu_s).Add("rays", cost->rays);
    if (cost->links > 0) line.Add("links", cost->links);
  }
  return fmt::format("{} {} {} evidence {}; {}", effect.name,
                     effect.decision == "not simulated" ? "not-simulated" : effect.decision,
                     line.text(), effect.evidence, effect.reason);
}

// What the rays of a round found open, for the row of closure: rows add up to what that leaves.
std::string WhatEscapes(const RoundSummary& round) {
  double emitted_w = 0, escaped_w = 0;
  for (const double channel : round.emitted_w) emitted_w += channel;
  for (const double channel : round.escaped_w) escaped_w += channel;
  if (!(emitted_w > 0)) return {};
  if (!(escaped_w > 0)) return "; no ray escapes";
  return fmt::format("; {:.3g} of the emitted power escapes, by rays of round {}",
                     escaped_w / emitted_w, round.round);
}

}  // namespace

Result<RoundSummary> MergeReports(const PerWorker<RoundReport>& reports, uint32_t round) {
  RoundSummary row;
  row.round = round;
  const RoundReport* first = nullptr;
  LocalErrors local;
  for (const auto& report : reports) {
    row.worker_cpu_s.push_back(report ? report->cpu_s : 0.0);
    if (!report) continue;
    if (first == nullptr) first = &*report;
    if (!Agree(*first, *report)) {
      return Error(StatusCode::kInternal,
                   "workers disagree after round {} (crown {:016x} and {:016x}, error {} and {}): "
                   "they must run the same build on the same scene",
                   round, first->crown_hash, report->crown_hash, first->error_estimate,
                   report->error_estimate);
    }
    AddTo(*report, &row);
    local.Add(report->local_errors);
  }
  if (first == nullptr) return Error(StatusCode::kInternal, "round {}: no reports", round);
  row.epsilon = first->epsilon;
  row.error_estimate = first->error_estimate;
  row.error_spread = first->error_spread;
  row.error_visibility = first->error_visibility;
  row.error_coupling = first->error_coupling;
  row.error_solver = first->error_solver;
  row.error_closure = first->error_closure;
  row.leaks = first->leaks.leaves;
  row.leak_area = first->leaks.area_share;
  row.error_rms = first->error_rms;
  row.error_p95 = local.Quantile(0.95);
  row.error_worst = local.worst;
  row.worst_surface = local.worst_leaf.surface;
  row.worst_path = local.worst_leaf.path;
  row.iterations = first->iterations;
  row.residual = first->residual;
  row.energy_imbalance = first->energy_imbalance;
  row.emitted_w = first->emitted_w;
  row.absorbed_w = first->absorbed_w;
  row.escaped_w = first->escaped_w;
  row.medium_w = first->medium_w;
  row.glass_w = first->glass_w;
  row.measured = first->measured;
  const auto workers = static_cast<double>(
      std::count_if(reports.begin(), reports.end(), [](const auto& r) { return r.has_value(); }));
  const double total = std::accumulate(row.worker_cpu_s.begin(), row.worker_cpu_s.end(), 0.0);
  if (total > 0) {
    row.load_max_over_mean =
        *std::max_element(row.worker_cpu_s.begin(), row.worker_cpu_s.end()) * workers / total;
  }
  return row;
}

EffectCosts TotalCosts(std::span<const RoundSummary> rounds, const EffectCosts& gather) {
  EffectCosts total = gather;
  for (const RoundSummary& row : rounds) total.Add(row.costs);
  for (size_t i = 0; i < EffectCosts::kCount && !rounds.empty(); ++i) {
    total.at(i).links = rounds.back().costs.at(i).links;
  }
  return total;
}

void AddOutputErrors(double interpolation_error, RoundSummary* last) {
  last->error_interpolation = interpolation_error;
  last->error_estimate = std::hypot(last->error_estimate, interpolation_error, last->error_unseen);
}

Result<CutLoads> MergeLoads(const PerWorker<RoundReport>& reports, const Assignment& assignment) {
  CutLoads loads;
  for (size_t i = 0; i < assignment.cut.size(); ++i) {
    const auto& report = reports[assignment.home[i]];
    if (!report || report->cut_cost_ns.size() != assignment.cut.size() ||
        report->cut_links.size() != assignment.cut.size() ||
        report->cut_elements.size() != assignment.cut.size()) {
      return Error(StatusCode::kInternal, "worker {} reports no load for each node of the cut",
                   assignment.home[i]);
    }
    const double cost = report->cut_cost_ns[i];
    loads.cost.push_back(std::isfinite(cost) ? std::max(cost, 0.0) : 0.0);
    loads.links.push_back(report->cut_links[i]);
    loads.elements.push_back(report->cut_elements[i]);
  }
  return loads;
}

Comments MakeComments(const Asked& asked, const SolveSummary& summary, const Traffic& traffic) {
  Comments comments;
  const auto add = [&](const char* key, const auto& value) {
    comments.emplace_back(key, fmt::format("{}", value));
  };
  add("version", Version());
  if (!asked.name.empty()) add("scene", asked.name);
  add("unit", asked.scene.unit);
  add("scene_hash", asked.scene_hash);
  add("accuracy", asked.options.accuracy);
  add("seed", asked.options.seed);
  add("solver", ToText(asked.options.solver));
  add("effects", asked.options.effects);
  for (Effect effect : asked.effects.effects) {
    if (effect.name == "closure" && effect.on && !summary.rounds.empty()) {
      effect.evidence += WhatEscapes(summary.rounds.back());
    }
    add("effect", EffectLine(effect, summary.costs));
  }
  add("end_reason", ToText(summary.end_reason));
  add("rounds", summary.rounds.size());
  add("epsilons", Epsilons(summary));
  if (!summary.rounds.empty()) AddLastRound(summary.rounds.back(), &comments);
  for (const std::string& doubt : DoubtsOf(summary)) add("doubt", doubt);
  add("rays", summary.rays);
  comments.emplace_back("seconds", fmt::format("{:.3f}", summary.seconds));
  comments.emplace_back("gather_s", fmt::format("{:.3f}", summary.gather_s));
  comments.emplace_back("gather_cpu_s",
                        fmt::format("{:.3f}", fmt::join(summary.gather_cpu_s, " ")));
  add("workers", summary.workers);
  for (size_t k = 0; k < summary.rounds.size(); ++k) {
    RoundSummary row = summary.rounds[k];
    // The last has it already; those before stated it when their sources were gathered.
    const bool is_last = k + 1 == summary.rounds.size();
    if (!is_last) row.error_estimate = std::hypot(row.error_estimate, row.error_unseen);
    comments.emplace_back("round", RoundLine(row));
  }
  for (size_t k = 1; k <= summary.rounds.size(); ++k) {
    const std::string line =
        ForecastLine(std::span(summary.rounds).first(k), asked.options.accuracy);
    if (!line.empty()) comments.emplace_back("forecast", line);
  }
  AddBands(summary.band_groups, &comments);
  AddTraffic(traffic, &comments);
  for (const RepairReport::Entry& entry : asked.scene.repairs.entries) {
    add("repair", RepairLine(entry));
  }
  return comments;
}

}  // namespace isolux
