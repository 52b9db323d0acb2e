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
#include "server/output_element.h"
#include "server/output_points.h"

namespace isolux {

struct OutputMeshOptions {
  double accuracy = 0.02;  // of the solution; where irradiance bends by twice that, it is divided
  double point_accuracy = 0.02;  // that rays at points work to
  int waves =
      4;  // that divide whatever bends; the first is the leaves themselves, and 1 all there is
  int further_waves = 8;  // at most, where interpolation would take too much of the accuracy
  uint64_t max_elements = 4'000'000;
  bool keep_points = false;   // for BuildAgain
  TranslucentSheets sheets;   // that are simulated
  Fluorescence fluorescence;  // likewise
};

struct OutputMesh {
  PatchFile patch;                 // vertices and faces, no comments
  double interpolation_error = 0;  // mean |ΔH| / mean H that interpolation is expected to leave
  // What the mesh was made of, for BuildAgain; the points where the options say so.
  OutputPoints points;
  std::vector<OutputElement> elements;
  std::vector<uint32_t> weld_groups;
};

// Refines the output (see output_refinement.h) and builds the patch file's vertices and faces.
Result<OutputMesh> BuildOutputMesh(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                   const OutputMeshOptions& options, const GatherFunction& gather);

// The vertices and faces of a mesh, one for one, in other light: gathered again at the same points.
// `of_light`: the hierarchy with what its surfaces reflect and emit of it; `snapshot` and `options`
// are of it too.
Result<PatchFile> BuildAgain(const OutputMesh& mesh, const Hierarchy& of_light,
                             const Snapshot& snapshot, const OutputMeshOptions& options,
                             const GatherFunction& gather);

}  // namespace isolux
