// What accuracy costs: the runs of `isolux sweep`, what was measured of each, and how the error
// falls with time and links.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/output/comparison.h"
#include "common/scene/solve_options.h"
#include "common/util/status.h"

namespace isolux {

// A way of solving: a name of a solver, a balance strategy or a distribution, or several of them
// joined by '+', over the options that all runs share.
struct SweepMethod {
  std::string name = "default";
  std::optional<SolverMethod> solver;
  std::optional<BalanceStrategy> balance;
  std::optional<Distribution> distribution;

  void Apply(SolveOptions* options) const;
};
// "cg+rotate". Errors list what there is.
Result<SweepMethod> ParseSweepMethod(const std::string& text);

struct SweepRun {
  std::string method;
  double accuracy = 0;  // asked for
  double seconds = 0;   // wall, from the start of the job to the patch file
  uint64_t rounds = 0, links = 0, elements = 0, rays = 0;
  double error_estimate = 0;  // mean |ΔH| / mean H: what the run says,
  double error_true = 0;      //   and what was measured
  double error_rms = 0;       // measured, √(mean |ΔH|²) / mean H
  double error_p95 = 0;   // measured, 95th percentile of the local |ΔH| / max(H, 5 % of the mean)
  double error_bias = 0;  // measured, mean ΔH / mean H, signed
  uint64_t bytes = 0;     // between coordinator and workers, both ways
  uint64_t memory_bytes = 0;  // of links and nodes over all workers
  std::string ended_by;       // "accuracy reached", or the budget

  // Estimated over true error; nothing where the true one is 0.
  std::optional<double> Ratio() const;
};

// error_true ∝ seconds^-p ∝ links^-q over the runs of one method, by least squares of the
// logarithms; nothing where no two runs differ in them by a quarter.
struct SweepSlopes {
  std::string method;
  std::optional<double> seconds, links;  // p, q
};

struct Sweep {
  std::string scene;           // name of its file
  std::string reference;       // what the true error is measured by, in words
  double reference_error = 0;  // its own estimated error; 0: exact or unknown
  uint64_t points = 0;         // at which it is measured
  uint32_t workers = 0;
  std::vector<SweepRun> runs;  // method by method, accuracy by accuracy
};

// The exponent p of y ∝ x^-p.
std::optional<double> FitPower(std::span<const double> x, std::span<const double> y);
std::vector<SweepSlopes> FitSlopes(const Sweep& sweep);

std::string ToCsv(const Sweep& sweep);
nlohmann::json ToJson(const Sweep& sweep);
std::string ToTable(const Sweep& sweep);  // for people

}  // namespace isolux
