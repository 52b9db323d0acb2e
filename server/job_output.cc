#include "server/job_output.h"

#include <utility>

#include "server/job_report.h"
#include "server/source_gather.h"

namespace isolux {

JobOutput::JobOutput(Crew& crew, const Hierarchy& hierarchy, const EffectsPlan& plan,
                     const Snapshot& snapshot, OutputMeshOptions options, uint32_t batch)
    : crew_(crew),
      hierarchy_(hierarchy),
      plan_(plan),
      snapshot_(snapshot),
      options_(std::move(options)),
      waves_(crew, options_.point_accuracy, batch) {}

double JobOutput::Seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

Status JobOutput::GatherSources(RoundSummary* row) {
  if (!HasGatheredSources(plan_, options_)) return {};
  ASSIGN_OR_RETURN(const UnseenLight unseen,
                   isolux::GatherSources(crew_, hierarchy_, snapshot_, options_, waves_));
  row->error_unseen = unseen.error;
  row->unseen_polygon = unseen.polygon;
  return {};
}

Status JobOutput::Drop(const std::string& encoded_snapshot, RoundSummary* row) {
  row->rays += waves_.rays();
  row->costs.Add(waves_.costs());
  for (size_t w = 0; w < std::min(row->worker_cpu_s.size(), waves_.cpu_s().size()); ++w) {
    row->worker_cpu_s[w] += waves_.cpu_s()[w];
  }
  row->sample_s += Seconds();
  return crew_.SendAll(MessageKind::kInstallSnapshot, SnapshotData{encoded_snapshot});
}

Result<PatchFile> JobOutput::Make(const Assignment& assignment, double accuracy,
                                  const OutputNews& news, SolveSummary* summary) {
  const auto gather = [&](const std::vector<NodeId>& elements,
                          const std::vector<uint8_t>& corners) {
    return waves_.Gather(elements, corners, news.gathering);
  };
  ASSIGN_OR_RETURN(OutputMesh mesh, BuildOutputMesh(hierarchy_, snapshot_, options_, gather));
  SolveSummary done = *summary;
  RoundSummary& last = done.rounds.back();
  AddOutputErrors(mesh.interpolation_error, &last);
  if (plan_.bands) {
    RETURN_IF_ERROR(SolveBands(crew_, assignment,
                               {hierarchy_, snapshot_, plan_, options_, accuracy, last.emitted_w},
                               waves_, news.bands, &mesh, &done));
  }
  done.gather_s = Seconds();
  done.gather_cpu_s = waves_.cpu_s();
  done.workers = crew_.present_count();
  done.rays = waves_.rays();
  for (const RoundSummary& row : done.rounds) done.rays += row.rays;
  done.costs = TotalCosts(done.rounds, waves_.costs());
  *summary = std::move(done);
  return std::move(mesh.patch);
}

}  // namespace isolux
