// What each effect that is on took of a job: CPU time, rays, links. Parts of the whole that do not
// overlap; what serves no effect alone is in none.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "common/scene/effects_choice.h"

namespace isolux {

struct EffectCost {
  double cpu_s = 0;
  uint64_t rays = 0;
  uint64_t links = 0;  // by way of mirrors

  bool operator==(const EffectCost&) const = default;
};

// Of the effects that can be switched, in their order.
class EffectCosts {
 public:
  static constexpr size_t kCount = kSwitchableEffects.size();
  static constexpr std::string_view NameOf(size_t i) { return kSwitchableEffects[i]; }

  // Null where there is no such effect.
  const EffectCost* Find(std::string_view name) const;
  EffectCost& operator[](std::string_view name);  // of an effect that there is
  EffectCost& at(size_t i) { return costs_[i]; }
  const EffectCost& at(size_t i) const { return costs_[i]; }

  void Add(const EffectCosts& other);
  EffectCost Total() const;
  bool operator==(const EffectCosts&) const = default;

 private:
  std::array<EffectCost, kCount> costs_{};
};

// Rays that lights took, by the effect they are part of.
struct LightRays {
  uint64_t lights = 0, sun = 0, sky = 0;

  uint64_t Total() const { return lights + sun + sky; }
  LightRays& operator+=(const LightRays& other) {
    lights += other.lights;
    sun += other.sun;
    sky += other.sky;
    return *this;
  }
};

}  // namespace isolux
