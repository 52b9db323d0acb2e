#include "worker/radiosity/one_channel.h"

namespace isolux {
namespace {

Rgb ToRgb(const Lanes& v) { return {v[0], v[1], v[2]}; }

Single Weighted(const Lanes& v, const Rgb& weights) {
  return Single{v[0] * weights.x + v[1] * weights.y + v[2] * weights.z};
}

}  // namespace

LeafSystemOf<Single> ToOneChannel(const LeafSystem& leaves, const EffectsPlan& plan) {
  LeafSystemOf<Single> grey;
  grey.area_m2 = leaves.area_m2;
  grey.closure = leaves.closure;
  grey.inheritance = leaves.inheritance;
  grey.returned = leaves.returned;
  grey.specular = leaves.specular;
  grey.reflectance.reserve(leaves.size());
  grey.exitance.reserve(leaves.size());
  for (size_t i = 0; i < leaves.size(); ++i) {
    grey.reflectance.push_back(Single{GreyOf(ToRgb(leaves.reflectance[i]))});
    grey.exitance.push_back(Weighted(leaves.exitance[i], plan.exitance_weights));
  }
  for (const Lanes& t : leaves.transmittance) {
    grey.transmittance.push_back(Single{GreyOf(ToRgb(t))});
  }
  for (const Lanes& h : leaves.given) grey.given.push_back(Weighted(h, plan.exitance_weights));
  return grey;
}

std::vector<Single> ToOneChannel(std::span<const Lanes> irradiance, const EffectsPlan& plan) {
  std::vector<Single> grey;
  grey.reserve(irradiance.size());
  for (const Lanes& h : irradiance) grey.push_back(Weighted(h, plan.exitance_weights));
  return grey;
}

SolverResult InColour(const SolverResultOf<Single>& grey, const EffectsPlan& plan) {
  SolverResult result;
  const Rgb& colour = plan.light_colour;
  const Lanes lanes{colour.x, colour.y, colour.z, 0};
  result.irradiance.reserve(grey.irradiance.size());
  for (const Single& h : grey.irradiance) result.irradiance.push_back(h[0] * lanes);
  result.iterations = grey.iterations;
  result.products = grey.products;
  result.again = grey.again;
  result.residual = grey.residual;
  result.largest_eigenvalue = grey.largest_eigenvalue;
  result.neglected = plan.grey_error;
  result.indefinite = grey.indefinite;
  return result;
}

}  // namespace isolux
