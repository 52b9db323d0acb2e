#include "common/scene/effect_costs.h"

#include "common/util/check.h"

namespace isolux {

const EffectCost* EffectCosts::Find(std::string_view name) const {
  for (size_t i = 0; i < kCount; ++i) {
    if (NameOf(i) == name) return &costs_[i];
  }
  return nullptr;
}

EffectCost& EffectCosts::operator[](std::string_view name) {
  const EffectCost* found = Find(name);
  CHECK(found != nullptr);
  return costs_[static_cast<size_t>(found - costs_.data())];
}

void EffectCosts::Add(const EffectCosts& other) {
  for (size_t i = 0; i < kCount; ++i) {
    costs_[i].cpu_s += other.costs_[i].cpu_s;
    costs_[i].rays += other.costs_[i].rays;
    costs_[i].links += other.costs_[i].links;
  }
}

EffectCost EffectCosts::Total() const {
  EffectCost total;
  for (const EffectCost& cost : costs_) {
    total.cpu_s += cost.cpu_s;
    total.rays += cost.rays;
    total.links += cost.links;
  }
  return total;
}

}  // namespace isolux
