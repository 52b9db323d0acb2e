// Which elements the output has: leaves are divided in waves where the irradiance bends.
#pragma once

#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "server/output_element.h"
#include "server/output_mesh.h"
#include "server/output_points.h"

namespace isolux {

// Elements, sorted by id, with what was gathered at their corners.
struct OutputElements {
  std::vector<OutputElement> elements;
  OutputPoints points;  // where the options say so
  // ∫ |ΔH| dA over ∫ H dA that interpolation between the corners is expected to leave, of the
  // leaves asked for. Where a corner was off by d from what its element's parent had led to expect,
  // the element is taken to be off by d/4 on average: what is right of a step, whose place alone is
  // unknown, and of a parabola.
  double interpolation_error = 0;
};

// Divides these leaves (places in the snapshot, in order). Each division is into four, by two cuts:
// one cut would show a bend in one direction only.
//
// The first waves divide whatever bends by more than the accuracy. Then, as long as interpolation
// leaves more than its share of the accuracy, the elements that leave most are divided on: edges of
// shadows and of light close to its source are found where they matter and nowhere else.
Result<OutputElements> RefineOutput(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                    const std::vector<uint32_t>& leaves,
                                    const OutputMeshOptions& options, const GatherFunction& gather);

}  // namespace isolux
