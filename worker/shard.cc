#include "worker/shard.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/hierarchy/effects/plan.h"
#include "common/util/stopwatch.h"
#include "worker/radiosity/absorbers.h"
#include "worker/radiosity/ambient.h"
#include "worker/radiosity/closure.h"
#include "worker/radiosity/effect_shares.h"
#include "worker/radiosity/energy.h"
#include "worker/radiosity/error_estimate.h"
#include "worker/radiosity/error_spread.h"
#include "worker/radiosity/escape.h"
#include "worker/radiosity/gather.h"
#include "worker/radiosity/given.h"
#include "worker/radiosity/leaf_records.h"
#include "worker/radiosity/leaks.h"
#include "worker/radiosity/link_counts.h"
#include "worker/radiosity/link_errors.h"
#include "worker/radiosity/link_migration.h"
#include "worker/radiosity/neglect.h"
#include "worker/radiosity/one_channel.h"
#include "worker/radiosity/pass_on.h"
#include "worker/radiosity/solver.h"

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
  std::unique_ptr<NodeSampler> sampler;
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
  double light_ray_s = 0;        // CPU time of a ray to a light, as the last round had it

  const Medium* medium_or_null() const { return medium ? &*medium : nullptr; }
  const Panes* panes_or_null() const { return panes ? &*panes : nullptr; }

  RefineScene refine_scene() const {
    const LinkProver* proofs = prover ? &*prover : nullptr;
    return {&rays,  sampler.get(),    options.seed,   plan.occlusion,
            proofs, medium_or_null(), panes_or_null()};
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
  Status AddErrors(const ActiveNodes& nodes, const LeafSystem& leaves, const SolverResult& solution,
                   const ErrorEstimate& errors, const ClosureSummary& closing, Exchange& exchange,
                   RoundReport& report) const;
  int EscapeRays(uint32_t node) const;
  std::vector<double> EscapeShares(const ActiveNodes& nodes) const;
  std::vector<RowMeasure> MeasureRows(const ActiveNodes& nodes,
                                      std::span<const double> escape) const;
};

Shard::Shard(std::shared_ptr<const Scene> scene, ThreadPool* pool)
    : impl_(std::make_unique<Impl>(std::move(scene), pool)) {}
Shard::~Shard() = default;

Status Shard::Start(const SolveOptions& options, const Assignment& assignment, uint32_t self,
                    std::span<const MeasuredEffect> measured) {
  impl_->options = options;
  ASSIGN_OR_RETURN(const EffectsChoice choice, ParseEffectsChoice(options.effects));
  EffectsTable effects = PlanEffects(impl_->hierarchy, options.accuracy, choice, measured);
  impl_->plan = effects.plan;
  impl_->to_measure = measured.empty() ? std::move(effects.to_measure) : std::vector<std::string>();
  RETURN_IF_ERROR(impl_->SetAbsorbers());
  impl_->lamps_w_m2.clear();
  for (const Surface& s : impl_->hierarchy.surfaces()) {
    impl_->lamps_w_m2.push_back(Sum(s.exitance));
  }
  impl_->lamps_w = Sum(impl_->hierarchy.emitted_w());
  if (impl_->plan.occlusion && !impl_->prover) impl_->prover.emplace(impl_->hierarchy);
  impl_->gatherer.reset();
  impl_->links = {};
  impl_->sampler = std::make_unique<NodeSampler>(impl_->tree);
  impl_->mirrors = impl_->plan.mirrors ? Mirrors(impl_->hierarchy, options.accuracy) : Mirrors();
  impl_->tree.SetMirrors(impl_->mirrors.empty() ? nullptr : &impl_->mirrors);
  impl_->sheets = TranslucentSheets(impl_->hierarchy, impl_->plan);
  impl_->fluorescence = Fluorescence(impl_->hierarchy, impl_->plan);
  impl_->tree.SetPassing(&impl_->sheets, &impl_->fluorescence);
  impl_->scout = ScoutEscapes(impl_->hierarchy, impl_->rays, impl_->mirrors, impl_->sheets,
                              options.accuracy, options.seed, impl_->pool);
  impl_->tree.SetComponents(impl_->scout.component);
  impl_->snapshot = AmbientSnapshot(impl_->hierarchy, impl_->scout, impl_->StartLights(),
                                    impl_->sheets, impl_->fluorescence);
  std::vector<uint32_t> moved;
  RETURN_IF_ERROR(impl_->tree.Install(impl_->snapshot, &moved));
  ASSIGN_OR_RETURN(Placement placement, Placement::Make(impl_->tree, assignment, self));
  impl_->placement = std::make_unique<Placement>(std::move(placement));
  return {};
}

