#include "server/output_points.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

// By point.
Result<std::vector<Channels>> GatherPoints(const OutputPoints& points,
                                           const GatherFunction& gather) {
  std::vector<Channels> irradiance(points.count);
  for (const OutputPoints::Wave& wave : points.waves) {
    ASSIGN_OR_RETURN(const std::vector<double> values, gather(wave.elements, wave.corners));
    if (values.size() != 12 * wave.elements.size()) {
      return Error(StatusCode::kInternal, "gathered {} values at the corners of {} elements",
                   values.size(), wave.elements.size());
    }
    size_t next = 0;
    for (size_t i = 0; i < wave.elements.size(); ++i) {
      for (size_t k = 0; k < 4; ++k) {
        if ((wave.corners[i] >> k & 1) == 0) continue;
        Channels& at = irradiance[wave.points[next++]];
        for (size_t c = 0; c < 3; ++c) {
          const double value = values[12 * i + 3 * k + c];
          at[c] = static_cast<float>(std::isfinite(value) ? std::max(0.0, value) : 0.0);
        }
      }
    }
  }
  return irradiance;
}

// The part of a field that is an element below the one it is of.
std::array<Channels, 4> Below(Field field, const NodeId& whole, const NodeId& part) {
  for (int level = part.level() - whole.level() - 1; level >= 0; --level) {
    field = Cut(field)[part.path >> level & 1];
  }
  return field.value;
}

}  // namespace

Status GatherAgain(const OutputPoints& points, const Hierarchy& hierarchy,
                   const GatherFunction& gather, std::vector<OutputElement>* elements) {
  ASSIGN_OR_RETURN(const std::vector<Channels> irradiance, GatherPoints(points, gather));
  auto at = points.elements.begin();
  for (OutputElement& element : *elements) {
    while (at != points.elements.end() && !Contains(at->id, element.id)) ++at;
    if (at == points.elements.end()) {
      return {StatusCode::kInternal, "an output element that was not gathered"};
    }
    Field whole{ElementGeometry(hierarchy.geometry(at->id.surface), at->id.path), {}};
    for (int k = 0; k < whole.shape.count; ++k) whole.value[k] = irradiance[at->points[k]];
    element.irradiance = Below(whole, at->id, element.id);
  }
  return {};
}

}  // namespace isolux
