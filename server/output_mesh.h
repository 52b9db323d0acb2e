// From gathered corners to the patch file: output elements are refined in waves where the
// irradiance bends (each division into four, by two cuts), coincident corners of coplanar
// neighbours of one material are merged, T-vertices inserted.
#pragma once

#include <functional>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/patch_file.h"

namespace isolux {

struct OutputMeshOptions {
  double accuracy = 0.02;  // of the solution; where irradiance bends by twice that, it is divided
  int waves = 4;           // at most; the first is the leaves themselves
  uint64_t max_elements = 4'000'000;
};

// Irradiance (W/m²) at corners of elements: 4 corners × 3 channels each, in the elements' order, of
// which only those count whose bits are set in `corners`. Asked once a wave, with the elements
// sorted by id and each asked for once; a corner that several elements of a leaf share is asked for
// once.
using GatherFunction = std::function<Result<std::vector<double>>(
    const std::vector<NodeId>& elements, const std::vector<uint8_t>& corners)>;

// Runs the waves and builds the patch file's vertices and faces (not its comments).
Result<PatchFile> BuildOutputMesh(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                  const OutputMeshOptions& options, const GatherFunction& gather);

// How many elements each of these leaves (places in the snapshot, in order) would be divided into.
Result<std::vector<uint64_t>> CountOutputElements(const Hierarchy& hierarchy,
                                                  const Snapshot& snapshot,
                                                  const std::vector<uint32_t>& leaves,
                                                  const OutputMeshOptions& options,
                                                  const GatherFunction& gather);

}  // namespace isolux
