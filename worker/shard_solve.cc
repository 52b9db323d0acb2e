// The solution of a round, or of a group of bands: rows, closure, solver, and what the report says.
#include <algorithm>
#include <cmath>

#include "common/util/stopwatch.h"
#include "worker/radiosity/absorbers.h"
#include "worker/radiosity/energy.h"
#include "worker/radiosity/error_draw.h"
#include "worker/radiosity/error_spread.h"
#include "worker/radiosity/leaf_records.h"
#include "worker/radiosity/leaks.h"
#include "worker/radiosity/neglect.h"
#include "worker/radiosity/one_channel.h"
#include "worker/radiosity/pass_on.h"
#include "worker/shard_state.h"

namespace isolux {

// The record of the leaf of the installed snapshot that is `node` or lies above it.
const LeafRecord& Shard::Impl::RecordAbove(uint32_t node) const {
  const size_t installed = tree.installed();
  while (node >= installed) node = tree.node(node).parent;
  return snapshot.leaves[tree.first_leaf(node)];
}

LeafSystem Shard::Impl::MakeLeafSystem(const ActiveNodes& nodes, std::vector<Lanes>* start,
                                       std::vector<uint32_t>* old_leaf) const {
  LeafSystem leaves;
  for (const uint32_t node : nodes.leaves) {
    const Optics optics = hierarchy.maps().Over(tree.surface_of(node), tree.polygon(node));
    const LeafRecord& record = RecordAbove(node);
    const auto lanes = [](const auto& v) { return Lanes{v[0], v[1], v[2], 0}; };
    leaves.area_m2.push_back(tree.area_m2(node));
    leaves.reflectance.push_back(lanes(optics.reflectance));
    leaves.exitance.push_back(lanes(optics.exitance));
    // Anew every round: of many factors that close the rows those nearest to 1 are right, and rows
    // of the first rounds lead far from them.
    leaves.closure.push_back(1.0);
    leaves.inheritance.push_back(1.0);
    leaves.returned.push_back(0.0);
    if (!mirrors.empty()) {
      const Surface& surface = tree.surface_of(node);
      leaves.specular.push_back(mirrors.ShareOf(surface.polygon, surface.side));
    }
    const uint32_t s = tree.node(node).id.surface;
    if (!sheets.empty()) leaves.transmittance.push_back(lanes(sheets.TransmittanceOf(s)));
    if (!fluorescence.empty()) leaves.reradiation.push_back(fluorescence.Of(s));
    start->push_back(lanes(record.irradiance));
    old_leaf->push_back(static_cast<uint32_t>(&record - snapshot.leaves.data()));
    if (!snapshot.handed_on.empty()) {
      leaves.exitance.back() += lanes(snapshot.handed_on[old_leaf->back()].radiosity);
    }
  }
  return leaves;
}

template <typename V>
Result<SolverResultOf<V>> Shard::Impl::SolveLeaves(Product& product, const LeafSystemOf<V>& leaves,
                                                   std::type_identity_t<std::span<const V>> start,
                                                   double accuracy, Exchange& exchange) const {
  LinkTransportOf<V> transport(product, leaves);
  const auto reflect = [&](const LeafSystemOf<V>& sources, std::span<const V> from, double to) {
    return plan.interreflection ? isolux::Solve<V>(options.solver, transport, sources, from,
                                                   SolverOptionsOf<V>{.accuracy = to}, exchange)
                                : SolveDirect<V>(transport, sources, exchange);
  };
  const SolveFunction<V> solve = [&](const auto& sources, auto from, double to) {
    return SolveWithGiven<V>(sources, from, to, reflect);
  };
  return SolveWithPassedLight<V>(product, leaves, start, accuracy, solve, exchange);
}

std::vector<GivenIrradiance> Shard::Impl::FindGiven(const ActiveNodes& nodes, RoundReport& report) {
  if (!lights) return {};
  const Stopwatch watch(pool);
  std::vector<GivenIrradiance> given = GivenTo(nodes.leaves, tree, *lights, pool);
  LightRays cast;
  for (const GivenIrradiance& from_lights : given) cast += from_lights.rays;
  report.rays += cast.Total();
  const double cpu_s = watch.cpu_s();
  light_ray_s = cast.Total() > 0 ? cpu_s / static_cast<double>(cast.Total()) : 0;
  AddLightCosts(KindsOf(*scene, plan), cast, cpu_s, report.costs);
  return given;
}

Result<SolverResult> Shard::Impl::CloseAndSolve(Product& product, LeafSystem& leaves,
                                                std::span<const Lanes> start,
                                                std::span<const RowMeasure> rows, double accuracy,
                                                Exchange& exchange, ClosureSummary& closing,
                                                SolveTimes& times) const {
  const RefineScene between = refine_scene();
  const auto close = [&](RowsMay rows_may) -> Status {
    const Stopwatch watch(pool);
    const ClosureTolerance tolerance{.row = std::min(1e-3, 0.1 * accuracy),
                                     .black = 0.25 * accuracy};
    ASSIGN_OR_RETURN(closing, Close(product, leaves, start, rows, rows_may, tolerance, exchange));
    times.closure_s += watch.cpu_s();
    times.closure_products += closing.products;
    return {};
  };
  const auto solve = [&]() -> Result<SolverResult> {
    const Stopwatch factors(pool);
    product.SetMedium(medium_or_null());
    times.medium_s += medium ? factors.cpu_s() : 0;
    const Stopwatch of_panes(pool);
    product.SetPanes(&between);
    times.panes_s += panes ? of_panes.cpu_s() : 0;
    const Stopwatch watch(pool);
    Result<SolverResult> solution = SolverResult();
    if (plan.channels == 3) {
      solution = SolveLeaves<Lanes>(product, leaves, start, accuracy, exchange);
    } else {
      ASSIGN_OR_RETURN(const auto grey,
                       SolveLeaves<Single>(product, ToOneChannel(leaves, plan),
                                           ToOneChannel(start, plan), accuracy, exchange));
      solution = InColour(grey, plan);
    }
    times.solver_s += watch.cpu_s();
    return solution;
  };
  if (plan.closure) RETURN_IF_ERROR(close(RowsMay::kRiseAndFall));
  ASSIGN_OR_RETURN(SolverResult solution, solve());
  if (solution.indefinite && plan.closure) {
    // Some rows could not be brought down while others were brought up: bring down alone.
    product.SetMedium(nullptr);
    product.SetPanes(nullptr);
    RETURN_IF_ERROR(close(RowsMay::kFall));
    ASSIGN_OR_RETURN(solution, solve());
  }
  return solution;
}

Status Shard::Impl::Solve(const ActiveNodes& nodes, double accuracy, Exchange& exchange,
                          RoundReport& report) {
  SolveTimes times;
  const Stopwatch preparing(pool);
  std::vector<Lanes> start;
  std::vector<uint32_t> old_leaf;
  LeafSystem leaves = MakeLeafSystem(nodes, &start, &old_leaf);
  if (plan.textures) times.maps_s = preparing.cpu_s();
  const std::vector<GivenIrradiance> given = FindGiven(nodes, report);
  for (const GivenIrradiance& from_lights : given) {
    const Rgb& h = from_lights.mean;
    leaves.given.push_back(Lanes{h.x, h.y, h.z, 0});
  }
  Product product(tree, *placement, links, nodes, pool, exchange);
  const std::vector<int> ray_counts = EscapeRays(nodes, leaves);
  const std::vector<double> escape = EscapeShares(nodes, ray_counts);
  const std::vector<RowMeasure> rows = MeasureRows(nodes, escape, ray_counts);
  ClosureSummary closing;
  ASSIGN_OR_RETURN(SolverResult solution,
                   CloseAndSolve(product, leaves, start, rows, accuracy, exchange, closing, times));
  const RefineScene between = refine_scene();
  solution.neglected += plan.measured_error;
  RETURN_IF_ERROR(AddPassedLight(product, solution.irradiance, leaves));
  ASSIGN_OR_RETURN(
      ErrorEstimate errors,
      EstimateError(
          product, tree, leaves, solution.irradiance,
          plan.closure ? std::span<const RowMeasure>(rows) : std::span<const RowMeasure>(), given,
          group_scene ? Previous()
                      : Previous{start, old_leaf, snapshot.round == 0,
                                 snapshot.epsilon / std::max(report.epsilon, 1e-300)},
          solution, exchange));
  RETURN_IF_ERROR(AddPassedOnErrors(product, leaves, solution, exchange, &errors));
  const Stopwatch absorbing(pool);
  RETURN_IF_ERROR(AddAbsorbedPower(between, leaves, solution.irradiance, plan.interreflection,
                                   product, exchange, report));
  if (between.panes != nullptr) times.panes_s += absorbing.cpu_s();
  if (between.panes == nullptr && between.medium != nullptr) times.medium_s += absorbing.cpu_s();
  times.solver_products = solution.products;
  times.again = solution.again;
  times.mirrors = ShareThroughMirrors(links);
  AddSolveCosts(times, plan, !sheets.empty(), !fluorescence.empty(), report.costs);
  RETURN_IF_ERROR(AddEnergy(leaves, solution.irradiance, escape, exchange, report));
  report.residual = solution.residual;
  report.iterations = closing.products + solution.products;
  ASSIGN_OR_RETURN(report.leaks, CountLeaks(leaves, solution.irradiance, closing.bend,
                                            hierarchy.clusters()[0].area_m2, exchange));
  report.memory_bytes = product.memory_bytes();
  solved.leaves = RecordLeaves(tree, nodes.leaves, leaves, solution.irradiance, errors, escape);
  if (snapshot.round == 0 && !to_measure.empty()) {
    RETURN_IF_ERROR(Measure(leaves, solution, errors, product, exchange, report));
  }
  return AddErrors(nodes, leaves, solution, errors, closing, exchange, report);
}

Status Shard::Impl::AddPassedOnErrors(Product& product, const LeafSystem& leaves,
                                      const SolverResult& solution, Exchange& exchange,
                                      ErrorEstimate* errors) const {
  const bool passes_on = plan.interreflection && solution.largest_eigenvalue > kPassesOnErrors &&
                         leaves.transmittance.empty() && leaves.reradiation.empty();
  if (!passes_on) return {};
  const SolveFunction<Lanes> solve = [&](const auto& sources, auto from, double to) {
    return SolveLeaves<Lanes>(product, sources, from, to, exchange);
  };
  ASSIGN_OR_RETURN(const double passed_on,
                   DrawError(product, tree, leaves, solution.irradiance, solve, exchange));
  errors->total = std::hypot(errors->total, passed_on);
  errors->visibility = std::hypot(errors->visibility, passed_on);
  return {};
}

Status Shard::Impl::Measure(const LeafSystem& leaves, const SolverResult& solution,
                            const ErrorEstimate& errors, Product& product, Exchange& exchange,
                            RoundReport& report) const {
  const SolveFunction<Single> solve = [&](const auto& sources, auto from, double to) {
    return SolveLeaves<Single>(product, sources, from, to, exchange);
  };
  ASSIGN_OR_RETURN(report.measured,
                   MeasureNeglect(to_measure, hierarchy, leaves, solution.irradiance, errors,
                                  report, product, solve, exchange));
  return {};
}

Status Shard::Impl::AddErrors(const ActiveNodes& nodes, const LeafSystem& leaves,
                              const SolverResult& solution, const ErrorEstimate& errors,
                              const ClosureSummary& closing, Exchange& exchange,
                              RoundReport& report) const {
  std::vector<NodeId> ids;
  for (const uint32_t node : nodes.leaves) ids.push_back(tree.node(node).id);
  ClosureSummary rows = closing;
  for (size_t i = 0; i < rows.misplaced.size(); ++i) {
    rows.misplaced[i] += scout.unseen_openings[ids[i].surface];
  }
  ASSIGN_OR_RETURN(
      const ErrorSpread spread,
      SpreadError(leaves, ids, solution.irradiance, errors, rows, solution.largest_eigenvalue,
                  hierarchy.clusters()[0].area_m2, exchange));
  report.error_estimate = spread.total;
  report.error_rms = spread.rms;
  report.error_closure = spread.closure;
  report.local_errors = spread.local;
  report.error_spread = errors.spread;
  report.error_visibility = errors.visibility;
  report.error_coupling = errors.coupling;
  report.error_solver = errors.solver;
  return {};
}

std::vector<int> Shard::Impl::EscapeRays(const ActiveNodes& nodes, const LeafSystem& leaves) const {
  std::vector<int> counts(leaves.size(), kEscapeRays);
  const double all_w = lamps_w + (lights ? Sum(lights->power_w()) : 0.0);
  for (size_t i = 0; i < counts.size(); ++i) {
    double power_w_m2 = lamps_w_m2[tree.node(nodes.leaves[i]).id.surface];
    if (!leaves.given.empty()) {
      const Lanes reflected = leaves.reflectance[i] * leaves.given[i];
      power_w_m2 += reflected[0] + reflected[1] + reflected[2];
    }
    if (power_w_m2 > 0) counts[i] = EscapeRaysOf(leaves.area_m2[i] * power_w_m2 / all_w);
  }
  return counts;
}

std::vector<double> Shard::Impl::EscapeShares(const ActiveNodes& nodes,
                                              std::span<const int> ray_counts) const {
  std::vector<double> shares(nodes.leaves.size(), 0);
  pool.For(shares.size(), 64, [&](size_t begin, size_t end, int) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t node = nodes.leaves[i];
      const NodeId& id = tree.node(node).id;
      if (scout.closed[id.surface] != 0) continue;
      const LeafRecord& record = RecordAbove(node);
      // Seeded by the id, so a leaf's share never changes while it is one.
      shares[i] = id.is_surface()   ? scout.escape[id.surface]
                  : record.id == id ? record.escape
                                    : EscapeShare(hierarchy, rays, mirrors, id, tree.polygon(node),
                                                  record.escape, ray_counts[i], options.seed);
    }
  });
  return shares;
}

std::vector<RowMeasure> Shard::Impl::MeasureRows(const ActiveNodes& nodes,
                                                 std::span<const double> escape,
                                                 std::span<const int> ray_counts) const {
  std::vector<RowMeasure> rows(escape.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    const NodeId& id = tree.node(nodes.leaves[i]).id;
    // Where nothing is seen to leave, nothing is taken to: see unseen_openings.
    const bool none_leaves = escape[i] == 0 && scout.unseen_openings[id.surface] > 0;
    if (scout.closed[id.surface] != 0 || none_leaves) continue;
    const double ray_count = id.is_surface() ? scout.rays[id.surface] : ray_counts[i] + kPriorRays;
    // By the share of the whole surface: a leaf whose rays all stay by chance is not more certain.
    rows[i] = {1 - escape[i], EscapeDeviation(scout.escape[id.surface], ray_count)};
  }
  return rows;
}

}  // namespace isolux
