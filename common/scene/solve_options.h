// What a user asks of a solve, and what a round reports: the same names on the command line, in the
// protocol and in the report.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/effect_costs.h"
#include "common/scene/measured_effect.h"
#include "common/util/status.h"

namespace isolux {

enum class Distribution { kOctree, kRandom, kInput, kBalanced };
enum class BalanceStrategy { kNone, kRotate, kGreedyRefine };
// How B = E + ρH is solved in a round; all but the first are for study.
enum class SolverMethod { kConjugateGradients, kJacobi, kGaussSeidel, kChebyshev, kSouthwell };

struct SolveOptions {
  double accuracy = 0.02;         // mean |ΔH| / mean H asked for, in (0, 1]
  double max_seconds = 0;         // from the start of the job; 0: none
  uint64_t max_links = 0;         // over all workers; 0: none
  uint64_t max_memory_bytes = 0;  // of links and nodes over all workers; 0: none
  uint32_t max_rounds = 24;
  uint32_t cut_size = 256;     // nodes of the cut, at least 8 a worker where the scene has them
  uint32_t forced_splits = 0;  // cut nodes split after every round whatever their load (for tests)
  Distribution distribution = Distribution::kOctree;
  BalanceStrategy balance = BalanceStrategy::kGreedyRefine;
  double balance_threshold = 1.15;  // max/mean of the predicted load above which nodes migrate
  std::vector<double> epsilons;  // thresholds to use, W, one a round; empty: chosen by the schedule
  uint64_t seed = 1;             // of the sampling
  SolverMethod solver = SolverMethod::kConjugateGradients;
  std::string effects = "auto";  // what to simulate: see effects_choice.h

  Status Validate() const;
};

// One row a round: progress, log, report.
struct RoundSummary {
  uint32_t round = 0;              // from 1
  double epsilon = 0;              // power error below which a link is kept, W
  double error_estimate = 0;       // mean |ΔH| / mean H of the output
  double error_spread = 0;         // its parts: variation of sources within a link,
  double error_visibility = 0;     //   sampled visibility,
  double error_coupling = 0;       //   coupling factors,
  double error_solver = 0;         //   unfinished iteration, effects left out,
  double error_closure = 0;        //   rows that do not add up,
  double error_gather = 0;         //   rays and openings of the gather, at sampled leaves
  double error_interpolation = 0;  // of the output mesh: of the last round, once it is made
  // Light of whole regions that links missed and the gather found; known as late, and part of
  // error_estimate. Most of it is about `unseen_polygon` of the scene file.
  double error_unseen = 0;
  uint32_t unseen_polygon = 0;
  double error_rms = 0;  // √(mean |ΔH|²) / mean H
  // Local error |ΔH| / max(H, 5 % of the mean): what 95 % of the area are expected to be within,
  // and the largest expected of any element, which is that of surface `worst_surface`, path
  // `worst_path`, on `worst_polygon` of the scene file.
  double error_p95 = 0, error_worst = 0;
  uint32_t worst_polygon = 0, worst_surface = 0;
  uint64_t worst_path = 0;
  uint64_t elements = 0;                           // leaves of the hierarchy
  uint64_t links = 0;                              // kept, over all workers
  uint64_t evaluations = 0;                        // link evaluations in this round
  uint64_t proved_visible = 0, proved_hidden = 0;  // of them, without a ray
  uint64_t rays = 0;                               // shadow rays in this round
  uint32_t iterations = 0;                         // matrix products of the solver in this round
  double residual = 0;                             // residual power over emitted power
  double energy_imbalance =
      0;  // largest |emitted − absorbed − escaped| / emitted over the channels
  std::array<double, 3> emitted_w{}, absorbed_w{}, escaped_w{};
  std::array<double, 3> medium_w{};  // that the medium absorbs; 0 where there is none
  std::array<double, 3> glass_w{};   // that panes absorb or reflect, likewise
  // Elements whose couplings add up to far too much or little before closure: light leaks there, or
  // links are missing. And their share of the area.
  uint64_t leaks = 0;
  double leak_area = 0;
  double seconds = 0;  // wall, since the start of the job
  double refine_s = 0, exchange_s = 0, solve_s = 0, snapshot_s = 0,
         balance_s = 0;              // wall, this round
  std::vector<double> worker_cpu_s;  // CPU of each worker in this round
  double load_max_over_mean = 1;
  uint64_t bytes_in = 0, bytes_out = 0;  // of all workers in this round
  uint64_t migrated_nodes = 0, migrated_links = 0;
  uint64_t memory_bytes = 0;  // links and nodes over all workers
  // What gathering the output of this round would take, from a sample of leaves; 0: not sampled.
  uint64_t output_elements = 0, output_points = 0, output_rays = 0;
  double output_s = 0;  // wall
  double sample_s = 0;  // wall, of taking the sample
  // Links that become of one whose error is just above ε, measured in this round; 0: unknown.
  double links_per_split = 0;
  // Of the first round: what neglecting effects would cost, and which are left out for that. Where
  // some are, it is from a round before this one, which counts for nothing else.
  std::vector<MeasuredEffect> measured;
  EffectCosts costs;  // over all workers
};

// What became of a spectral band, and of a group of them (bands.h).
struct BandSummary {
  double emitted_w = 0, absorbed_w = 0, escaped_w = 0, medium_w = 0, glass_w = 0;
};
struct BandGroupSummary {
  std::vector<BandSummary> bands;  // from short to long
  double error_estimate = 0;       // mean |ΔH| / mean H of its bands together
  // The parts of it that the solution before the gather does not have: what of the error of groups
  // before comes with the light that fluorescence hands on, and light that links missed and the
  // gather found, most of it about `unseen_polygon` of the scene file.
  double error_handed_on = 0, error_unseen = 0;
  uint32_t unseen_polygon = 0;
  double irradiance_w = 0;  // ∫ H dA, over its bands
  uint32_t channels = 0;    // that it took: 1, where its bands differ in nothing, or 3
  uint32_t iterations = 0;  // matrix products
  double residual = 0, energy_imbalance = 0;  // as of a round
  double seconds = 0;                         // wall, gather included
};

// Why a solve ended.
enum class EndReason { kAccuracy, kSeconds, kLinks, kMemory, kRounds, kPrecision, kFinished };
const char* ToText(EndReason reason);  // "accuracy reached", "time budget used", ...

struct SolveSummary {
  std::vector<RoundSummary> rounds;
  EndReason end_reason = EndReason::kAccuracy;
  double seconds = 0;
  double gather_s = 0;               // wall
  std::vector<double> gather_cpu_s;  // CPU of each worker in the gather
  uint32_t workers = 0;
  uint64_t rays = 0;  // shadow rays of all rounds and the gather
  EffectCosts costs;  // likewise
  std::vector<BandGroupSummary> band_groups;
};

Result<Distribution> ParseDistribution(const std::string& text);  // octree|random|input|balanced
Result<BalanceStrategy> ParseBalanceStrategy(const std::string& text);  // none|rotate|greedy-refine
Result<SolverMethod> ParseSolverMethod(const std::string& text);
const char* ToText(SolverMethod method);  // cg|jacobi|gauss-seidel|chebyshev|southwell

}  // namespace isolux
