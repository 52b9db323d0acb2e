// Where the output was gathered, so that the same can be gathered again in other light.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/util/status.h"
#include "server/output_element.h"

namespace isolux {

// Irradiance (W/m²) at corners of elements: 4 corners × 3 channels each, in the elements' order, of
// which only those count whose bits are set in `corners`. Asked once a wave, with the elements
// sorted by id and each asked for once; a corner that several elements of a leaf share is asked for
// once.
using GatherFunction = std::function<Result<std::vector<double>>(
    const std::vector<NodeId>& elements, const std::vector<uint8_t>& corners)>;

struct OutputPoints {
  // What was asked for at once: elements, which of their corners, and the point that each of these
  // corners is.
  struct Wave {
    std::vector<NodeId> elements;
    std::vector<uint8_t> corners;
    std::vector<uint32_t> points;
  };
  // An element whose corners are points.
  struct Cornered {
    NodeId id;
    std::array<uint32_t, 4> points{};
  };
  std::vector<Wave> waves;
  std::vector<Cornered> elements;  // sorted by id
  uint32_t count = 0;              // of points
};

// Asks for all points anew and gives these elements what comes: each is one of those whose corners
// are points, or, interpolated, a part of one. Their own irradiance is written over.
Status GatherAgain(const OutputPoints& points, const Hierarchy& hierarchy,
                   const GatherFunction& gather, std::vector<OutputElement>* elements);

}  // namespace isolux
