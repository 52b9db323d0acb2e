#include "server/band_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/hierarchy/effects/plan.h"
#include "common/util/exact_sum.h"
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

// One group.
class Group {
 public:
  Group(const BandsInput& input, uint32_t number)
      : input_(input),
        bands_(input.hierarchy.scene().bands),
        number_(number),
        scene_(SceneOfGroup(input.hierarchy.scene(), number)),
        hierarchy_(input.hierarchy),
        output_(input.output) {
    hierarchy_.TakeOptics(scene_);
    output_.sheets = TranslucentSheets(hierarchy_, input.plan);
    output_.fluorescence = Fluorescence(hierarchy_, input.plan);
    output_.keep_points = false;
  }

  // Nothing emits in it.
  bool is_dark() const { return !Emits(scene_); }

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
    RETURN_IF_ERROR(crew.SendAll(MessageKind::kInstallSnapshot, SnapshotData{Encode(snapshot)}));
    Summarize(row, snapshot, summary);
    return snapshot;
  }

  // Gathered at the points of the mesh.
  Result<PatchFile> Gather(Crew& crew, const Snapshot& snapshot, const OutputMesh& mesh,
                           GatherWaves& waves, const BandNews& news) const {
    if (input_.plan.interreflection || !output_.sheets.empty()) {
      RETURN_IF_ERROR(GatherSources(crew, hierarchy_, snapshot, output_, waves));
    }
    const uint64_t before = waves.gathered();
    return BuildAgain(
        mesh, hierarchy_, snapshot, output_,
        [&](const std::vector<NodeId>& elements, const std::vector<uint8_t>& corners) {
          return waves.Gather(elements, corners,
                              [&](uint64_t gathered) { news(number_, 0, gathered - before); });
        });
  }

  // Into the bands of the mesh.
  void Put(const PatchFile& of_group, PatchFile* patch) const {
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
  }

 private:
  // The last round's irradiance, by what is emitted in a band of what is in its channel.
  Snapshot Start() const {
    std::array<int, 3> from{};
    std::array<double, 3> share{};
    for (int c = 0; c < 3; ++c) {
      const uint32_t band = BandInChannel(bands_.size(), number_, c);
      if (band >= bands_.size()) continue;
      from[c] = bands_[band].channel();
      const double channel_w = input_.hierarchy.emitted_w()[from[c]];
      share[c] =
          channel_w > 0 ? hierarchy_.emitted_w()[c] / channel_w : ShareOfChannel(bands_, band);
    }
    Snapshot start = input_.snapshot;
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

  void Summarize(const RoundSummary& row, const Snapshot& snapshot,
                 BandGroupSummary* summary) const {
    summary->error_estimate = row.error_estimate;
    summary->irradiance_w = ArrivingPower(hierarchy_, snapshot);
    summary->channels = static_cast<uint32_t>(PlanGroup(hierarchy_, input_.plan).channels);
    summary->iterations = row.iterations;
    summary->residual = row.residual;
    summary->energy_imbalance = row.energy_imbalance;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t band = BandInChannel(bands_.size(), number_, static_cast<int>(c));
      if (band >= bands_.size()) continue;
      summary->bands[band - kBandsOfGroup * number_] = {
          row.emitted_w[c], row.absorbed_w[c], row.escaped_w[c], row.medium_w[c], row.glass_w[c]};
    }
  }

  const BandsInput& input_;
  const std::vector<Band>& bands_;
  const uint32_t number_;
  const Scene scene_;
  Hierarchy hierarchy_;
  OutputMeshOptions output_;
};

// Of a face, over the channels.
double TotalError(const PatchFace& face) {
  const auto& h = face.irradiance;
  const double largest = std::max({h[0], h[1], h[2]});
  return largest > 0 ? face.error * (double{h[0]} + h[1] + h[2]) / largest : 0.0;
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

void AddToLastRound(const std::vector<Band>& bands, SolveSummary* summary) {
  RoundSummary& last = summary->rounds.back();
  last.error_estimate = std::max(last.error_estimate, ErrorOfAll(summary->band_groups));
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
  double off_w = 0, arriving_w = 0;
  for (const BandGroupSummary& group : groups) {
    off_w += group.error_estimate * group.irradiance_w;
    arriving_w += group.irradiance_w;
  }
  return arriving_w > 0 ? off_w / arriving_w : 0;
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
  for (uint32_t number = 0; number < BandGroupCount(bands.size()); ++number) {
    const auto start = std::chrono::steady_clock::now();
    BandGroupSummary& row = summary->band_groups.emplace_back();
    row.bands.resize(std::min<size_t>(kBandsOfGroup, bands.size() - kBandsOfGroup * number));
    const Group group(input, number);
    if (group.is_dark()) continue;
    news(number, 0, 0);
    ASSIGN_OR_RETURN(const Snapshot snapshot, group.Solve(crew, assignment, news, &row));
    ASSIGN_OR_RETURN(const PatchFile gathered, group.Gather(crew, snapshot, *mesh, waves, news));
    group.Put(gathered, &patch);
    for (size_t f = 0; f < error.size(); ++f) error[f] += TotalError(gathered.faces[f]);
    row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  SumUp(error, &patch);
  AddToLastRound(bands, summary);
  return {};
}

}  // namespace isolux