Status Shard::Impl::SetAbsorbers() {
  medium = AbsorbingMedium(hierarchy.scene(), plan);
  panes = AbsorbingPanes(hierarchy.scene(), plan, hierarchy.extent_m());
  return CheckSolver(options.solver, medium.has_value(), panes.has_value());
}

Status Shard::Impl::TakeGroup(uint32_t group) {
  if (group >= BandGroupCount(scene->bands.size())) {
    return MakeStatus(StatusCode::kInvalidArgument, "the scene has no group of bands {}", group);
  }
  gatherer.reset();
  lights.reset();
  auto of_group = std::make_unique<const Scene>(SceneOfGroup(*scene, group));
  hierarchy.TakeOptics(*of_group);
  group_scene = std::move(of_group);
  plan = PlanGroup(hierarchy, plan);
  sheets = TranslucentSheets(hierarchy, plan);
  fluorescence = Fluorescence(hierarchy, plan);
  tree.SetPassing(&sheets, &fluorescence);
  RETURN_IF_ERROR(SetAbsorbers());
  MakeLights();
  return {};
}

void Shard::Impl::MakeLights() {
  lights.reset();
  const Scene& now = hierarchy.scene();
  if (now.lights.empty() && !now.sky.exists()) return;
  if (!plan.lights && !plan.sun && !plan.sky) return;
  lights.emplace(hierarchy, rays, mirrors, scout, plan, medium_or_null(), panes_or_null(),
                 options.accuracy, options.seed);
}

std::vector<GivenIrradiance> Shard::Impl::StartLights() {
  MakeLights();
  if (!lights) return {};
  std::vector<GivenIrradiance> given(hierarchy.surfaces().size());
  pool.For(given.size(), 64, [&](size_t begin, size_t end, int) {
    for (size_t s = begin; s < end; ++s) given[s] = lights->OverSurface(static_cast<uint32_t>(s));
  });
  return given;
}

Rgb Shard::EmittedPower() const {
  const Rgb lamps_w = impl_->hierarchy.emitted_w();
  return impl_->lights ? lamps_w + impl_->lights->power_w() : lamps_w;
}

Result<RoundReport> Shard::RunRound(double epsilon, double accuracy, Exchange& exchange) {
  RoundReport report;
  report.round = impl_->snapshot.round + 1;
  report.epsilon = epsilon;
  const Stopwatch whole(impl_->pool);
  RefineCounters counters;
  RETURN_IF_ERROR(impl_->Refine(epsilon, exchange, counters));
  AddRefineCosts(counters, whole.cpu_s(),
                 MeanRaySeconds(impl_->refine_scene(), impl_->tree, impl_->links, impl_->pool),
                 report.costs);
  std::vector<uint32_t> asked;
  if (impl_->lights) {
    const Stopwatch dividing(impl_->pool);
    ASSIGN_OR_RETURN(
        asked, DivideForLights(epsilon, *impl_->lights, impl_->tree, *impl_->placement, impl_->pool,
                               counters, [&exchange] { return exchange.Cancelled(); }));
    AddLightCosts(KindsOf(*impl_->scene, impl_->plan), counters.light_rays, dividing.cpu_s(),
                  report.costs);
  }
  report.refine_s = whole.wall_s();
  const double refine_cpu_s = whole.cpu_s();

  const Stopwatch subscribing(impl_->pool);
  ASSIGN_OR_RETURN(const ActiveNodes nodes,
                   Subscribe(impl_->tree, *impl_->placement, impl_->links, asked, exchange));
  report.exchange_s = subscribing.wall_s();

  const Stopwatch solving(impl_->pool);
  RETURN_IF_ERROR(impl_->Solve(nodes, accuracy, exchange, report));
  impl_->solved.round = report.round;
  impl_->solved.epsilon = epsilon;
  report.solve_s = solving.wall_s();
  CountLinks(impl_->tree, *impl_->placement, impl_->links, nodes, counters, refine_cpu_s,
             solving.cpu_s(), report);
  report.cpu_s = whole.cpu_s();
  return report;
}

