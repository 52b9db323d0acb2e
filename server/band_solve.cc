#include "server/band_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/hierarchy/effects/plan.h"
#include "common/util/exact_sum.h"
#include "server/handed_on.h"
#include "server/job_report.h"
#include "server/relay_loop.h"
#include "server/snapshot_parts.h"
#include "server/source_gather.h"

namespace isolux {
namespace {

double SumOf(const std::array<double, 3>& h) { return h[0] + h[1] + h[2]; }

// ∫ H dA over all leaves and the channels, W.
double ArrivingPower(const Hierarchy& hierarchy, const Snapshot& snapshot) {
  ExactSum sum;
  for (const LeafRecord& leaf : snapshot.leaves) {
    sum.Add(std::ldexp(hierarchy.surface_area_m2(leaf.id.surface), -leaf.id.level()) *
            SumOf(leaf.irradiance));
  }
  return sum.Value();
}

// Of each vertex one that it is on: all of them reflect and emit alike.
std::vector<uint32_t> SurfacesOfVertices(const PatchFile& patch) {
  std::vector<uint32_t> surfaces(patch.vertices.size(), 0);
  for (const PatchFace& face : patch.faces) {
    for (const uint32_t v : face.vertices) surfaces[v] = face.surface;
  }
  return surfaces;
}

std::vector<uint32_t> SurfacesOfFaces(const PatchFile& patch) {
  std::vector<uint32_t> surfaces;
  for (const PatchFace& face : patch.faces) surfaces.push_back(face.surface);
  return surfaces;
}

// One group.
class Group {
 public:
  Group(const BandsInput& input, uint32_t number, HandedOn handed)
      : input_(input),
        bands_(input.hierarchy.scene().bands),
        number_(number),
        handed_(std::move(handed)),
        scene_(SceneOfGroup(input.hierarchy.scene(), number)),
        hierarchy_(input.hierarchy),
        output_(input.output) {
    hierarchy_.TakeOptics(scene_);
    output_.sheets = TranslucentSheets(hierarchy_, input.plan);
    output_.fluorescence = Fluorescence(hierarchy_, input.plan);
    output_.keep_points = false;
  }

  // Nothing emits in it.
  bool is_dark() const { return !Emits(scene_) && !(Sum(handed_.power_w) > 0); }

  // Its snapshot, which is then that of the workers too.
  Result<Snapshot> Solve(Crew& crew, const Assignment& assignment, const BandNews& news,
                         BandGroupSummary* summary) const {
    RETURN_IF_ERROR(crew.SendAll(MessageKind::kSolveGroup,
                                 SolveGroup{number_, input_.accuracy, Encode(Start())}));
    const auto solving = [&](const CollectiveNews& so_far) { news(number_, so_far.products, 0); };
    ASSIGN_OR_RETURN(const auto messages,
                     RelayUntil(crew, assignment, MessageKind::kRoundReport, solving));
    PerWorker<RoundReport> reports(messages.size());
    for (size_t w = 0; w < messages.size(); ++w) {
      if (!messages[w]) continue;
      ASSIGN_OR_RETURN(reports[w], DecodeMessage<RoundReport>(messages[w]->payload));
    }
    ASSIGN_OR_RETURN(const RoundSummary row, MergeReports(reports, input_.snapshot.round));
    ASSIGN_OR_RETURN(Snapshot snapshot,
                     CollectSnapshot(crew, static_cast<uint32_t>(hierarchy_.surfaces().size()),
                                     input_.snapshot.round, input_.snapshot.epsilon));
    snapshot.handed_on = handed_.of_leaves;
    RETURN_IF_ERROR(crew.SendAll(MessageKind::kInstallSnapshot, SnapshotData{Encode(snapshot)}));
    Summarize(row, snapshot, summary);
    return snapshot;
  }

