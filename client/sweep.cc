#include "client/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace isolux {
namespace {

using nlohmann::json;

// Largest over smallest: runs that take alike follow no power of what they take.
constexpr double kLeastSpan = 1.25;

// Runs of one method, in their order.
std::vector<std::vector<const SweepRun*>> ByMethod(const Sweep& sweep) {
  std::vector<std::vector<const SweepRun*>> groups;
  for (const SweepRun& run : sweep.runs) {
    if (groups.empty() || groups.back().front()->method != run.method) groups.emplace_back();
    groups.back().push_back(&run);
  }
  return groups;
}

std::string Percent(double share) {
  return share > 0 ? fmt::format("{:.3g} %", 100 * share) : "0 %";
}

// 1234567 as "1.23 M".
std::string Short(double count) {
  for (const char* unit : {"", " k", " M", " G"}) {
    if (count < 10'000 || unit == std::string(" G")) return fmt::format("{:.4g}{}", count, unit);
    count /= 1000;
  }
  return {};
}

}  // namespace

void SweepMethod::Apply(SolveOptions* options) const {
  if (solver) options->solver = *solver;
  if (balance) options->balance = *balance;
  if (distribution) options->distribution = *distribution;
}

Result<SweepMethod> ParseSweepMethod(const std::string& text) {
  SweepMethod method;
  method.name = text;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find('+', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const auto solver = ParseSolverMethod(word);
    const auto balance = ParseBalanceStrategy(word);
    const auto distribution = ParseDistribution(word);
    if (solver && !method.solver) {
      method.solver = *solver;
    } else if (balance && !method.balance) {
      method.balance = *balance;
    } else if (distribution && !method.distribution) {
      method.distribution = *distribution;
    } else {
      return Error(StatusCode::kInvalidArgument,
                   "method '{}': '{}' is none, or the second of its kind; a solver (cg, jacobi, "
                   "gauss-seidel, chebyshev, southwell), a balance strategy (none, rotate, "
                   "greedy-refine) or a distribution (octree, random, input, balanced), or one of "
                   "each joined by '+'",
                   text, word);
    }
    begin = end + 1;
  }
  return method;
}

std::optional<double> SweepRun::Ratio() const {
  return error_true > 0 ? std::optional(error_estimate / error_true) : std::nullopt;
}

std::optional<double> FitPower(std::span<const double> x, std::span<const double> y) {
  double n = 0, mean_x = 0, mean_y = 0, least = HUGE_VAL, most = 0;
  const auto usable = [&](size_t i) { return x[i] > 0 && y[i] > 0; };
  for (size_t i = 0; i < x.size(); ++i) {
    if (!usable(i)) continue;
    ++n;
    mean_x += std::log(x[i]);
    mean_y += std::log(y[i]);
    least = std::min(least, x[i]);
    most = std::max(most, x[i]);
  }
  if (n < 2 || most < kLeastSpan * least) return std::nullopt;
  mean_x /= n;
  mean_y /= n;
  double covariance = 0, variance = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    if (!usable(i)) continue;
    const double dx = std::log(x[i]) - mean_x;
    covariance += dx * (std::log(y[i]) - mean_y);
    variance += dx * dx;
  }
  return -covariance / variance;
}

std::vector<SweepSlopes> FitSlopes(const Sweep& sweep) {
  std::vector<SweepSlopes> slopes;
  for (const auto& runs : ByMethod(sweep)) {
    std::vector<double> error, seconds, links;
    for (const SweepRun* run : runs) {
      error.push_back(run->error_true);
      seconds.push_back(run->seconds);
      links.push_back(static_cast<double>(run->links));
    }
    slopes.push_back({runs.front()->method, FitPower(seconds, error), FitPower(links, error)});
  }
  return slopes;
}

