#include "server/latest.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/effects/plan.h"
#include "server/job_report.h"
#include "server/output_mesh.h"

namespace isolux {
namespace {

// Mean distance of an even slope from its mean, over its range.
constexpr double kOffOverRange = 0.25;

// What the error of leaves becomes where nothing is gathered, and the sum of it over all.
double AddVariation(const Hierarchy& hierarchy, Snapshot* snapshot) {
  double off = 0, arriving = 0;
  for (LeafRecord& leaf : snapshot->leaves) {
    double sum = 0, largest = 0;
    for (const double channel : leaf.irradiance) {
      sum += channel;
      largest = std::max(largest, channel);
    }
    if (!(sum > 0)) continue;
    // Both as of all channels; the worst one has its share of the light.
    const double share = largest / sum;
    const double error = std::hypot(leaf.error / share, kOffOverRange * leaf.spread);
    leaf.error = static_cast<float>(share * error);
    const double area = std::ldexp(hierarchy.surface_area_m2(leaf.id.surface), -leaf.id.level());
    off += area * error;
    arriving += area * sum;
  }
  return arriving > 0 ? off / arriving : 0;
}

}  // namespace

Result<PatchFile> BuildLatest(const Scene& scene, const Snapshot& newest, const JobInfo& job) {
  const Hierarchy hierarchy(scene);
  Snapshot snapshot = newest;
  const double error = AddVariation(hierarchy, &snapshot);
  const EffectsTable effects =
      PlanEffects(hierarchy, job.options.accuracy,
                  ParseEffectsChoice(job.options.effects).value_or(EffectsChoice{}),
                  job.summary.rounds.front().measured);
  OutputMeshOptions options;
  options.sheets = TranslucentSheets(hierarchy, effects.plan);
  options.fluorescence = Fluorescence(hierarchy, effects.plan);
  options.waves = 1;
  options.further_waves = 0;
  const auto constants = [&](const std::vector<NodeId>& elements,
                             const std::vector<uint8_t>&) -> Result<std::vector<double>> {
    std::vector<double> values;
    values.reserve(12 * elements.size());
    for (const NodeId& id : elements) {
      const auto leaf = std::lower_bound(
          snapshot.leaves.begin(), snapshot.leaves.end(), id,
          [](const LeafRecord& record, const NodeId& wanted) { return record.id < wanted; });
      for (int corner = 0; corner < 4; ++corner) {
        values.insert(values.end(), leaf->irradiance.begin(), leaf->irradiance.end());
      }
    }
    return values;
  };
  ASSIGN_OR_RETURN(OutputMesh mesh, BuildOutputMesh(hierarchy, snapshot, options, constants));
  PatchFile& patch = mesh.patch;

  SolveSummary summary = job.summary;
  const RoundSummary& last = summary.rounds.back();
  summary.seconds = last.seconds;
  summary.workers = job.activity.workers;
  summary.rays = 0;
  for (const RoundSummary& row : summary.rounds) summary.rays += row.rays;
  summary.costs = TotalCosts(summary.rounds, {});
  patch.comments =
      MakeComments({job.name, scene, job.digest, job.options, effects}, summary, Traffic());
  std::erase_if(patch.comments, [](const auto& comment) {
    return comment.first == "traffic" || comment.first.starts_with("gather_");
  });
  for (auto& [key, value] : patch.comments) {
    if (key == "end_reason") value = fmt::format("not ended: the state after round {}", last.round);
    if (key == "error_estimate") value = fmt::format("{}", std::max(error, last.error_estimate));
  }
  patch.comments.emplace_back("latest_round", fmt::format("{}", last.round));
  patch.comments.emplace_back("gathered", "no: means of the leaves");
  patch.comments.emplace_back("error_estimate_gathered", fmt::format("{}", last.error_estimate));
  if (effects.plan.bands) {
    patch.comments.emplace_back(
        "bands_left_out",
        fmt::format("{}: they come with the job's end; red, green and blue here are solved for as "
                    "channels, by the means of what materials reflect in their bands",
                    scene.bands.size()));
  }
  return std::move(patch);
}

}  // namespace isolux
