// From gathered corners to the patch file: output elements are refined where the irradiance bends,
// coincident corners of coplanar neighbours of one material are merged, T-vertices inserted.
#pragma once

#include <functional>
#include <vector>

#include "common/hierarchy/fluorescence.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/hierarchy/translucent_sheets.h"
#include "common/scene/patch_file.h"

namespace isolux {

struct OutputMeshOptions {
  double accuracy = 0.02;  // of the solution; where irradiance bends by twice that, it is divided
  int waves =
      4;  // that divide whatever bends; the first is the leaves themselves, and 1 all there is
  int further_waves = 8;  // at most, where interpolation would take too much of the accuracy
  uint64_t max_elements = 4'000'000;
  TranslucentSheets sheets;   // that are simulated
  Fluorescence fluorescence;  // likewise
};

// Irradiance (W/m²) at corners of elements: 4 corners × 3 channels each, in the elements' order, of
// which only those count whose bits are set in `corners`. Asked once a wave, with the elements
// sorted by id and each asked for once; a corner that several elements of a leaf share is asked for
// once.
using GatherFunction = std::function<Result<std::vector<double>>(
    const std::vector<NodeId>& elements, const std::vector<uint8_t>& corners)>;

struct OutputMesh {
  PatchFile patch;                 // vertices and faces, no comments
  double interpolation_error = 0;  // mean |ΔH| / mean H that interpolation is expected to leave
};

// Refines the output (see output_refinement.h) and builds the patch file's vertices and faces.
Result<OutputMesh> BuildOutputMesh(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                   const OutputMeshOptions& options, const GatherFunction& gather);

}  // namespace isolux
