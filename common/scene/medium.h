// A medium that fills the scene and absorbs light on its way: smoke, mist, water, hot gas that is
// taken to be dark. What it takes from light of one channel over a way of r metres is 1 − exp(−κ r)
// (Bouguer, Lambert, Beer); it scatters and emits nothing. Light from outside, of suns, directions
// and the sky, meets it from where it enters the box around all polygons.
#pragma once

#include <algorithm>

#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

struct Medium {
  Rgb extinction_per_m{0.0};  // κ of each channel, 1/m, 0 or more

  bool exists() const {
    return extinction_per_m.x > 0 || extinction_per_m.y > 0 || extinction_per_m.z > 0;
  }
  bool is_grey() const {
    return extinction_per_m.x == extinction_per_m.y && extinction_per_m.y == extinction_per_m.z;
  }
  double largest_per_m() const {
    return std::max({extinction_per_m.x, extinction_per_m.y, extinction_per_m.z});
  }
  // What is left of light after so many metres.
  Rgb Along(double metres) const;
};

// 1/m, beyond which a medium is taken for a mistake of units.
inline constexpr double kLargestExtinction = 1e6;
Status CheckMedium(const Medium& medium);

// e^−x for x ≥ 0, the same bits on every machine; relative error below 1e-15, 0 beyond 700.
double ExpOfMinus(double x);

}  // namespace isolux
