// Which effects a scene calls for, as far as the scene alone tells.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/hierarchy/hierarchy.h"

namespace isolux {

struct Effect {
  std::string name;
  bool present = false;
  std::string evidence;
  // What neglecting it would cost, relative to the mean irradiance or the emitted power; nothing
  // where no bound is computed.
  std::optional<double> bound;
  std::string decision;
};

// In a fixed order, present or not. Reads the repair report for what the importer replaced.
std::vector<Effect> FindEffects(const Hierarchy& hierarchy);

}  // namespace isolux
