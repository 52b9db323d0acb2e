// Closed rooms of many panels with a box on the floor: every row of their factors adds up to 1.
#pragma once

#include <array>
#include <vector>

#include "common/scene/scene.h"

namespace isolux::testing {

struct PanelledRoom {
  std::array<int, 3> panels{14, 12, 6};  // along each axis, half a metre each
  // The box: panels of the floor that it stands on, from `low` up to, not including, `high`.
  std::array<int, 2> low{5, 4}, high{7, 6};
  double height_m = 1.2;
  // Off the floor (floating) or into it (sunk, negative). Other than 0 it has a bottom, and the
  // floor runs on below it.
  double gap_m = 0;
  bool with_box = true;
};

// Fronts inwards (of the box outwards), fronts only; the sides and the top of the box are two
// panels each. The defaults make 654 polygons.
Scene MakePanelledRoom(const PanelledRoom& room);

// A scene of these polygons, fronts only.
Scene MakeScene(const std::vector<ConvexPolygon>& polygons);

}  // namespace isolux::testing