  // Gathered at the points of the mesh.
  Result<PatchFile> Gather(Crew& crew, const Snapshot& snapshot, const OutputMesh& mesh,
                           GatherWaves& waves, const BandNews& news,
                           BandGroupSummary* summary) const {
    if (HasGatheredSources(input_.plan, output_)) {
      ASSIGN_OR_RETURN(const UnseenLight unseen,
                       GatherSources(crew, hierarchy_, snapshot, output_, waves));
      summary->error_unseen = unseen.error;
      summary->unseen_polygon = unseen.polygon;
      summary->error_estimate = std::hypot(summary->error_estimate, unseen.error);
    }
    const uint64_t before = waves.gathered();
    return BuildAgain(
        mesh, hierarchy_, snapshot, output_,
        [&](const std::vector<NodeId>& elements, const std::vector<uint8_t>& corners) {
          return waves.Gather(elements, corners,
                              [&](uint64_t gathered) { news(number_, 0, gathered - before); });
        });
  }

  // Into the bands of the mesh, with what fluorescence adds there of those before.
  void Put(const PatchFile& of_group, const HandingOn& handing, PatchFile* patch) const {
    const size_t n = bands_.size();
    const auto put = [&](const auto& items, BandValues* to) {
      for (size_t i = 0; i < items.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
          const uint32_t band = BandInChannel(n, number_, c);
          if (band >= n) continue;
          to->values[2 * n * i + band] = items[i].radiosity[c];
          to->values[2 * n * i + n + band] = items[i].irradiance[c];
        }
      }
    };
    put(of_group.vertices, &patch->vertex_bands);
    put(of_group.faces, &patch->face_bands);
    if (handed_.empty()) return;
    AddHandedOn(SurfacesOfVertices(*patch), handing, &patch->vertex_bands);
    AddHandedOn(SurfacesOfFaces(*patch), handing, &patch->face_bands);
  }

  // What of the light's error comes with what is handed on, of the mean irradiance.
  double handed_error(const std::vector<BandSummary>& bands) const {
    double emitted_w = 0;
    for (const BandSummary& band : bands) emitted_w += band.emitted_w;
    return emitted_w > 0 ? handed_.error_w / emitted_w : 0;
  }

 private:
  // The last round's irradiance, by what is emitted in a band of what is in its channel.
  Snapshot Start() const {
    std::array<int, 3> from{};
    std::array<double, 3> share{};
    Rgb reradiated_w = handed_.power_w;
    for (int c = 2; c >= 0; --c) {  // from short to long
      const uint32_t band = BandInChannel(bands_.size(), number_, c);
      if (band >= bands_.size()) continue;
      from[c] = bands_[band].channel();
      const double channel_w = input_.hierarchy.emitted_w()[from[c]];
      share[c] =
          channel_w > 0 ? hierarchy_.emitted_w()[c] / channel_w : ShareOfChannel(bands_, band);
      const double with_all_w = input_.emitted_w[from[c]];
      if (reradiated_w[c] > 0 && with_all_w > 0) share[c] += reradiated_w[c] / with_all_w;
      reradiated_w += ReradiatedOf(c, from[c], share[c]);
    }
    Snapshot start = input_.snapshot;
    start.handed_on = handed_.of_leaves;
    for (LeafRecord& leaf : start.leaves) {
      const std::array<double, 3> channels = leaf.irradiance;
      for (int c = 0; c < 3; ++c) leaf.irradiance[c] = share[c] * channels[from[c]];
      const double whole = SumOf(channels);
      const auto scale = static_cast<float>(whole > 0 ? SumOf(leaf.irradiance) / whole : 0);
      leaf.spread *= scale;
      leaf.error *= scale;
      leaf.doubt *= scale;
    }
    return start;
  }

