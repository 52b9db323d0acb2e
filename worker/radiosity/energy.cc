#include "worker/radiosity/energy.h"

#include <algorithm>
#include <cmath>

namespace isolux {

Status AddEnergy(const LeafSystem& leaves, std::span<const Lanes> irradiance,
                 std::span<const double> escape, Exchange& exchange, RoundReport& report) {
  Reduction energy;
  energy.sums.resize(9);
  for (size_t i = 0; i < leaves.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double h = irradiance[i][c], rho = leaves.reflectance[i][c], e = leaves.exitance[i][c];
      energy.sums[c].Add(leaves.area_m2[i] * e);
      const double specular = leaves.specular.empty() ? 0.0 : leaves.specular[i];
      // What mirrors reflect of it is given to others.
      if (!leaves.given.empty()) {
        energy.sums[c].Add(leaves.area_m2[i] * (1 - specular) * leaves.given[i][c]);
      }
      double handed_on = rho + specular;
      if (!leaves.passed_on.empty()) {
        // It is in the exitance, but nothing new.
        energy.sums[c].Add(-leaves.area_m2[i] * leaves.passed_on[i][c]);
        handed_on += leaves.transmittance[i][c];
      }
      energy.sums[3 + c].Add(leaves.area_m2[i] * (1 - handed_on) * h);
      energy.sums[6 + c].Add(leaves.area_m2[i] * escape[i] * (e + rho * h));
    }
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(energy)));
  for (int c = 0; c < 3; ++c) {
    report.emitted_w[c] = total.sums[c].Value();
    report.absorbed_w[c] = total.sums[3 + c].Value();
    report.escaped_w[c] = total.sums[6 + c].Value();
    if (!(report.emitted_w[c] > 0)) continue;
    const double missing = report.emitted_w[c] - report.absorbed_w[c] - report.escaped_w[c] -
                           report.medium_w[c] - report.glass_w[c];
    report.energy_imbalance =
        std::max(report.energy_imbalance, std::abs(missing) / report.emitted_w[c]);
  }
  return {};
}

Result<std::array<double, 3>> AbsorbedPower(const LeafSystem& leaves,
                                            std::span<const Lanes> irradiance, bool bounces,
                                            Transport& without, Exchange& exchange) {
  std::vector<Lanes> radiosity(leaves.size()), whole(leaves.size());
  Reduction reduction;
  reduction.maxima.assign(3, 0.0);
  for (size_t i = 0; i < leaves.size(); ++i) {
    radiosity[i] = leaves.exitance[i];
    if (bounces) {
      radiosity[i] += leaves.reflectance[i] * irradiance[i];
    } else if (!leaves.given.empty()) {
      radiosity[i] += leaves.reflectance[i] * leaves.given[i];
    }
    for (int c = 0; c < 3; ++c) {
      reduction.maxima[c] = std::max(reduction.maxima[c], radiosity[i][c]);
    }
  }
  ASSIGN_OR_RETURN(const Reduction bounds, exchange.Reduce(std::move(reduction)));
  const Lanes bound{bounds.maxima[0], bounds.maxima[1], bounds.maxima[2], 0};
  RETURN_IF_ERROR(without.Irradiance(radiosity, bound, whole));
  Reduction absorbed;
  absorbed.sums.resize(3);
  for (size_t i = 0; i < leaves.size(); ++i) {
    const double specular = leaves.specular.empty() ? 0.0 : leaves.specular[i];
    Lanes arrives = irradiance[i];
    if (!leaves.given.empty()) arrives -= leaves.given[i];
    for (int c = 0; c < 3; ++c) {
      absorbed.sums[c].Add(leaves.area_m2[i] * (1 - specular) * (whole[i][c] - arrives[c]));
    }
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(absorbed)));
  return std::array{total.sums[0].Value(), total.sums[1].Value(), total.sums[2].Value()};
}

}  // namespace isolux
