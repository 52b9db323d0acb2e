#include "worker/radiosity/arriving_light.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

// Variance of the irradiance over an element, over the most that it can be, mean · (range − mean):
// 1 where there are but two values, 1/3 where it grows evenly from 0.
constexpr double kShareOfVariance = 0.5;

// Of sums as integers. Near lamps they are many times the unit: squares from 2^24 on count apart.
constexpr double kScale = 0x1p20, kLargeSquare = 0x1p24, kMost = 0x1p50;

double MeanReflectance(const Tree& tree, uint32_t node) {
  const Rgb& reflectance = tree.surface_of(node).reflectance;
  return (reflectance.x + reflectance.y + reflectance.z) / 3;
}

Lanes Scaled(double a, double b, double small_square, double large_square) {
  return Lanes{std::min(kMost, a * kScale), std::min(kMost, b * kScale), small_square * kScale,
               std::min(kMost, large_square)};
}

// What a sender of radiosity x brings by a link.
struct Brought {
  double irradiance = 0, range = 0, absorbed = 0, doubt = 0;
};

Brought BroughtBy(const Tree& tree, const Link& link, uint32_t sender, double x,
                  double inverse_area, double variation) {
  Brought brought;
  brought.irradiance = x * link.coupling_m2() * inverse_area;
  brought.doubt = x * link.unoccluded_m2 * link.doubt() * inverse_area;
  if (tree.is_cluster(link.p) || tree.is_cluster(link.q)) return brought;
  brought.range = x * variation * link.visibility();
  brought.absorbed = brought.irradiance * (1 - MeanReflectance(tree, sender));
  return brought;
}

}  // namespace

double ArrivingLight::LargestRange() const {
  return 2 * std::sqrt(std::max(0.0, squares - irradiance * irradiance));
}

double ArrivingLight::UnevenReturn(double reflectance) const {
  const double brightness = BrightnessOfSenders();
  const double varies = std::min(range, brightness) - irradiance;
  if (!(varies > 0)) return 0;
  return reflectance * kShareOfVariance * from_absorbers / brightness * varies;
}

Result<std::vector<ArrivingLight>> SumArrivingLight(Product& product, const Tree& tree,
                                                    std::span<const Single> radiosity,
                                                    double unit) {
  using Inherit = Product::Inherit;
  const auto sum = [&](Inherit second, const auto& kernel) -> Result<std::vector<IntLanes>> {
    std::vector<IntLanes> sums(radiosity.size());
    RETURN_IF_ERROR(product.Sums<IntLanes>(
        radiosity, {Inherit::kWhole, second, Inherit::kWhole, Inherit::kWhole},
        [&](const Link& link, const Slots::Ends& ends, double xp, double xq, Lanes& to_p,
            Lanes& to_q) {
          xp /= unit;
          xq /= unit;
          const double at_p = product.inverse_area(ends.p), at_q = product.inverse_area(ends.q);
          to_p = kernel(BroughtBy(tree, link, link.q, xq, at_p, link.variation_p), xq);
          to_q = kernel(BroughtBy(tree, link, link.p, xp, at_q, link.variation_q), xp);
        },
        std::span<IntLanes>(sums)));
    return sums;
  };
  ASSIGN_OR_RETURN(const auto light, sum(Inherit::kHalf, [](const Brought& brought, double x) {
                     const double square = brought.irradiance * x;
                     const bool large = square >= kLargeSquare;
                     return Scaled(brought.irradiance, brought.range, large ? 0 : square,
                                   large ? square : 0);
                   }));
  ASSIGN_OR_RETURN(const auto rest, sum(Inherit::kWhole, [](const Brought& brought, double) {
                     return Scaled(brought.absorbed, brought.doubt, 0, 0);
                   }));
  std::vector<ArrivingLight> arriving(radiosity.size());
  for (size_t i = 0; i < arriving.size(); ++i) {
    const auto of = [](int64_t n) { return static_cast<double>(n) / kScale; };
    arriving[i] = {of(light[i][0]), of(light[i][2]) + static_cast<double>(light[i][3]),
                   of(light[i][1]), of(rest[i][0]), of(rest[i][1])};
  }
  return arriving;
}

}  // namespace isolux