  void AddHandedOn(std::span<const uint32_t> surfaces, const HandingOn& handing,
                   BandValues* to) const {
    const size_t n = bands_.size();
    for (size_t i = 0; i < surfaces.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const uint32_t band = BandInChannel(n, number_, c);
        if (band >= n) continue;
        to->values[2 * n * i + band] +=
            static_cast<float>(handing.Radiosity(surfaces[i], band, to->Irradiance(i, n)));
      }
    }
  }

  // W by channel that fluorescence makes within the group of this share of a channel's irradiance.
  Rgb ReradiatedOf(int c, int from, double share) const {
    Rgb sum_w(0.0);
    if (output_.fluorescence.empty()) return sum_w;
    for (const LeafRecord& leaf : input_.snapshot.leaves) {
      Rgb irradiance(0.0);
      irradiance[c] = share * leaf.irradiance[from];
      sum_w += std::ldexp(hierarchy_.surface_area_m2(leaf.id.surface), -leaf.id.level()) *
               output_.fluorescence.Of(leaf.id.surface).Of(irradiance);
    }
    return sum_w;
  }

  void Summarize(const RoundSummary& row, const Snapshot& snapshot,
                 BandGroupSummary* summary) const {
    summary->irradiance_w = ArrivingPower(hierarchy_, snapshot);
    const Scene& whole = input_.hierarchy.scene();
    summary->channels =
        static_cast<uint32_t>(PlanGroup(hierarchy_, whole, number_, input_.plan).channels);
    summary->iterations = row.iterations;
    summary->residual = row.residual;
    summary->energy_imbalance = row.energy_imbalance;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t band = BandInChannel(bands_.size(), number_, static_cast<int>(c));
      if (band >= bands_.size()) continue;
      summary->bands[band - kBandsOfGroup * number_] = {
          row.emitted_w[c], row.absorbed_w[c], row.escaped_w[c], row.medium_w[c], row.glass_w[c]};
    }
    summary->error_handed_on = handed_error(summary->bands);
    summary->error_estimate = row.error_estimate + summary->error_handed_on;
  }

  const BandsInput& input_;
  const std::vector<Band>& bands_;
  const uint32_t number_;
  const HandedOn handed_;
  const Scene scene_;
  Hierarchy hierarchy_;
  OutputMeshOptions output_;
};

// Of a face, over the channels; handed_on: of its irradiance, beyond what it states.
double TotalError(const PatchFace& face, double handed_on) {
  const auto& h = face.irradiance;
  const double sum = double{h[0]} + h[1] + h[2];
  const double largest = std::max({h[0], h[1], h[2]});
  return largest > 0 ? face.error * sum / largest + handed_on * sum : 0.0;
}

// What the channels are of the bands: their sums. `error`: of each face over all bands.
void SumUp(const std::vector<double>& error, PatchFile* patch) {
  const auto sum = [&](std::span<const float> bands, std::array<float, 3>* channels) {
    std::array<double, 3> sums{};
    for (size_t b = 0; b < bands.size(); ++b) {
      sums[static_cast<size_t>(patch->bands[b].channel())] += bands[b];
    }
    for (size_t c = 0; c < 3; ++c) (*channels)[c] = static_cast<float>(sums[c]);
  };
  const size_t n = patch->bands.size();
  for (size_t v = 0; v < patch->vertices.size(); ++v) {
    sum(patch->vertex_bands.Radiosity(v, n), &patch->vertices[v].radiosity);
    sum(patch->vertex_bands.Irradiance(v, n), &patch->vertices[v].irradiance);
  }
  for (size_t f = 0; f < patch->faces.size(); ++f) {
    PatchFace& face = patch->faces[f];
    sum(patch->face_bands.Radiosity(f, n), &face.radiosity);
    sum(patch->face_bands.Irradiance(f, n), &face.irradiance);
    // Of the error over all channels the worst has its share of the light.
    const auto& h = face.irradiance;
    const double whole = double{h[0]} + h[1] + h[2];
    face.error =
        static_cast<float>(whole > 0 ? error[f] * std::max({h[0], h[1], h[2]}) / whole : 0.0);
  }
}

