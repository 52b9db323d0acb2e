// What the first round of a job, which simulates an effect, found of it: what leaving it out would
// cost. It may be left out from then on (common/hierarchy/effects/plan.h).
#pragma once

#include <optional>
#include <string>

#include "common/util/status.h"

namespace isolux {

// Of a coarse round. Half of it is for what such a round does not see: of the light on the surfaces
// in question beyond the errors that their elements state, and of the brightest place within an
// element.
inline constexpr double kMeasuredSafety = 2;

struct MeasuredEffect {
  std::string name = {};
  // Of all light that arrives, Σ_c ∫H dA, what arrives by way of the effect, or is taken by it;
  // with the stated errors of where it is found.
  double share = 0;
  double amplification = 1;          // how often a watt of that arrives in the end, at most
  std::optional<double> bound = {};  // known before
  bool off = false;                  // left out from then on

  // No less than Σ_c ∫|ΔH| dA / Σ_c ∫H dA, with ΔH what the irradiance would be off without it.
  double Neglect() const { return kMeasuredSafety * share * amplification; }
  bool operator==(const MeasuredEffect&) const = default;
};

// One that is known and measured, with numbers that may be.
Status Validate(const MeasuredEffect& effect);
// "mirrors: on, then off: measured 0.0003 after round 1 (bound 7.14)"
std::string ToText(const MeasuredEffect& effect);
// The same without the name: "on, then off: …" or "measured …".
std::string DecisionOf(const MeasuredEffect& effect);

}  // namespace isolux
