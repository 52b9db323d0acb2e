// Which effects a user wants simulated, whatever the analysis of the scene decides
// (common/hierarchy/effects): --effects.
//
//   CHOICE = [auto|all|none] [,+NAME | ,-NAME] …      for instance: auto   none,+closure -occlusion
//
// auto: what the scene calls for; all: whatever can be simulated, called for or not; none: nothing
// that can be left out. A name with + or − is switched on or off after that.
#pragma once

#include <array>
#include <set>
#include <string>
#include <string_view>

#include "common/util/status.h"

namespace isolux {

// The effects that can be switched, in the order of the table.
inline constexpr std::array<std::string_view, 13> kSwitchableEffects = {
    "colour", "occlusion", "interreflection", "closure",     "textures", "mirrors",     "lights",
    "sun",    "sky",       "medium",          "clear-glass", "sheets",   "fluorescence"};

struct EffectsChoice {
  enum class Base { kAuto, kAll, kNone };
  Base base = Base::kAuto;
  std::set<std::string> on, off;  // switched by name; never one in both
};

// Of the text above; blanks do not count, an empty text is `auto`. An unknown name is an error that
// lists those there are.
Result<EffectsChoice> ParseEffectsChoice(std::string_view text);

}  // namespace isolux