Result<RoundReport> Shard::SolveGroup(uint32_t group, const Snapshot& start, double accuracy,
                                      Exchange& exchange) {
  RoundReport report;
  report.round = start.round;
  report.epsilon = start.epsilon;
  const Stopwatch whole(impl_->pool);
  RETURN_IF_ERROR(impl_->TakeGroup(group));
  RETURN_IF_ERROR(InstallSnapshot(start));
  const std::vector<uint32_t> asked = OwnLeaves(impl_->tree, *impl_->placement);
  ASSIGN_OR_RETURN(const ActiveNodes nodes,
                   Subscribe(impl_->tree, *impl_->placement, impl_->links, asked, exchange));
  RETURN_IF_ERROR(impl_->Solve(nodes, accuracy, exchange, report));
  impl_->solved.round = start.round;
  impl_->solved.epsilon = start.epsilon;
  report.solve_s = whole.wall_s();
  report.cpu_s = whole.cpu_s();
  return report;
}

Status Shard::ReplayRound(double epsilon, Exchange& exchange) {
  RefineCounters counters;
  return impl_->Refine(epsilon, exchange, counters);
}

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
    if (!mirrors.empty()) {
      const Surface& surface = tree.surface_of(node);
      leaves.specular.push_back(mirrors.ShareOf(surface.polygon, surface.side));
    }
    const uint32_t s = tree.node(node).id.surface;
    if (!sheets.empty()) leaves.transmittance.push_back(lanes(sheets.TransmittanceOf(s)));
    if (!fluorescence.empty()) leaves.reradiation.push_back(fluorescence.Of(s));
    start->push_back(lanes(record.irradiance));
    old_leaf->push_back(static_cast<uint32_t>(&record - snapshot.leaves.data()));
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
    const double tolerance = std::min(1e-3, 0.1 * accuracy);
    ASSIGN_OR_RETURN(closing, Close(product, leaves, rows, rows_may, tolerance, exchange));
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
  if (!scene->textures.empty()) times.maps_s = preparing.cpu_s();
  const std::vector<GivenIrradiance> given = FindGiven(nodes, report);
  for (const GivenIrradiance& from_lights : given) {
    const Rgb& h = from_lights.mean;
    leaves.given.push_back(Lanes{h.x, h.y, h.z, 0});
  }
  Product product(tree, *placement, links, nodes, pool, exchange);
  const std::vector<double> escape = EscapeShares(nodes);
  const std::vector<RowMeasure> rows = MeasureRows(nodes, escape);
  ClosureSummary closing;
  ASSIGN_OR_RETURN(SolverResult solution,
                   CloseAndSolve(product, leaves, start, rows, accuracy, exchange, closing, times));
  const RefineScene between = refine_scene();
  solution.neglected += plan.measured_error;
  RETURN_IF_ERROR(AddPassedLight(product, solution.irradiance, leaves));
  ASSIGN_OR_RETURN(
      const ErrorEstimate errors,
      EstimateError(product, tree, leaves, solution.irradiance, given,
                    group_scene ? Previous() : Previous{start, old_leaf, snapshot.round == 0},
                    solution, exchange));
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
  ASSIGN_OR_RETURN(
      const ErrorSpread spread,
      SpreadError(leaves, ids, solution.irradiance, errors, closing.off,
                  solution.largest_eigenvalue, hierarchy.clusters()[0].area_m2, exchange));
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

