// A row of the table of effects: what one physical effect does in a scene, and what neglecting it
// would cost.
#pragma once

#include <optional>
#include <string>

namespace isolux {

enum class Support {
  kSwitchable,    // simulated or not, as the plan says (names: kSwitchableEffects)
  kFixed,         // follows from the scene; costs nothing where it is absent
  kNotSimulated,  // replaced by something simpler, here or by the importer
};

struct Effect {
  std::string name = {};
  bool present = false;
  std::string evidence = {};  // what in the scene calls for it: materials, polygons, areas, powers
  // No less than Σ_c ∫|ΔH| dA / Σ_c ∫H dA, ΔH what the irradiance would be off without it; nothing
  // where the energy of the scene alone gives no bound.
  std::optional<double> bound = {};
  // The same, found by the first round of the job.
  std::optional<double> measured = {};
  Support support = Support::kSwitchable;
  bool on = false;            // simulated
  std::string decision = {};  // "on", "off", "not simulated"
  std::string reason = {};
};

}  // namespace isolux
