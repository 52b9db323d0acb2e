// Panes of clear glass: thin, plane, and passed straight by what they leave of the light. They take
// no part in diffuse transport and hide nothing; a pane multiplies what crosses it.
//
// What a pane leaves at the angle of incidence θ is that of a slab with two interfaces by Fresnel's
// equations, reflections between them added up as powers, for either polarization, and their mean
// ([BornWolf99], 1.6):
//   T = (1 − R)² t/(1 − R² t²),   t = exp(−depth/cos θ'),   sin θ' = sin θ/index
// So the optical depth tells what the inside of the glass takes, and its index what the interfaces
// turn back on top of that. What is reflected counts as absorbed by the pane.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/util/bytes.h"
#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

struct Glass {
  Rgb optical_depth{0.0};  // −ln of what its inside leaves at normal incidence, by channel
  double index = 1;        // of refraction, 1 or more; 1: nothing is reflected

  bool is_grey() const {
    return optical_depth.x == optical_depth.y && optical_depth.y == optical_depth.z;
  }
  // What is left of light whose direction is at this cosine to the normal, in (0, 1].
  Rgb Transmittance(double cosine) const;
  // What is reflected of it, by both interfaces.
  Rgb Reflectance(double cosine) const;
  // The same of light that comes alike from everywhere: 2 ∫ T cos θ sin θ dθ.
  Rgb MeanTransmittance() const;
  Rgb MeanReflectance() const;
};

// −ln of a share of the light, for a glass's optical depth; of 0 the largest that counts.
double OpticalDepthOf(double share);
inline constexpr double kLargestOpticalDepth = 700;
inline constexpr double kLargestIndex = 5;

struct Pane {
  std::array<Vec3, 4> corners{};  // a convex planar polygon, in metres as the scene's vertices
  uint32_t count = 0;             // of corners, 3 or 4
  uint32_t glass = 0;             // in Glazing::glasses
  // One of the two faces by which a file models a slab: it takes the root of what the pane leaves.
  bool is_half = false;
};

struct Glazing {
  std::vector<Glass> glasses;
  std::vector<Pane> panes;

  bool exists() const { return !panes.empty(); }
  bool is_grey() const;
};

// Whether depths, indices of refraction and corners are such as can be simulated.
Status CheckGlazing(const Glazing& glazing, uint64_t most_panes);

// What of a scene's bytes tells of panes: behind all else, and only where there are some.
inline constexpr uint64_t kGlazingMagic = 0x314e415058554c49ULL;  // "ILUXPAN1": what follows
void PutGlazing(ByteWriter& out, const Glazing& glazing);
// The magic number comes next.
Status TakeGlazing(ByteReader& in, uint64_t most_panes, Glazing* glazing);

}  // namespace isolux
