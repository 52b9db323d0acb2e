#include "server/source_gather.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "common/util/exact_sum.h"

namespace isolux {
namespace {

// Of the accuracy: what leaves that keep the solution's irradiance may reflect, over what all do.
constexpr double kUngathered = 0.1;
// Error of the output over what is unseen of its sources: measured where links miss most
// (docs/accuracy.md).
constexpr double kErrorOfUnseen = 2;
// The most by which gathered sources are scaled.
constexpr double kMostScale = 1.25;

// Of a leaf: its area times the share of its light that goes on, on either side and in any channel.
Rgb ReflectingArea(const Hierarchy& hierarchy, const OutputMeshOptions& output,
                   const NodeId& leaf) {
  return std::ldexp(hierarchy.surface_area_m2(leaf.surface), -leaf.level()) *
         (hierarchy.surfaces()[leaf.surface].reflectance +
          output.sheets.TransmittanceOf(leaf.surface) +
          output.fluorescence.Of(leaf.surface).Taken());
}

}  // namespace

bool HasGatheredSources(const EffectsPlan& plan, const OutputMeshOptions& output) {
  return plan.interreflection || !output.sheets.empty() || !output.fluorescence.empty();
}

std::vector<uint32_t> LeavesThatReflectMost(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                            const OutputMeshOptions& output) {
  std::vector<double> reflected_w;
  ExactSum total_w;
  for (const LeafRecord& leaf : snapshot.leaves) {
    const Rgb reflecting_m2 = ReflectingArea(hierarchy, output, leaf.id);
    reflected_w.push_back(reflecting_m2.x * leaf.irradiance[0] +
                          reflecting_m2.y * leaf.irradiance[1] +
                          reflecting_m2.z * leaf.irradiance[2]);
    total_w.Add(reflected_w.back());
  }
  std::vector<uint32_t> order(snapshot.leaves.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return reflected_w[a] > reflected_w[b]; });
  double rest_w = total_w.Value();
  const double least_w = kUngathered * output.accuracy * rest_w;
  size_t count = 0;
  while (count < order.size() && rest_w > least_w) rest_w -= reflected_w[order[count++]];
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

void KeepReflectedPower(const Hierarchy& hierarchy, const OutputMeshOptions& output,
                        const Snapshot& solution, std::span<const uint32_t> leaves,
                        Snapshot* gathered) {
  std::array<ExactSum, 3> before, after;
  for (const uint32_t i : leaves) {
    const NodeId& id = solution.leaves[i].id;
    const Rgb reflecting_m2 = ReflectingArea(hierarchy, output, id);
    for (int c = 0; c < 3; ++c) {
      before[c].Add(reflecting_m2[c] * solution.leaves[i].irradiance[c]);
      after[c].Add(reflecting_m2[c] * gathered->leaves[i].irradiance[c]);
    }
  }
  for (int c = 0; c < 3; ++c) {
    if (!(after[c].Value() > 0)) continue;
    const double scale =
        std::clamp(before[c].Value() / after[c].Value(), 1 / kMostScale, kMostScale);
    for (const uint32_t i : leaves) gathered->leaves[i].irradiance[c] *= scale;
  }
}

UnseenLight FindUnseenLight(const Hierarchy& hierarchy, const OutputMeshOptions& output,
                            const Snapshot& solution, std::span<const uint32_t> leaves,
                            const Snapshot& gathered) {
  struct Region {
    double sum_w = 0, squares_w2 = 0;
  };
  std::map<uint32_t, Region> regions;
  std::map<uint32_t, double> surfaces_w;
  double all_w = 0;
  for (const uint32_t i : leaves) {
    const NodeId& id = solution.leaves[i].id;
    const Rgb reflecting_m2 = ReflectingArea(hierarchy, output, id);
    double off_w = 0;
    for (int c = 0; c < 3; ++c) {
      const double before = solution.leaves[i].irradiance[c];
      off_w += reflecting_m2[c] * (gathered.leaves[i].irradiance[c] - before);
      all_w += reflecting_m2[c] * before;
    }
    Region& region = regions[hierarchy.cluster_of(id.surface)];
    region.sum_w += off_w;
    region.squares_w2 += off_w * off_w;
    surfaces_w[id.surface] += off_w;
  }
  double unseen_w = 0;
  for (const auto& [cluster, region] : regions) {
    unseen_w += std::sqrt(std::max(0.0, region.sum_w * region.sum_w - region.squares_w2));
  }
  UnseenLight unseen;
  if (!(all_w > 0) || !(unseen_w > 0)) return unseen;
  unseen.error = kErrorOfUnseen * unseen_w / all_w;
  const uint32_t surface = std::ranges::max_element(surfaces_w, {}, [](const auto& of_surface) {
                             return std::abs(of_surface.second);
                           })->first;
  unseen.polygon = hierarchy.scene().polygons[hierarchy.surfaces()[surface].polygon].file_polygon;
  return unseen;
}

Result<UnseenLight> GatherSources(Crew& crew, const Hierarchy& hierarchy, const Snapshot& snapshot,
                                  const OutputMeshOptions& output, GatherWaves& waves) {
  const std::vector<uint32_t> most = LeavesThatReflectMost(hierarchy, snapshot, output);
  std::vector<NodeId> ids;
  for (const uint32_t leaf : most) ids.push_back(snapshot.leaves[leaf].id);
  ASSIGN_OR_RETURN(const std::vector<double> gathered,
                   waves.Gather(ids, std::vector<uint8_t>(ids.size(), kCentre), nullptr));
  Snapshot sources = snapshot;
  for (size_t i = 0; i < most.size(); ++i) {
    std::copy_n(gathered.begin() + static_cast<std::ptrdiff_t>(12 * i), 3,
                sources.leaves[most[i]].irradiance.begin());
  }
  const UnseenLight unseen = FindUnseenLight(hierarchy, output, snapshot, most, sources);
  KeepReflectedPower(hierarchy, output, snapshot, most, &sources);
  RETURN_IF_ERROR(crew.SendAll(MessageKind::kInstallSnapshot, SnapshotData{Encode(sources)}));
  return unseen;
}

}  // namespace isolux
