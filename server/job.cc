#include "server/job.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "common/scene/forecast.h"
#include "server/balance.h"
#include "server/crew.h"
#include "server/job_output.h"
#include "server/job_report.h"
#include "server/link_budget.h"
#include "server/output_options.h"
#include "server/partition.h"
#include "server/relay_loop.h"
#include "server/schedule.h"
#include "server/snapshot_parts.h"
#include "server/survey.h"

namespace isolux {
namespace {

using Clock = std::chrono::steady_clock;

constexpr uint32_t kMostRestarts = 8;     // without a finished round between them
constexpr double kMemoryShare = 0.4;      // of this machine's memory, for links and nodes
constexpr double kProgressPeriodS = 0.1;  // between news of one stage

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Of options that were checked when the job was handed in.
EffectsTable Plan(const Hierarchy& hierarchy, const SolveOptions& options,
                  std::span<const MeasuredEffect> measured) {
  return PlanEffects(hierarchy, options.accuracy,
                     ParseEffectsChoice(options.effects).value_or(EffectsChoice{}), measured);
}

// Of a job that has rounds already.
std::vector<MeasuredEffect> MeasuredBefore(const JobInput& input) {
  if (input.snapshots.empty() || input.rounds.empty()) return {};
  return input.rounds.front().measured;
}

uint64_t DefaultMemoryShare() {
  const auto pages = static_cast<double>(sysconf(_SC_PHYS_PAGES));
  const auto page_bytes = static_cast<double>(sysconf(_SC_PAGE_SIZE));
  return static_cast<uint64_t>(kMemoryShare * pages * page_bytes);
}

}  // namespace

struct JobRunner::Impl {
  Impl(JobInput input_in, JobCallbacks callbacks_in, JobLimits limits_in)
      : input(std::move(input_in)),
        callbacks(std::move(callbacks_in)),
        limits(std::move(limits_in)),
        hierarchy(*input.scene),
        measured(MeasuredBefore(input)),
        effects(Plan(hierarchy, input.options, measured)) {
    if (limits.memory_share_bytes == 0) limits.memory_share_bytes = DefaultMemoryShare();
    const size_t known = std::min(input.snapshots.size(), input.rounds.size());
    for (size_t k = 0; k < known; ++k) {
      snapshots.push_back(std::make_shared<const std::string>(Encode(input.snapshots[k])));
    }
    if (known > 0) snapshot = std::move(input.snapshots[known - 1]);
    input.snapshots.clear();
    summary.rounds.assign(input.rounds.begin(),
                          input.rounds.begin() + static_cast<std::ptrdiff_t>(known));
    announced = known;
  }

  Result<SolveResult> Run();
  Result<PatchFile> RunEpoch();
  Status Assemble();
  Status Start();
  Status Replay();
  Status RunRound(const ScheduleDecision& decision);
  Status Revise(const std::vector<MeasuredEffect>& found);
  Status TakeSnapshot(uint32_t round, double epsilon);
  Status Survey();
  Status Rebalance(const CutLoads& loads, RoundSummary* row);
  Status Migrate(const BalancePlan& plan, RoundSummary* row);
  void Release(const std::vector<bool>& staying);
  ScheduleInput SoFar() const;
  ScheduleDecision Decide() const { return DecideNext(SoFar()); }
  OutputMeshOptions OutputOptions() const {
    return OutputOptionsOf(summary.rounds.back(), input.options, hierarchy, effects.plan,
                           snapshot.leaves.size(), limits.output);
  }
  OutputMeshOptions FinalOutputOptions() const;
  void Announce();
  Status LookForUnseen();
  Result<PatchFile> MakeOutput();
  void Tell(JobProgress::Stage stage, uint32_t iterations = 0, uint64_t gathered = 0,
            uint32_t group = 0);
  double Seconds() const { return input.seconds_before + SecondsSince(started); }
  bool Finish() const { return callbacks.finish && callbacks.finish(); }

  const Clock::time_point started = Clock::now();  // first: what follows takes its time too
  JobInput input;
  JobCallbacks callbacks;
  JobLimits limits;
  const Hierarchy hierarchy;
  std::vector<MeasuredEffect> measured;  // by the first round
  EffectsTable effects;
  Traffic traffic;
  Clock::time_point told = started;
  std::optional<JobProgress> last_told;
  uint32_t own_epochs = 0;

