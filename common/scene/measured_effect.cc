#include "common/scene/measured_effect.h"

#include <algorithm>

#include "common/scene/effects_choice.h"

namespace isolux {

Status Validate(const MeasuredEffect& effect) {
  const bool switchable =
      std::ranges::find(kSwitchableEffects, effect.name) != kSwitchableEffects.end();
  if (!switchable && effect.name != "gloss") {
    return MakeStatus(StatusCode::kDataLoss, "measured effects: there is no effect '{}'",
                      effect.name);
  }
  if (!(effect.share >= 0) || !(effect.amplification >= 1) ||
      (effect.bound && !(*effect.bound >= 0))) {
    return MakeStatus(StatusCode::kDataLoss, "measured effects: {} has {} of the light, {} times",
                      effect.name, effect.share, effect.amplification);
  }
  return {};
}

std::string DecisionOf(const MeasuredEffect& effect) {
  const std::string bound = effect.bound ? fmt::format("bound {:.3g}", *effect.bound) : "no bound";
  return fmt::format("{}measured {:.3g} after round 1 ({})", effect.off ? "on, then off: " : "",
                     effect.Neglect(), bound);
}

std::string ToText(const MeasuredEffect& effect) { return effect.name + ": " + DecisionOf(effect); }

}  // namespace isolux
