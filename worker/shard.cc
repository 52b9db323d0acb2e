#include "worker/shard.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/effects/plan.h"
#include "common/util/stopwatch.h"
#include "worker/radiosity/absorbers.h"
#include "worker/radiosity/ambient.h"
#include "worker/radiosity/link_counts.h"
#include "worker/radiosity/link_errors.h"
#include "worker/radiosity/link_migration.h"
#include "worker/shard_state.h"

namespace isolux {

Shard::Shard(std::shared_ptr<const Scene> scene, ThreadPool* pool)
    : impl_(std::make_unique<Impl>(std::move(scene), pool)) {}
Shard::~Shard() = default;

Status Shard::Start(const SolveOptions& options, const Assignment& assignment, uint32_t self,
                    std::span<const MeasuredEffect> measured) {
  impl_->options = options;
  ASSIGN_OR_RETURN(const EffectsChoice choice, ParseEffectsChoice(options.effects));
  EffectsTable effects = PlanEffects(impl_->hierarchy, options.accuracy, choice, measured);
  impl_->plan = effects.plan;
  impl_->hierarchy.FollowTextures(effects.plan.textures);
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
  plan = PlanGroup(hierarchy, *scene, group, plan);
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
    impl_->gather_ray_s =
        MeanRaySeconds(impl_->refine_scene(), impl_->tree, impl_->links, impl_->pool);
  }
  ASSIGN_OR_RETURN(GatherPart part,
                   impl_->gatherer->AtCorners(elements, corners, options, impl_->pool));
  AddGatherCosts(watch.cpu_s(), impl_->gather_ray_s, impl_->light_ray_s, part.costs);
  part.cpu_s = watch.cpu_s();
  part.wall_s = watch.wall_s();
  return part;
}

}  // namespace isolux