int Shard::Impl::EscapeRays(uint32_t node) const {
  const double power_w = tree.area_m2(node) * lamps_w_m2[tree.node(node).id.surface];
  return power_w > 0 ? EscapeRaysOf(power_w / lamps_w) : kEscapeRays;
}

std::vector<double> Shard::Impl::EscapeShares(const ActiveNodes& nodes) const {
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
                                                  record.escape, EscapeRays(node), options.seed);
    }
  });
  return shares;
}

std::vector<RowMeasure> Shard::Impl::MeasureRows(const ActiveNodes& nodes,
                                                 std::span<const double> escape) const {
  std::vector<RowMeasure> rows(escape.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    const NodeId& id = tree.node(nodes.leaves[i]).id;
    if (scout.closed[id.surface] != 0) continue;
    const double ray_count =
        id.is_surface() ? scout.rays[id.surface] : EscapeRays(nodes.leaves[i]) + kPriorRays;
    // By the share of the whole surface: a leaf whose rays all stay by chance is not more certain.
    rows[i] = {1 - escape[i], EscapeDeviation(scout.escape[id.surface], ray_count)};
  }
  return rows;
}

uint64_t Shard::memory_bytes() const {
  return (impl_->links.own.size() + impl_->links.crown.size()) * sizeof(Link) +
         impl_->tree.memory_bytes() + impl_->snapshot.leaves.size() * sizeof(LeafRecord);
}

ErrorHistogram Shard::CountErrors() const {
  return isolux::CountErrors(impl_->tree, *impl_->placement, impl_->links, impl_->pool);
}

Snapshot Shard::TakeSnapshot() const { return impl_->solved; }

Status Shard::InstallSnapshot(const Snapshot& snapshot) {
  impl_->gatherer.reset();
  impl_->snapshot = snapshot;
  std::vector<uint32_t> moved;
  RETURN_IF_ERROR(impl_->tree.Install(impl_->snapshot, &moved));
  for (std::vector<Link>* links : {&impl_->links.own, &impl_->links.crown}) {
    for (Link& link : *links) {
      link.p = moved[link.p];
      link.q = moved[link.q];
      if (link.p == kNoNode || link.q == kNoNode) {
        return {StatusCode::kDataLoss, "snapshot: it lacks the end of a link"};
      }
    }
    links->shrink_to_fit();
  }
  ASSIGN_OR_RETURN(Placement placement, Placement::Make(impl_->tree, impl_->placement->assignment(),
                                                        impl_->placement->self()));
  *impl_->placement = std::move(placement);
  return {};
}

Result<std::vector<MigrationParcel>> Shard::Reassign(const Assignment& next) {
  ASSIGN_OR_RETURN(Placement placement,
                   Placement::Make(impl_->tree, next, impl_->placement->self()));
  impl_->gatherer.reset();
  *impl_->placement = std::move(placement);
  return TakeLeaving(*impl_->placement, &impl_->links);
}

Status Shard::Absorb(const std::string& parcel_bytes) {
  impl_->gatherer.reset();
  return AbsorbParcel(parcel_bytes, impl_->tree, *impl_->placement, &impl_->links);
}

Result<GatherPart> Shard::Gather(const std::vector<NodeId>& elements,
                                 const std::vector<uint8_t>& corners, double accuracy) {
  const Stopwatch watch(impl_->pool);
  const GatherOptions options = GatherOptionsFor(accuracy, impl_->options.seed);
  if (!impl_->gatherer) {
    impl_->gatherer = std::make_unique<Gatherer>(
        impl_->tree, *impl_->placement, impl_->links, impl_->snapshot, impl_->rays,
        impl_->lights ? &*impl_->lights : nullptr, impl_->refine_scene());
  }
  ASSIGN_OR_RETURN(GatherPart part,
                   impl_->gatherer->AtCorners(elements, corners, options, impl_->pool));
  AddGatherCosts(watch.cpu_s(),
                 MeanRaySeconds(impl_->refine_scene(), impl_->tree, impl_->links, impl_->pool),
                 impl_->light_ray_s, part.costs);
  part.cpu_s = watch.cpu_s();
  part.wall_s = watch.wall_s();
  return part;
}

}  // namespace isolux