// Of an error of groups, by the light that arrives.
double MeanOf(const std::vector<BandGroupSummary>& groups, double BandGroupSummary::*error) {
  double off_w = 0, arriving_w = 0;
  for (const BandGroupSummary& group : groups) {
    off_w += group.*error * group.irradiance_w;
    arriving_w += group.irradiance_w;
  }
  return arriving_w > 0 ? off_w / arriving_w : 0;
}

void AddToLastRound(const std::vector<Band>& bands, SolveSummary* summary) {
  RoundSummary& last = summary->rounds.back();
  last.error_estimate = std::max(
      last.error_estimate, std::hypot(ErrorOfAll(summary->band_groups), last.error_interpolation));
  const double mean_unseen = MeanOf(summary->band_groups, &BandGroupSummary::error_unseen);
  if (mean_unseen > last.error_unseen) {
    last.error_unseen = mean_unseen;
    last.unseen_polygon = std::ranges::max_element(summary->band_groups, {}, [](const auto& group) {
                            return group.error_unseen * group.irradiance_w;
                          })->unseen_polygon;
  }
  last.emitted_w = last.absorbed_w = last.escaped_w = last.medium_w = last.glass_w = {};
  size_t next = 0;
  for (const BandGroupSummary& group : summary->band_groups) {
    last.residual = std::max(last.residual, group.residual);
    last.energy_imbalance = std::max(last.energy_imbalance, group.energy_imbalance);
    for (const BandSummary& band : group.bands) {
      const auto c = static_cast<size_t>(bands[next++].channel());
      last.emitted_w[c] += band.emitted_w;
      last.absorbed_w[c] += band.absorbed_w;
      last.escaped_w[c] += band.escaped_w;
      last.medium_w[c] += band.medium_w;
      last.glass_w[c] += band.glass_w;
    }
  }
}

}  // namespace

double ErrorOfAll(const std::vector<BandGroupSummary>& groups) {
  return MeanOf(groups, &BandGroupSummary::error_estimate);
}

Status SolveBands(Crew& crew, const Assignment& assignment, const BandsInput& input,
                  GatherWaves& waves, const BandNews& news, OutputMesh* mesh,
                  SolveSummary* summary) {
  const std::vector<Band>& bands = input.hierarchy.scene().bands;
  PatchFile& patch = mesh->patch;
  patch.bands = bands;
  patch.vertex_bands.values.assign(2 * bands.size() * patch.vertices.size(), 0.0F);
  patch.face_bands.values.assign(2 * bands.size() * patch.faces.size(), 0.0F);
  std::vector<double> error(patch.faces.size(), 0.0);
  summary->band_groups.clear();
  HandingOn handing(input.hierarchy, input.snapshot, input.plan);
  for (uint32_t number = 0; number < BandGroupCount(bands.size()); ++number) {
    const auto start = std::chrono::steady_clock::now();
    BandGroupSummary& row = summary->band_groups.emplace_back();
    row.bands.resize(std::min<size_t>(kBandsOfGroup, bands.size() - kBandsOfGroup * number));
    const Group group(input, number, handing.ToNext());
    if (group.is_dark()) {
      handing.TakeNothing();
      continue;
    }
    news(number, 0, 0);
    ASSIGN_OR_RETURN(const Snapshot snapshot, group.Solve(crew, assignment, news, &row));
    ASSIGN_OR_RETURN(const PatchFile gathered,
                     group.Gather(crew, snapshot, *mesh, waves, news, &row));
    group.Put(gathered, handing, &patch);
    handing.Take(snapshot, row.error_estimate);
    for (size_t f = 0; f < error.size(); ++f) {
      error[f] += TotalError(gathered.faces[f], row.error_handed_on);
    }
    row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  SumUp(error, &patch);
  AddToLastRound(bands, summary);
  return {};
}

}  // namespace isolux
