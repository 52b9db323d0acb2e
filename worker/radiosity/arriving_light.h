// What the light that an element gets says of how unevenly it gets it: over all senders together,
// since elements of one lamp each light it unevenly and all of them evenly.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/util/status.h"
#include "worker/radiosity/matvec.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Of one element, over its links and those above it, summed over channels, in units of some
// irradiance. B: radiosity of a sender, F: form factor to it, mean over the element.
struct ArrivingLight {
  double irradiance = 0;      // Σ B F
  double squares = 0;         // Σ B² F
  double range = 0;           // Σ B · range of F over the element: no less than the range of all
  double from_absorbers = 0;  // Σ B F (1 − reflectance of the sender), without clusters
  double doubt = 0;           // Σ B F · doubt of the link

  // Mean radiosity of the senders, by what they bring.
  double BrightnessOfSenders() const { return irradiance > 0 ? squares / irradiance : 0; }

  // Twice the most that the irradiance deviates over the element: form factors of a point add up to
  // no more than 1, so that of its H = Σ B F the square is at most Σ B² F. Where the points get
  // nothing or the same, one half of them each, that is their range.
  double LargestRange() const;

  // What of this light comes back to the senders, beyond what even radiosity brings, and is
  // absorbed there: the element is brightest where it also sees the senders best. With H of its
  // points, ρ (mean H² − (mean H)²) / B. Always more, so that such errors add up: they rule where
  // lamps hang close below a ceiling.
  double UnevenReturn(double reflectance) const;
};

// Two products. `radiosity`: of own leaves, W/m²; `unit`: W/m². One a leaf.
Result<std::vector<ArrivingLight>> SumArrivingLight(Product& product, const Tree& tree,
                                                    std::span<const Single> radiosity, double unit);

}  // namespace isolux
