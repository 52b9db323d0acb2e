#include "server/survey.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "common/util/random.h"
#include "server/gather_waves.h"
#include "server/output_refinement.h"
#include "server/source_gather.h"

namespace isolux {
namespace {

// Leaves of a sample: one in so many, for a few hundredths of what the whole gather takes; at least
// so many, with which its figures are known to about a fifth, and no more than these.
constexpr uint32_t kOneIn = 32, kFewest = 64, kMost = 512;
// The gather's error is how far it is from another one with at least four times the rays, of which
// its own are a part: √(1 − 1/4) of the deviation of its own.
constexpr double kSeenOfDeviation = 0.8660254037844386;
// Accuracy that the finer one of the two works to at least, and below which the number of rays does
// not follow the accuracy: there the error is measured at this and goes with the square root.
constexpr double kFinerAccuracy = 0.01;

double LeafArea(const Hierarchy& hierarchy, const NodeId& id) {
  return std::ldexp(hierarchy.surface_area_m2(id.surface), -id.level());
}

struct Corners {
  std::vector<NodeId> leaves;
  std::vector<uint8_t> wanted;
};

// Mean of |coarse − fine| over the mean irradiance, over all corners, by area.
double RelativeDifference(const Hierarchy& hierarchy, const LeafSample& sample,
                          const Corners& corners, const std::vector<double>& coarse,
                          const std::vector<double>& fine) {
  double off = 0, arriving = 0;
  for (size_t i = 0; i < corners.leaves.size(); ++i) {
    const int count = std::popcount(corners.wanted[i]);
    const double area = sample.weight[i] * LeafArea(hierarchy, corners.leaves[i]) / count;
    for (int k = 0; k < 3 * count; ++k) {
      const size_t at = 12 * i + static_cast<size_t>(k);
      off += area * std::abs(coarse[at] - fine[at]);
      arriving += area * fine[at];
    }
  }
  return arriving > 0 ? off / arriving : 0;
}

Result<double> GatherError(Crew& crew, const Hierarchy& hierarchy, const Snapshot& snapshot,
                           const LeafSample& sample, double accuracy) {
  Corners corners;
  for (const uint32_t leaf : sample.leaves) {
    corners.leaves.push_back(snapshot.leaves[leaf].id);
    const int count = hierarchy.geometry(corners.leaves.back().surface).count;
    corners.wanted.push_back(static_cast<uint8_t>((1U << count) - 1));
  }
  const double at = std::max(accuracy, kFinerAccuracy);
  std::array<std::vector<double>, 2> gathered;
  for (const bool finer : {false, true}) {
    GatherWaves waves(crew, finer ? std::min(0.5 * at, kFinerAccuracy) : at, kMost);
    ASSIGN_OR_RETURN(gathered[finer ? 1 : 0],
                     waves.Gather(corners.leaves, corners.wanted, nullptr));
  }
  const double off = RelativeDifference(hierarchy, sample, corners, gathered[0], gathered[1]);
  return std::max(0.5, accuracy / at) * off / kSeenOfDeviation;
}

}  // namespace

Result<LinkErrors> CountLinkErrors(Crew& crew) {
  RETURN_IF_ERROR(crew.SendAll(MessageKind::kCountErrors, std::string()));
  ASSIGN_OR_RETURN(const auto messages, crew.CollectAll(MessageKind::kLinkErrors));
  LinkErrors total;
  for (const auto& message : messages) {
    if (!message) continue;
    ASSIGN_OR_RETURN(const LinkErrors errors, DecodeMessage<LinkErrors>(message->payload));
    total.histogram.Add(errors.histogram);
    total.memory_bytes += errors.memory_bytes;
  }
  return total;
}

LeafSample SampleLeaves(const Hierarchy& hierarchy, const Snapshot& snapshot, uint64_t seed) {
  LeafSample sample;
  const auto count = static_cast<uint32_t>(snapshot.leaves.size());
  const uint32_t wanted = std::clamp(count / kOneIn, kFewest, kMost);
  if (count <= wanted) {
    sample.leaves.resize(count);
    std::iota(sample.leaves.begin(), sample.leaves.end(), 0);
    sample.weight.assign(count, 1);
    return sample;
  }
  double area_m2 = 0;
  for (const LeafRecord& leaf : snapshot.leaves) area_m2 += LeafArea(hierarchy, leaf.id);
  const double offset = Random(Hash(seed, snapshot.round)).Unit();
  // Even steps through the leaves laid side by side, each as wide as its chance.
  double at = 0;
  uint32_t steps = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const double chance = 0.5 / count + 0.5 * LeafArea(hierarchy, snapshot.leaves[i].id) / area_m2;
    at += chance;
    uint32_t hits = 0;
    for (; steps < wanted && (steps + offset) / wanted < at; ++steps) ++hits;
    if (hits == 0) continue;
    sample.leaves.push_back(i);
    sample.weight.push_back(hits / (chance * wanted));
  }
  return sample;
}

Status SampleGather(Crew& crew, const Hierarchy& hierarchy, const Snapshot& snapshot,
                    const OutputMeshOptions& output, uint64_t seed, RoundSummary* row) {
  const LeafSample sample = SampleLeaves(hierarchy, snapshot, seed);
  ASSIGN_OR_RETURN(row->error_gather,
                   GatherError(crew, hierarchy, snapshot, sample, output.accuracy));
  OutputMeshOptions of_sample = output;
  of_sample.further_waves = 0;  // few elements need them
  // As many as the sample's share of the limit: where not all can be divided that bend, those that
  // bend most are, at whose points there are most rays.
  const double stand_for = std::accumulate(sample.weight.begin(), sample.weight.end(), 0.0);
  of_sample.max_elements = static_cast<uint64_t>(
      std::ceil(static_cast<double>(output.max_elements) *
                static_cast<double>(sample.leaves.size()) / std::max(1.0, stand_for)));
  GatherWaves waves(crew, output.accuracy, kMost);
  uint64_t points = 0;
  const auto gather = [&](const std::vector<NodeId>& elements,
                          const std::vector<uint8_t>& corners) {
    for (const uint8_t wanted : corners) points += static_cast<uint64_t>(std::popcount(wanted));
    return waves.Gather(elements, corners, nullptr);
  };
  ASSIGN_OR_RETURN(const OutputElements refined,
                   RefineOutput(hierarchy, snapshot, sample.leaves, of_sample, gather));
  double seen = 0, whole = 0;
  for (const OutputElement& element : refined.elements) {
    const auto place = std::lower_bound(sample.leaves.begin(), sample.leaves.end(), element.leaf);
    ++seen;
    whole += sample.weight[static_cast<size_t>(place - sample.leaves.begin())];
  }
  const double most = static_cast<double>(output.max_elements);
  const double factor = seen > 0 ? std::min(whole, most) / seen : 0;
  const auto grown = [&](uint64_t n) {
    return static_cast<uint64_t>(std::llround(factor * static_cast<double>(n)));
  };
  row->output_elements = grown(static_cast<uint64_t>(seen));
  // The middles of leaves come first.
  const uint64_t output_points = grown(points);
  const size_t middles = LeavesThatReflectMost(hierarchy, snapshot, output).size();
  const double all =
      output_points > 0 ? 1 + static_cast<double>(middles) / static_cast<double>(output_points) : 1;
  row->output_points =
      static_cast<uint64_t>(std::llround(all * static_cast<double>(output_points)));
  row->output_rays =
      static_cast<uint64_t>(std::llround(all * static_cast<double>(grown(waves.rays()))));
  row->output_s = all * factor * waves.wall_s();
  return {};
}

}  // namespace isolux
