#include "server/job_report.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/util/build_info.h"

namespace isolux {
namespace {

// What the collective operations make equal everywhere; a difference means that workers have
// computed different things.
bool Agree(const RoundReport& a, const RoundReport& b) {
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return a.crown_hash == b.crown_hash && a.iterations == b.iterations &&
         same(a.error_estimate, b.error_estimate) && same(a.residual, b.residual) &&
         same(a.energy_imbalance, b.energy_imbalance) && a.emitted_w == b.emitted_w &&
         a.absorbed_w == b.absorbed_w && a.escaped_w == b.escaped_w;
}

void AddTo(const RoundReport& report, RoundSummary* row) {
  row->elements += report.leaves;
  row->links += report.links;
  row->evaluations += report.evaluations;
  row->rays += report.rays;
  row->memory_bytes += report.memory_bytes;
  row->refine_s = std::max(row->refine_s, report.refine_s);
  row->exchange_s = std::max(row->exchange_s, report.exchange_s);
  row->solve_s = std::max(row->solve_s, report.solve_s);
}

std::string RoundLine(const RoundSummary& row) {
  return fmt::format(
      "{} epsilon {} error {} spread {} visibility {} coupling {} solver {} elements {} links {} "
      "evaluations {} rays {} iterations {} residual {} imbalance {} seconds {:.3f} refine_s "
      "{:.3f} "
      "exchange_s {:.3f} solve_s {:.3f} snapshot_s {:.3f} balance_s {:.3f} load {:.3f} bytes_in {} "
      "bytes_out {} migrated_nodes {} migrated_links {} memory_bytes {} cpu_s {:.3f}",
      row.round, row.epsilon, row.error_estimate, row.error_spread, row.error_visibility,
      row.error_coupling, row.error_solver, row.elements, row.links, row.evaluations, row.rays,
      row.iterations, row.residual, row.energy_imbalance, row.seconds, row.refine_s, row.exchange_s,
      row.solve_s, row.snapshot_s, row.balance_s, row.load_max_over_mean, row.bytes_in,
      row.bytes_out, row.migrated_nodes, row.migrated_links, row.memory_bytes,
      fmt::join(row.worker_cpu_s, ","));
}

std::string Epsilons(const SolveSummary& summary) {
  std::string text;
  for (const RoundSummary& row : summary.rounds) {
    text += fmt::format("{}{}", text.empty() ? "" : " ", row.epsilon);
  }
  return text;
}

using Comments = std::vector<std::pair<std::string, std::string>>;

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

std::string EffectLine(const Effect& effect) {
  return fmt::format("{} {} present {} bound {} evidence {}; {}", effect.name,
                     effect.decision == "not simulated" ? "not-simulated" : effect.decision,
                     effect.present ? "yes" : "no",
                     effect.bound ? fmt::format("{:.4g}", *effect.bound) : "-", effect.evidence,
                     effect.reason);
}

}  // namespace

Result<RoundSummary> MergeReports(const PerWorker<RoundReport>& reports, uint32_t round) {
  RoundSummary row;
  row.round = round;
  const RoundReport* first = nullptr;
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
  }
  if (first == nullptr) return Error(StatusCode::kInternal, "round {}: no reports", round);
  row.epsilon = first->epsilon;
  row.error_estimate = first->error_estimate;
  row.error_spread = first->error_spread;
  row.error_visibility = first->error_visibility;
  row.error_coupling = first->error_coupling;
  row.error_solver = first->error_solver;
  row.iterations = first->iterations;
  row.residual = first->residual;
  row.energy_imbalance = first->energy_imbalance;
  row.emitted_w = first->emitted_w;
  row.absorbed_w = first->absorbed_w;
  row.escaped_w = first->escaped_w;
  const auto workers = static_cast<double>(
      std::count_if(reports.begin(), reports.end(), [](const auto& r) { return r.has_value(); }));
  const double total = std::accumulate(row.worker_cpu_s.begin(), row.worker_cpu_s.end(), 0.0);
  if (total > 0) {
    row.load_max_over_mean =
        *std::max_element(row.worker_cpu_s.begin(), row.worker_cpu_s.end()) * workers / total;
  }
  return row;
}

ErrorHistogram MergeHistograms(const PerWorker<RoundReport>& reports) {
  ErrorHistogram merged;
  for (const auto& report : reports) {
    if (!report) continue;
    for (size_t i = 0; i < merged.count.size(); ++i) merged.count[i] += report->histogram.count[i];
  }
  return merged;
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
  for (const Effect& effect : asked.effects.effects) add("effect", EffectLine(effect));
  add("end_reason", ToText(summary.end_reason));
  add("rounds", summary.rounds.size());
  add("epsilons", Epsilons(summary));
  if (!summary.rounds.empty()) {
    const RoundSummary& last = summary.rounds.back();
    add("error_estimate", last.error_estimate);
    add("error_spread", last.error_spread);
    add("error_visibility", last.error_visibility);
    add("error_coupling", last.error_coupling);
    add("error_solver", last.error_solver);
    add("elements", last.elements);
    add("links", last.links);
    add("residual", last.residual);
    add("energy_imbalance", last.energy_imbalance);
    comments.emplace_back("emitted_w", fmt::format("{}", fmt::join(last.emitted_w, " ")));
    comments.emplace_back("absorbed_w", fmt::format("{}", fmt::join(last.absorbed_w, " ")));
    comments.emplace_back("escaped_w", fmt::format("{}", fmt::join(last.escaped_w, " ")));
    add("memory_bytes", last.memory_bytes);
  }
  add("rays", summary.rays);
  comments.emplace_back("seconds", fmt::format("{:.3f}", summary.seconds));
  comments.emplace_back("gather_s", fmt::format("{:.3f}", summary.gather_s));
  comments.emplace_back("gather_cpu_s",
                        fmt::format("{:.3f}", fmt::join(summary.gather_cpu_s, " ")));
  add("workers", summary.workers);
  for (const RoundSummary& row : summary.rounds) comments.emplace_back("round", RoundLine(row));
  AddTraffic(traffic, &comments);
  for (const RepairReport::Entry& entry : asked.scene.repairs.entries) {
    add("repair", RepairLine(entry));
  }
  return comments;
}

}  // namespace isolux
