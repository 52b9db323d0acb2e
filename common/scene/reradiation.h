// Fluorescence: light that a surface takes in one channel and gives out in one of longer
// wavelength, in all directions alike, on the side where it arrived. Channels are red, green, blue.
#pragma once

#include "common/vec.h"

namespace isolux {

// Shares of the irradiance, in power. Light never comes out shorter than it went in (Stokes).
struct Reradiation {
  double blue_to_green = 0, blue_to_red = 0, green_to_red = 0;

  bool exists() const { return blue_to_green > 0 || blue_to_red > 0 || green_to_red > 0; }
  // What comes out, W/m².
  Rgb Of(const Rgb& irradiance) const {
    return {blue_to_red * irradiance.z + green_to_red * irradiance.y, blue_to_green * irradiance.z,
            0};
  }
  // Share of what arrives in each channel that is taken for it.
  Rgb Taken() const { return {0, green_to_red, blue_to_green + blue_to_red}; }

  bool operator==(const Reradiation&) const = default;
};

}  // namespace isolux
