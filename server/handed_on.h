// Fluorescence from one group of spectral bands to another: what fluorescent leaves have taken in
// the bands that are solved for is what they emit in those that follow.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/effects_plan.h"

namespace isolux {

// What a group is handed by those before it.
struct HandedOn {
  std::vector<PassedLight> of_leaves;  // empty: nothing
  Rgb power_w{0.0};                    // by channel of the group
  double error_w = 0;                  // of it, over all channels, by the errors of those before

  bool empty() const { return of_leaves.empty(); }
};

class HandingOn {
 public:
  // `hierarchy`: with the scene's bands; `leaves`: those that all groups are solved for. Both must
  // outlive it. Nothing is handed on where the plan leaves fluorescence out.
  HandingOn(const Hierarchy& hierarchy, const Snapshot& leaves, const EffectsPlan& plan);

  // What the next group found, from the first on. error: of its mean irradiance.
  void Take(const Snapshot& solved, double error);
  // The next group is dark.
  void TakeNothing() { groups_.emplace_back(); }
  // To the next group.
  HandedOn ToNext() const;

  // W/m² that a surface gives out in a band of what groups before that band's bring in their bands.
  double Radiosity(uint32_t surface, uint32_t band, std::span<const float> irradiance) const;

 private:
  // By leaf that fluoresces.
  struct Taken {
    std::vector<std::array<double, 3>> irradiance;  // by channel of the group, W/m²
    std::vector<float> spread;                      // W/m²
    double error = 0;
  };

  const Hierarchy& hierarchy_;
  const Snapshot& leaves_;
  std::vector<const BandReradiation*> of_surface_;  // empty: nothing is handed on
  std::vector<uint32_t> fluorescent_;               // places of leaves
  std::vector<Taken> groups_;
};

}  // namespace isolux
