// What a pane of glass leaves of the light, against reflections added up one by one.
#include "common/scene/glazing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/glass.h"

namespace isolux::testing {
namespace {

using std::numbers::pi;

// Light that goes to and fro between the interfaces of a slab, step by step, for either
// polarization: what comes out behind and before.
struct Slab {
  double passes = 0, returns = 0;
};
Slab FollowedThrough(double inside, double index, double angle) {
  const double within = std::asin(std::sin(angle) / index);
  Slab slab;
  for (const bool along : {false, true}) {
    double r = (index - 1) / (index + 1);
    if (angle > 0) {
      r = along ? std::tan(angle - within) / std::tan(angle + within)
                : std::sin(angle - within) / std::sin(angle + within);
    }
    const double turned = r * r, left = std::pow(inside, 1 / std::cos(within));
    slab.returns += 0.5 * turned;
    double light = 0.5 * (1 - turned) * left;
    for (int k = 0; k < 4000; ++k) {
      (k % 2 == 0 ? slab.passes : slab.returns) += light * (1 - turned);
      light *= turned * left;
    }
  }
  return slab;
}

TEST(Glass, ASlabLeavesWhatGoesToAndFroInIt) {
  for (const double index : {1.33, 1.5, 2.4}) {
    for (const double inside : {1.0, 0.8, 0.05}) {
      const Glass glass = GlassOf(Rgb(inside), index);
      for (const double degrees : {0.0, 20.0, 56.3, 75.0, 88.0, 89.5}) {
        const Slab slab = FollowedThrough(inside, index, degrees * pi / 180);
        const double cosine = std::cos(degrees * pi / 180);
        EXPECT_NEAR(glass.Transmittance(cosine).x, slab.passes, 1e-7) << index << " " << degrees;
        EXPECT_NEAR(glass.Reflectance(cosine).x, slab.returns, 1e-7) << index << " " << degrees;
      }
    }
  }
  // Straight on, clear: 2n/(n² + 1). Nothing is lost in clear glass.
  const Glass clear = GlassOf(Rgb(1), 1.5);
  EXPECT_NEAR(clear.Transmittance(1).x, 3 / 3.25, 1e-15);
  for (const double cosine : {1.0, 0.6, 0.1, 1e-3}) {
    EXPECT_NEAR(clear.Transmittance(cosine).x + clear.Reflectance(cosine).x, 1, 1e-14);
  }
  EXPECT_EQ(clear.Transmittance(0), Rgb(0.0));
  // Without an index the file's number is all there is, over a longer way aslant.
  const Glass film = GlassOf({0.9, 0.5, 0}, 1);
  EXPECT_NEAR(film.Transmittance(1).x, 0.9, 1e-15);
  EXPECT_NEAR(film.Transmittance(0.5).y, 0.25, 1e-15);
  EXPECT_EQ(film.Transmittance(1).z, 0);
  EXPECT_EQ(film.Reflectance(0.3), Rgb(0.0));
}

TEST(Glass, MeansOverTheHemisphereAreThoseOfIntegrals) {
  for (const double inside : {1.0, 0.7}) {
    const Glass glass = GlassOf(Rgb(inside), 1.5);
    Slab mean;
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i) {
      const double angle = (i + 0.5) / kSteps * pi / 2;
      const double weight = std::sin(2 * angle) * pi / 2 / kSteps;
      const Slab slab = FollowedThrough(inside, 1.5, angle);
      mean.passes += weight * slab.passes;
      mean.returns += weight * slab.returns;
    }
    EXPECT_NEAR(glass.MeanTransmittance().x, mean.passes, 2e-5);
    EXPECT_NEAR(glass.MeanReflectance().x, mean.returns, 3e-5);
  }
}

}  // namespace
}  // namespace isolux::testing