std::string ToCsv(const Sweep& sweep) {
  std::string text =
      "method,accuracy,seconds,rounds,links,elements,rays,error_estimate,error_true,error_rms,"
      "error_p95,error_bias,ratio,bytes,memory_bytes,ended_by\n";
  for (const SweepRun& r : sweep.runs) {
    text += fmt::format("{},{},{:.4f},{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{},{},{}\n",
                        r.method, r.accuracy, r.seconds, r.rounds, r.links, r.elements, r.rays,
                        r.error_estimate, r.error_true, r.error_rms, r.error_p95, r.error_bias,
                        r.Ratio() ? fmt::format("{:.4g}", *r.Ratio()) : "", r.bytes, r.memory_bytes,
                        r.ended_by);
  }
  return text;
}

json ToJson(const Sweep& sweep) {
  const auto known = [](const std::optional<double>& value) {
    return value ? json(*value) : json();
  };
  json runs = json::array(), slopes = json::array();
  for (const SweepRun& r : sweep.runs) {
    runs.push_back({{"method", r.method},
                    {"accuracy", r.accuracy},
                    {"seconds", r.seconds},
                    {"rounds", r.rounds},
                    {"links", r.links},
                    {"elements", r.elements},
                    {"rays", r.rays},
                    {"error_estimate", r.error_estimate},
                    {"error_true", r.error_true},
                    {"error_rms", r.error_rms},
                    {"error_p95", r.error_p95},
                    {"error_bias", r.error_bias},
                    {"ratio", known(r.Ratio())},
                    {"bytes", r.bytes},
                    {"memory_bytes", r.memory_bytes},
                    {"ended_by", r.ended_by}});
  }
  for (const SweepSlopes& s : FitSlopes(sweep)) {
    slopes.push_back({{"method", s.method},
                      {"error_over_seconds", known(s.seconds)},
                      {"error_over_links", known(s.links)}});
  }
  return {{"scene", sweep.scene},
          {"workers", sweep.workers},
          {"reference",
           {{"description", sweep.reference},
            {"error_estimate", sweep.reference_error},
            {"points", sweep.points}}},
          {"runs", runs},
          {"slopes", slopes}};
}

std::string ToTable(const Sweep& sweep) {
  std::string text = fmt::format("{}, true error at {} points against {}\n", sweep.scene,
                                 sweep.points, sweep.reference);
  size_t width = 6;
  for (const SweepRun& r : sweep.runs) width = std::max(width, r.method.size());
  text += fmt::format("{:<{}}  {:>8} {:>9} {:>6} {:>8} {:>8} {:>8} {:>9} {:>9} {:>6} {:>8} {:>8}\n",
                      "method", width, "accuracy", "seconds", "rounds", "links", "elements", "rays",
                      "estimate", "true", "ratio", "rms", "p95");
  for (const SweepRun& r : sweep.runs) {
    text += fmt::format(
        "{:<{}}  {:>8} {:>9.2f} {:>6} {:>8} {:>8} {:>8} {:>9} {:>9} {:>6} {:>8} {:>8}{}\n",
        r.method, width, Percent(r.accuracy), r.seconds, r.rounds,
        Short(static_cast<double>(r.links)), Short(static_cast<double>(r.elements)),
        Short(static_cast<double>(r.rays)), Percent(r.error_estimate), Percent(r.error_true),
        r.Ratio() ? fmt::format("{:.2f}", *r.Ratio()) : "-", Percent(r.error_rms),
        Percent(r.error_p95),
        r.ended_by == ToText(EndReason::kAccuracy) ? "" : fmt::format("  {}", r.ended_by));
  }
  for (const SweepSlopes& s : FitSlopes(sweep)) {
    const auto power = [](const std::optional<double>& p) {
      return p ? fmt::format("^-{:.2f}", *p) : std::string("^? (too few runs that differ)");
    };
    text += fmt::format("{}: true error ∝ seconds{}, ∝ links{}\n", s.method, power(s.seconds),
                        power(s.links));
  }
  return text;
}

}  // namespace isolux
