// What a shard holds, and the steps of its rounds: shard.cc drives them, shard_solve.cc solves.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "common/scene/effects_plan.h"
#include "worker/radiosity/closure.h"
#include "worker/radiosity/effect_shares.h"
#include "worker/radiosity/error_estimate.h"
#include "worker/radiosity/escape.h"
#include "worker/radiosity/gather.h"
#include "worker/radiosity/given.h"
#include "worker/radiosity/solver.h"
#include "worker/shard.h"

namespace isolux {

struct Shard::Impl {
  Impl(std::shared_ptr<const Scene> scene_in, ThreadPool* pool_in)
      : scene(std::move(scene_in)),
        pool(*pool_in),
        hierarchy(*scene),
        rays(hierarchy),
        tree(hierarchy) {}

  std::shared_ptr<const Scene> scene;
  std::unique_ptr<const Scene> group_scene;  // of the bands that are solved for; null: none yet
  ThreadPool& pool;
  Hierarchy hierarchy;
  RayScene rays;
  Tree tree;
  SolveOptions options;
  EffectsPlan plan;
  std::vector<std::string> to_measure;  // effects, in the first round
  std::optional<LinkProver> prover;
  std::unique_ptr<Placement> placement;
  std::optional<LightField> lights;  // where the scene has some and the plan wants them
  LinkSet links;
  Snapshot snapshot;                   // installed last
  Snapshot solved;                     // own leaves of the round just run
  std::unique_ptr<Gatherer> gatherer;  // of the installed snapshot, made when first asked for
  Scout scout;
  // What surfaces emit, and all of them together, over the channels: bands look for escapes alike.
  std::vector<double> lamps_w_m2;
  double lamps_w = 0;
  Mirrors mirrors;               // that are simulated
  TranslucentSheets sheets;      // likewise
  Fluorescence fluorescence;     // likewise
  std::optional<Medium> medium;  // likewise
  std::optional<Panes> panes;    // likewise
  // CPU time of a ray to a light, as the last round had it, and of one to a source of the gatherer.
  double light_ray_s = 0, gather_ray_s = 0;

  const Medium* medium_or_null() const { return medium ? &*medium : nullptr; }
  const Panes* panes_or_null() const { return panes ? &*panes : nullptr; }

  RefineScene refine_scene() const {
    const LinkProver* proofs = prover ? &*prover : nullptr;
    return {&rays, options.seed, plan.occlusion, proofs, medium_or_null(), panes_or_null()};
  }
  Status SetAbsorbers();
  // Puts a group of bands in the place of the channels, in all but the tree's values.
  Status TakeGroup(uint32_t group);
  void MakeLights();
  // What lights bring to each surface; empty where there are none.
  std::vector<GivenIrradiance> StartLights();
  Status Refine(double epsilon, Exchange& exchange, RefineCounters& counters) {
    gatherer.reset();
    return isolux::Refine(epsilon, refine_scene(), tree, *placement, pool, links, counters,
                          [&exchange] { return exchange.Cancelled(); });
  }

  const LeafRecord& RecordAbove(uint32_t node) const;
  LeafSystem MakeLeafSystem(const ActiveNodes& nodes, std::vector<Lanes>* start,
                            std::vector<uint32_t>* old_leaf) const;
  // What lights bring to these leaves; nothing where there are none.
  std::vector<GivenIrradiance> FindGiven(const ActiveNodes& nodes, RoundReport& report);
  Status Solve(const ActiveNodes& nodes, double accuracy, Exchange& exchange, RoundReport& report);
  Result<SolverResult> CloseAndSolve(Product& product, LeafSystem& leaves,
                                     std::span<const Lanes> start, std::span<const RowMeasure> rows,
                                     double accuracy, Exchange& exchange, ClosureSummary& closing,
                                     SolveTimes& times) const;
  template <typename V>
  Result<SolverResultOf<V>> SolveLeaves(Product& product, const LeafSystemOf<V>& leaves,
                                        std::type_identity_t<std::span<const V>> start,
                                        double accuracy, Exchange& exchange) const;
  Status Measure(const LeafSystem& leaves, const SolverResult& solution,
                 const ErrorEstimate& errors, Product& product, Exchange& exchange,
                 RoundReport& report) const;
  // Of rooms that hardly lose light: what errors of links do to all of it.
  Status AddPassedOnErrors(Product& product, const LeafSystem& leaves, const SolverResult& solution,
                           Exchange& exchange, ErrorEstimate* errors) const;
  Status AddErrors(const ActiveNodes& nodes, const LeafSystem& leaves, const SolverResult& solution,
                   const ErrorEstimate& errors, const ClosureSummary& closing, Exchange& exchange,
                   RoundReport& report) const;
  // By own leaf: how many rays tell what escapes of its light.
  std::vector<int> EscapeRays(const ActiveNodes& nodes, const LeafSystem& leaves) const;
  std::vector<double> EscapeShares(const ActiveNodes& nodes, std::span<const int> ray_counts) const;
  std::vector<RowMeasure> MeasureRows(const ActiveNodes& nodes, std::span<const double> escape,
                                      std::span<const int> ray_counts) const;
};

}  // namespace isolux
