#include "worker/radiosity/leaf_records.h"

#include <algorithm>

namespace isolux {

std::vector<LeafRecord> RecordLeaves(const Tree& tree, std::span<const uint32_t> nodes,
                                     const LeafSystem& leaves, std::span<const Lanes> irradiance,
                                     const ErrorEstimate& errors, std::span<const double> escape) {
  std::vector<LeafRecord> records;
  records.reserve(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    LeafRecord leaf;
    leaf.id = tree.node(nodes[i]).id;
    double sum = 0, largest = 0;
    for (int c = 0; c < 3; ++c) {
      leaf.irradiance[c] = irradiance[i][c];
      sum += leaf.irradiance[c];
      largest = std::max(largest, leaf.irradiance[c]);
    }
    leaf.spread = static_cast<float>(errors.leaves[i].spread);
    // Of the error over all channels, the worst channel has its share of the light.
    leaf.error = static_cast<float>(sum > 0 ? errors.leaves[i].error * largest / sum : 0);
    leaf.closure = static_cast<float>(leaves.closure[i]);
    leaf.inheritance = static_cast<float>(leaves.inheritance[i]);
    leaf.escape = static_cast<float>(escape[i]);
    leaf.doubt = static_cast<float>(errors.leaves[i].doubt);
    records.push_back(leaf);
  }
  std::sort(records.begin(), records.end(),
            [](const LeafRecord& a, const LeafRecord& b) { return a.id < b.id; });
  return records;
}

}  // namespace isolux
