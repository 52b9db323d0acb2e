#include "common/hierarchy/effects/plan.h"

#include <algorithm>
#include <optional>

#include "common/hierarchy/effects/detectors.h"
#include "common/util/check.h"

namespace isolux {
namespace {

// Shares of the accuracy that one effect may cost, and all together.
constexpr double kShareOfOne = 1.0 / 5, kShareOfAll = 1.0 / 2;

std::vector<Effect> DetectAll(const Hierarchy& hierarchy, double accuracy) {
  const Scene& scene = hierarchy.scene();
  return {
      DetectColour(hierarchy),   DetectOcclusion(hierarchy),    DetectInterreflection(hierarchy),
      DetectClosure(hierarchy),  DetectTwoSided(hierarchy),     DetectTextures(hierarchy),
      DetectEmissionMaps(scene), DetectOpacityMaps(scene),      DetectMirrors(hierarchy, accuracy),
      DetectGloss(hierarchy),    DetectClearGlass(hierarchy),   DetectLights(hierarchy),
      DetectSun(hierarchy),      DetectSky(hierarchy),          DetectMedium(hierarchy),
      DetectSheets(hierarchy),   DetectFluorescence(hierarchy),
  };
}

void Decide(bool on, std::string reason, Effect* effect) {
  effect->on = on;
  effect->decision = on ? "on" : "off";
  effect->reason = std::move(reason);
}

// What neglecting it costs at most, by all that is known.
std::optional<double> CostOf(const Effect& effect) {
  if (!effect.measured || !effect.bound) return effect.measured ? effect.measured : effect.bound;
  return std::min(*effect.bound, *effect.measured);
}

void DecideByBound(double accuracy, Effect* effect) {
  const std::optional<double> cost = CostOf(*effect);
  if (!effect->present) {
    Decide(false, "nothing calls for it", effect);
  } else if (!cost) {
    Decide(true, "no bound on what it would cost to neglect it", effect);
  } else {
    const double share = kShareOfOne * accuracy;
    const bool on = *cost >= share;
    Decide(on,
           fmt::format("{} {} {:.3g}, a fifth of the accuracy",
                       effect->measured ? "that is" : "its bound is", on ? "not below" : "below",
                       share),
           effect);
  }
}

// What rows are to know of what the first round found.
void TakeMeasured(std::span<const MeasuredEffect> measured, std::vector<Effect>* effects) {
  for (const MeasuredEffect& found : measured) {
    const auto effect = std::ranges::find(*effects, found.name, &Effect::name);
    if (effect != effects->end()) effect->measured = found.Neglect();
  }
}

// Of those that were measured, how the decision came about.
void SayWhatWasMeasured(std::vector<Effect>* effects) {
  for (Effect& effect : *effects) {
    if (!effect.measured) continue;
    const MeasuredEffect found{.name = effect.name,
                               .share = *effect.measured / kMeasuredSafety,
                               .bound = effect.bound,
                               .off = effect.support == Support::kSwitchable && !effect.on};
    if (effect.support == Support::kNotSimulated) {
      effect.reason += "; as if they reflected diffusely, " + DecisionOf(found);
    } else {
      effect.reason = DecisionOf(found) + "; " + effect.reason;
    }
  }
}

// What is left out although it is present, largest bound first, until the rest may be. Where some
// were measured these alone: without them the rest might be.
double SwitchOnTheLargest(double accuracy, std::vector<Effect>* effects) {
  const bool measured = std::ranges::any_of(*effects, [](const Effect& e) { return !!e.measured; });
  while (true) {
    double sum = 0;
    Effect* largest = nullptr;
    for (Effect& effect : *effects) {
      if (effect.support != Support::kSwitchable || effect.on || !effect.present) continue;
      sum += *CostOf(effect);
      if (measured && !effect.measured) continue;
      if (largest == nullptr || *CostOf(effect) > *CostOf(*largest)) largest = &effect;
    }
    if (largest == nullptr || !(sum > kShareOfAll * accuracy)) return sum;
    Decide(true, "what would be left out adds up to more than half of the accuracy", largest);
  }
}

void Choose(const EffectsChoice& choice, std::vector<Effect>* effects) {
  for (Effect& effect : *effects) {
    if (effect.support != Support::kSwitchable) continue;
    if (choice.base == EffectsChoice::Base::kAll) Decide(true, "asked for: all", &effect);
    if (choice.base == EffectsChoice::Base::kNone) Decide(false, "asked for: none", &effect);
    if (choice.on.contains(effect.name)) Decide(true, "switched on", &effect);
    if (choice.off.contains(effect.name)) Decide(false, "switched off", &effect);
  }
}

Effect& Find(std::vector<Effect>& effects, std::string_view name) {
  const auto found = std::ranges::find(effects, name, &Effect::name);
  CHECK(found != effects.end());
  return *found;
}

// Whether the first round can say what neglecting this effect costs, and may change the decision.
bool IsToBeMeasured(const Scene& scene, bool mirrors, const EffectsChoice& choice,
                    const Effect& effect) {
  if (!effect.present || choice.on.contains(effect.name)) return false;
  // The first round knows of channels alone, and what is measured there bounds nothing in bands of
  // another light.
  const auto has_spectrum = [](const Material& material) { return material.spectrum.exists(); };
  if (std::ranges::any_of(scene.materials, has_spectrum)) return false;
  if (effect.name == "mirrors") {
    return effect.on || (effect.support == Support::kNotSimulated && effect.bound.has_value());
  }
  if (effect.name == "gloss") return true;
  if (!effect.on) return false;
  if (effect.name == "sheets" || effect.name == "fluorescence") return true;
  // What is taken of the light of lights and sky is not measured, nor what mirrors would have
  // brought of it.
  const bool lamps_alone = scene.lights.empty() && !scene.sky.exists();
  return (effect.name == "medium" || effect.name == "clear-glass") && lamps_alone && !mirrors;
}

// Bounds that rest on surfaces handing on no more light than they receive by the row: before
// mirrors light arrives once more.
void TakeBackBounds(std::vector<Effect>* effects) {
  const Effect& mirrors = Find(*effects, "mirrors");
  if (!mirrors.present || mirrors.support != Support::kSwitchable) return;
  for (const char* name : {"colour", "interreflection", "medium", "clear-glass", "sheets",
                           "fluorescence", "textures"}) {
    Effect& effect = Find(*effects, name);
    if (effect.bound.value_or(0) > 0) effect.bound.reset();
  }
}

}  // namespace

EffectsTable PlanEffects(const Hierarchy& hierarchy, double accuracy, const EffectsChoice& choice,
                         std::span<const MeasuredEffect> measured) {
  EffectsTable table;
  table.effects = DetectAll(hierarchy, accuracy);
  TakeBackBounds(&table.effects);
  TakeMeasured(measured, &table.effects);
  for (Effect& effect : table.effects) {
    if (effect.support == Support::kSwitchable) {
      DecideByBound(accuracy, &effect);
    } else {
      effect.on = effect.present && effect.support == Support::kFixed;
      effect.decision = effect.on ? "on" : effect.present ? "not simulated" : "off";
      if (effect.reason.empty()) effect.reason = "nothing calls for it";
    }
  }
  if (choice.base == EffectsChoice::Base::kAuto) {
    table.neglected = SwitchOnTheLargest(accuracy, &table.effects);
    SayWhatWasMeasured(&table.effects);
  }
  Choose(choice, &table.effects);
  Effect& closure = Find(table.effects, "closure");
  const bool asked_for = choice.on.contains("closure") || choice.base == EffectsChoice::Base::kAll;
  if (closure.on && !asked_for && !Find(table.effects, "interreflection").on &&
      !Find(table.effects, "sheets").on && !Find(table.effects, "fluorescence").on) {
    Decide(false, "direct light alone: what rows miss is not magnified", &closure);
  }
  const Effect& fluorescence = Find(table.effects, "fluorescence");
  table.plan.fluorescence = fluorescence.on;
  // Light that changes its channel needs all.
  const bool coloured = fluorescence.present && fluorescence.on;
  const Effect& colour = Find(table.effects, "colour");
  table.plan.bands = colour.on && !hierarchy.scene().bands.empty();
  // Bands call for three channels only where these differ too.
  const bool channels_differ =
      colour.on && (!table.plan.bands || DetectChannels(hierarchy).present);
  table.plan.channels = coloured || channels_differ ? 3 : 1;
  if (table.plan.channels == 1) {
    SetLightColour(hierarchy, &table.plan);
    table.plan.grey_error = colour.bound.value_or(0);
  }
  table.plan.occlusion = Find(table.effects, "occlusion").on;
  table.plan.interreflection = Find(table.effects, "interreflection").on;
  table.plan.closure = closure.on;
  table.plan.lights = Find(table.effects, "lights").on;
  table.plan.sun = Find(table.effects, "sun").on;
  table.plan.sky = Find(table.effects, "sky").on;
  table.plan.medium = Find(table.effects, "medium").on;
  table.plan.textures = Find(table.effects, "textures").on;
  table.plan.mirrors = Find(table.effects, "mirrors").on;
  table.plan.sheets = Find(table.effects, "sheets").on;
  table.plan.glass = Find(table.effects, "clear-glass").on;
  for (const Effect& effect : table.effects) {
    if (effect.measured && effect.support == Support::kSwitchable && !effect.on) {
      table.plan.measured_error += *CostOf(effect);
    }
    if (choice.base == EffectsChoice::Base::kAuto &&
        IsToBeMeasured(hierarchy.scene(), table.plan.mirrors, choice, effect)) {
      table.to_measure.push_back(effect.name);
    }
  }
  return table;
}

bool NoteDecisions(const EffectsTable& table, std::vector<MeasuredEffect>* measured) {
  bool any = false;
  for (MeasuredEffect& found : *measured) {
    const auto effect = std::ranges::find(table.effects, found.name, &Effect::name);
    if (effect == table.effects.end()) continue;
    found.bound = effect->bound;
    found.off = effect->support == Support::kSwitchable && !effect->on;
    any |= found.off;
  }
  return any;
}

EffectsPlan PlanGroup(const Hierarchy& of_group, const Scene& whole, uint32_t group,
                      const EffectsPlan& plan) {
  EffectsPlan result = plan;
  result.bands = false;
  result.grey_error = 0;
  const bool handed = plan.fluorescence && IsHandedLight(whole, group);
  result.channels = handed || DetectChannels(of_group).present ? 3 : 1;
  if (result.channels == 1) SetLightColour(of_group, &result);
  return result;
}

}  // namespace isolux