  // Of the job, whoever works on it: what a restart goes on from.
  std::vector<std::shared_ptr<const std::string>> snapshots;  // S_1 … S_k, encoded
  Snapshot snapshot;                                          // S_k
  SolveSummary summary;
  size_t announced = 0;      // rounds given to on_round
  ErrorHistogram histogram;  // of the links as they are
  std::optional<ScheduleDecision> next;

  // Of the epoch.
  std::unique_ptr<Crew> crew;
  std::unique_ptr<JobOutput> output;  // once the rounds have stopped
  Assignment assignment;
  std::map<NodeId, uint64_t> links_before;  // of nodes of the cut, a round ago
  double emitted_w = 0;
  bool everyone_left = false;  // drained
  bool revised = false;        // the plan: the workers are to start anew

  std::set<uint64_t> gone;  // connections that were lost or released
  uint32_t restarts = 0;    // since the last finished round
};

JobRunner::JobRunner(JobInput input, JobCallbacks callbacks, JobLimits limits)
    : impl_(std::make_unique<Impl>(std::move(input), std::move(callbacks), std::move(limits))) {}
JobRunner::~JobRunner() = default;
Result<SolveResult> JobRunner::Run() { return impl_->Run(); }
const Traffic& JobRunner::traffic() const { return impl_->traffic; }

Result<SolveResult> JobRunner::Impl::Run() {
  while (true) {
    Result<PatchFile> patch = RunEpoch();
    if (patch.has_value()) {
      crew->Dismiss(MessageKind::kEndJob, input.job);
      summary.seconds = Seconds();
      patch->comments = MakeComments(
          {input.name, *input.scene, input.scene_hash, input.options, effects}, summary, traffic);
      return SolveResult{std::move(*patch), summary};
    }
    if (crew != nullptr && crew->loss()) {
      const WorkerSlot slot = crew->slot(crew->loss()->worker);
      const Status why = crew->loss()->why;
      gone.insert(slot.id);
      slot.port->Close(why);
      if (callbacks.on_lost) callbacks.on_lost(slot, why);
      if (++restarts <= kMostRestarts) continue;
      crew->Dismiss(MessageKind::kCancelJob, input.job);
      return Error(StatusCode::kAborted, "{} workers were lost in round {}, the last one {}: {}",
                   restarts, summary.rounds.size() + 1, slot.name, why.message());
    }
    if (std::exchange(everyone_left, false) || std::exchange(revised, false)) continue;
    if (crew != nullptr) crew->Dismiss(MessageKind::kCancelJob, input.job);
    return tl::unexpected<Status>(patch.error());
  }
}

// From the start of a membership to the end of the job, or until somebody is lost.
Result<PatchFile> JobRunner::Impl::RunEpoch() {
  RETURN_IF_ERROR(Assemble());
  RETURN_IF_ERROR(Start());
  RETURN_IF_ERROR(Replay());
  while (true) {
    if (!next) next = Decide();
    if (Finish() && !summary.rounds.empty() && !next->stop) {
      next = ScheduleDecision{true, EndReason::kFinished, 0, 0};
    }
    if (next->stop) RETURN_IF_ERROR(LookForUnseen());
    if (next->stop) break;
    RETURN_IF_ERROR(RunRound(*next));
  }
  summary.end_reason = next->reason;
  return MakeOutput();
}

// What a time budget has left goes into rays at points.
OutputMeshOptions JobRunner::Impl::FinalOutputOptions() const {
  OutputMeshOptions options = OutputOptions();
  options.point_accuracy = PointAccuracyWithin(TimeForGather(SoFar()), options.accuracy);
  return options;
}

// Gathers the sources of the output, which may show that the rounds are to go on.
Status JobRunner::Impl::LookForUnseen() {
  Tell(JobProgress::Stage::kGathering);
  RoundSummary& last = summary.rounds.back();
  output = std::make_unique<JobOutput>(*crew, hierarchy, effects.plan, snapshot,
                                       FinalOutputOptions(), limits.gather_batch);
  RETURN_IF_ERROR(output->GatherSources(&last));
  next = Decide();
  if (next->stop) return {};
  RETURN_IF_ERROR(output->Drop(*snapshots.back(), &last));
  output.reset();
  if (callbacks.on_round) callbacks.on_round(last);
  return {};
}

Result<PatchFile> JobRunner::Impl::MakeOutput() {
  OutputNews news;
  news.gathering = [this](uint64_t gathered) { Tell(JobProgress::Stage::kGathering, 0, gathered); };
  news.bands = [this](uint32_t group, uint32_t products, uint64_t gathered) {
    Tell(JobProgress::Stage::kBands, products, gathered, group + 1);
  };
  return output->Make(assignment, input.options.accuracy, news, &summary);
}

Status JobRunner::Impl::Assemble() {
  output.reset();
  crew.reset();
  std::vector<WorkerSlot> workers =
      callbacks.workers ? callbacks.workers() : std::vector<WorkerSlot>{};
  std::erase_if(workers, [this](const WorkerSlot& slot) { return gone.contains(slot.id); });
  if (workers.empty()) return {StatusCode::kUnavailable, "no workers are connected"};
  if (workers.size() > kMaxWorkers) workers.resize(kMaxWorkers);
  const uint32_t epoch = callbacks.next_epoch ? callbacks.next_epoch() : ++own_epochs;
  crew = std::make_unique<Crew>(std::move(workers), epoch, limits, &traffic, callbacks.cancelled);
  assignment = Partition(hierarchy, input.options, crew->size());
  links_before.clear();
  return {};
}

Status JobRunner::Impl::Start() {
  Tell(JobProgress::Stage::kStarting);
  StartJob start{input.job, input.scene_hash, input.options, assignment, 0, measured};
  for (uint32_t w = 0; w < crew->size(); ++w) {
    start.self = w;
    RETURN_IF_ERROR(crew->Send(w, MessageKind::kStartJob, Encode(start)));
  }
  std::optional<Started> first;
  const auto take = [&](uint32_t worker, const Message& message) -> Result<bool> {
    if (message.kind == static_cast<uint32_t>(MessageKind::kNeedScene)) {
      RETURN_IF_ERROR(crew->Send(worker, MessageKind::kSceneData,
                                 Encode(SceneData{input.scene_hash, *input.encoded_scene})));
      return false;
    }
    if (message.kind != static_cast<uint32_t>(MessageKind::kStarted)) {
      return Error(StatusCode::kInternal, "{} instead of Started",
                   ToText(static_cast<MessageKind>(message.kind)));
    }
    ASSIGN_OR_RETURN(const Started started_now, DecodeMessage<Started>(message.payload));
    if (first && first->emitted_w != started_now.emitted_w) {
      return Error(StatusCode::kInternal, "it finds another emitted power in the same scene");
    }
    first = started_now;
    return true;
  };
  RETURN_IF_ERROR(crew->Collect(limits.start_lease_s, take));
  emitted_w = first->emitted_w[0] + first->emitted_w[1] + first->emitted_w[2];
  if (emitted_w > 0 && std::isfinite(emitted_w)) return {};
  return MakeStatus(StatusCode::kInvalidArgument, "the scene emits {} W", emitted_w);
}

// Makes the links of the rounds that are known already, which depend on nothing but their
// thresholds and snapshots.
Status JobRunner::Impl::Replay() {
  for (size_t k = 0; k < summary.rounds.size(); ++k) {
    Tell(JobProgress::Stage::kReplaying, static_cast<uint32_t>(k));
    const RoundSummary& row = summary.rounds[k];
    RETURN_IF_ERROR(crew->SendAll(
        MessageKind::kRound, RoundCommand{row.round, row.epsilon, input.options.accuracy, true}));
    RETURN_IF_ERROR(RelayUntil(*crew, assignment, MessageKind::kReplayed, {}));
    RETURN_IF_ERROR(crew->SendAll(MessageKind::kInstallSnapshot, SnapshotData{*snapshots[k]}));
  }
  if (summary.rounds.empty()) return {};
  if (!next) RETURN_IF_ERROR(Survey());
  // The loads of nodes are unknown here; their leaves are not.
  CutLoads loads;
  for (const NodeId& node : assignment.cut) {
    const uint64_t leaves = CountLeaves(hierarchy, snapshot, node);
    loads.cost.push_back(static_cast<double>(leaves));
    loads.links.push_back(leaves);
    loads.elements.push_back(leaves);
  }
  RoundSummary unused;
  RETURN_IF_ERROR(Rebalance(loads, &unused));
  links_before.clear();
  Announce();
  return {};
}

Status JobRunner::Impl::RunRound(const ScheduleDecision& decision) {
  const auto round = static_cast<uint32_t>(summary.rounds.size() + 1);
  const PhaseBytes before = traffic.Total();
  Tell(JobProgress::Stage::kRefining);
  RETURN_IF_ERROR(crew->SendAll(MessageKind::kRound,
                                RoundCommand{round, decision.epsilon, decision.accuracy, false}));
  const auto news = [this](const CollectiveNews& so_far) {
    Tell(so_far.subscribed ? JobProgress::Stage::kSolving : JobProgress::Stage::kRefining,
         so_far.products);
  };
  ASSIGN_OR_RETURN(const auto messages,
                   RelayUntil(*crew, assignment, MessageKind::kRoundReport, news));
  PerWorker<RoundReport> reports(messages.size());
  for (size_t w = 0; w < messages.size(); ++w) {
    if (!messages[w]) continue;
    ASSIGN_OR_RETURN(reports[w], DecodeMessage<RoundReport>(messages[w]->payload));
  }
  ASSIGN_OR_RETURN(RoundSummary row, MergeReports(reports, round));
  ASSIGN_OR_RETURN(const CutLoads loads, MergeLoads(reports, assignment));
  if (round == 1) {
    RETURN_IF_ERROR(Revise(row.measured));
    row.measured = measured;
  }

  const Clock::time_point snapshot_start = Clock::now();
  RETURN_IF_ERROR(TakeSnapshot(round, decision.epsilon));
  row.snapshot_s = SecondsSince(snapshot_start);
  row.seconds = Seconds();
  const double power = round > 1 ? -RunFit(summary.rounds).links().slope : 1;
  row.links_per_split = MeasureLinksPerSplit(histogram, row.epsilon, row.links, power);
  // From here on the round is done, whatever happens.
  restarts = 0;
  summary.rounds.push_back(row);
  next.reset();
  RETURN_IF_ERROR(Survey());

  const Clock::time_point balance_start = Clock::now();
  Status balanced = Rebalance(loads, &summary.rounds.back());
  RoundSummary& done = summary.rounds.back();
  done.balance_s = SecondsSince(balance_start);
  const PhaseBytes after = traffic.Total();
  done.bytes_in = after.in - before.in;
  done.bytes_out = after.out - before.out;
  Announce();
  return balanced;
}

// Decides again once the first round has measured what neglecting effects costs. Where one is left
// out for it, what was done so far is dropped. Not more than once: who starts with what was
// measured measures nothing.
Status JobRunner::Impl::Revise(const std::vector<MeasuredEffect>& found) {
  if (found.empty()) return {};
  measured = found;
  effects = Plan(hierarchy, input.options, measured);
  revised = NoteDecisions(effects, &measured);
  if (!revised) return {};
  next.reset();
  return {StatusCode::kUnavailable, "the first round leaves out what was simulated"};
}

Status JobRunner::Impl::TakeSnapshot(uint32_t round, double epsilon) {
  Tell(JobProgress::Stage::kSnapshot);
  ASSIGN_OR_RETURN(
      Snapshot merged,
      CollectSnapshot(*crew, static_cast<uint32_t>(hierarchy.surfaces().size()), round, epsilon));
  if (callbacks.on_snapshot) RETURN_IF_ERROR(callbacks.on_snapshot(merged));
  auto encoded = std::make_shared<const std::string>(Encode(merged));
  RETURN_IF_ERROR(crew->SendAll(MessageKind::kInstallSnapshot, SnapshotData{*encoded}));
  snapshot = std::move(merged);
  snapshots.push_back(std::move(encoded));
  return {};
}

// Completes the last round's row and decides what follows.
Status JobRunner::Impl::Survey() {
  const Clock::time_point start = Clock::now();
  ASSIGN_OR_RETURN(const LinkErrors errors, CountLinkErrors(*crew));
  histogram = errors.histogram;
  RoundSummary& row = summary.rounds.back();
  // After a loss or a restart it may be there.
  if (row.output_elements == 0) {
    row.memory_bytes += errors.memory_bytes;
    const Surface& worst = hierarchy.surfaces()[row.worst_surface % hierarchy.surfaces().size()];
    row.worst_polygon = hierarchy.scene().polygons[worst.polygon].file_polygon;
    RETURN_IF_ERROR(
        SampleGather(*crew, hierarchy, snapshot, OutputOptions(), input.options.seed, &row));
    if (effects.plan.bands) {  // each group of them solves, and gathers all that
      const uint32_t groups = BandGroupCount(input.scene->bands.size());
      row.output_s += groups * (row.output_s + row.solve_s);
      row.output_rays *= 1 + groups;
    }
    row.sample_s = SecondsSince(start);
  }
  next = Decide();
  return {};
}

Status JobRunner::Impl::Rebalance(const CutLoads& loads, RoundSummary* row) {
  Tell(JobProgress::Stage::kBalancing);
  BalanceInput balance;
  balance.assignment = assignment;
  balance.load =
      PredictLoads(LoadEstimator::kMeasured, assignment, loads, links_before, hierarchy, snapshot);
  balance.links = loads.links;
  for (uint32_t w = 0; w < crew->size(); ++w) {
    balance.available.push_back(crew->present(w) && !crew->draining(w));
  }
  balance.strategy = input.options.balance;
  balance.threshold = input.options.balance_threshold;
  balance.forced_splits = input.options.forced_splits;
  balance.most_nodes = CutTarget(input.options, crew->present_count());
  links_before.clear();
  for (size_t i = 0; i < assignment.cut.size(); ++i) {
    links_before[assignment.cut[i]] = loads.links[i];
  }
  if (std::ranges::count(balance.available, true) == 0) {
    // All that they hold can be made again from the snapshots.
    everyone_left = true;
    Release(balance.available);
    return {StatusCode::kUnavailable, "all workers have left"};
  }
  const BalancePlan plan = Balance(balance, MakeSplitFunction(hierarchy, snapshot));
  if (plan.assignment != assignment) RETURN_IF_ERROR(Migrate(plan, row));
  // Not one who has said only now, while nodes were moving, that it would like to leave.
  Release(balance.available);
  return {};
}

Status JobRunner::Impl::Migrate(const BalancePlan& plan, RoundSummary* row) {
  RETURN_IF_ERROR(crew->SendAll(MessageKind::kReassign, Reassign{plan.assignment}));
  ASSIGN_OR_RETURN(const auto messages, crew->CollectAll(MessageKind::kParcels));
  std::vector<Absorb> absorb(crew->size());
  for (const auto& message : messages) {
    if (!message) continue;
    ASSIGN_OR_RETURN(Parcels parcels, DecodeMessage<Parcels>(message->payload));
    for (MigrationParcel& parcel : parcels.parcels) {
      if (parcel.to >= crew->size()) {
        return MakeStatus(StatusCode::kInternal, "a parcel for worker {} of {}", parcel.to,
                          crew->size());
      }
      // Links of the crown go to everybody, and need not go to who has left.
      if (!crew->present(parcel.to)) continue;
      row->migrated_links += parcel.links;
      absorb[parcel.to].parcels.push_back(std::move(parcel.bytes));
    }
  }
  for (uint32_t w = 0; w < crew->size(); ++w) {
    if (!crew->present(w) || absorb[w].parcels.empty()) continue;
    RETURN_IF_ERROR(crew->Send(w, MessageKind::kAbsorb, Encode(absorb[w])));
  }
  row->migrated_nodes += plan.moved;
  assignment = plan.assignment;
  return {};
}

void JobRunner::Impl::Release(const std::vector<bool>& staying) {
  for (uint32_t w = 0; w < crew->size(); ++w) {
    if (!crew->present(w) || staying[w]) continue;
    crew->Release(w);
    gone.insert(crew->slot(w).id);
    if (callbacks.on_released) callbacks.on_released(crew->slot(w));
  }
}

ScheduleInput JobRunner::Impl::SoFar() const {
  ScheduleInput schedule;
  schedule.options = input.options;
  schedule.emitted_w = emitted_w;
  schedule.amplification = AmplificationIn(hierarchy);
  schedule.rounds = summary.rounds;
  schedule.histogram = histogram;
  schedule.seconds = Seconds();
  schedule.memory_limit_bytes = limits.memory_share_bytes;
  schedule.finish = Finish();
  return schedule;
}

void JobRunner::Impl::Announce() {
  for (; announced < summary.rounds.size(); ++announced) {
    if (callbacks.on_round) callbacks.on_round(summary.rounds[announced]);
  }
}

void JobRunner::Impl::Tell(JobProgress::Stage stage, uint32_t iterations, uint64_t gathered,
                           uint32_t group) {
  if (!callbacks.on_progress) return;
  const bool first = !last_told || stage != last_told->stage || group != last_told->group;
  if (!first && SecondsSince(told) < kProgressPeriodS) return;
  told = Clock::now();
  JobProgress now;
  now.stage = stage;
  now.round = static_cast<uint32_t>(summary.rounds.size() + 1);
  now.iterations = iterations;
  now.epsilon = next ? next->epsilon : 0;
  now.seconds = Seconds();
  now.gathered = gathered;
  now.group = group;
  now.groups = BandGroupCount(input.scene->bands.size());
  now.workers = crew != nullptr ? crew->present_count() : 0;
  last_told = now;
  callbacks.on_progress(now);
}

}  // namespace isolux
