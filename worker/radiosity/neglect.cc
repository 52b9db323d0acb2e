#include "worker/radiosity/neglect.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/hierarchy/mirrors.h"
#include "worker/radiosity/pane_light.h"
#include "worker/radiosity/transport.h"

namespace isolux {
namespace {

// Of the solve of light from everywhere; what it leaves is made up for.
constexpr double kAccuracy = 0.02;
constexpr size_t kMostSurfaces = 1 << 18;     // of each of which a number travels
constexpr double kAccuracyWithLobes = 0.001;  // with these surfaces may reflect nearly all

double SumOf(const Lanes& v) { return v[0] + v[1] + v[2]; }
double LargestOf(const Lanes& v) { return std::max({v[0], v[1], v[2]}); }

// Share of each own leaf's light that its material reflects as a mirror, simulated or not.
std::vector<double> SpecularShares(const Hierarchy& hierarchy, const Product& product) {
  std::vector<double> of_surface(hierarchy.surfaces().size(), 0.0);
  for (const MirrorPlane& plane : MirrorPlanesOf(hierarchy)) {
    for (const uint32_t surface : plane.surfaces) of_surface[surface] = plane.share;
  }
  std::vector<double> shares;
  for (const uint32_t node : product.active().leaves) {
    shares.push_back(of_surface[product.tree().node(node).id.surface]);
  }
  return shares;
}

// Of each own leaf's light, what reaches other places for its lobe, of any channel at most, and
// what of that its reflectance lacks.
struct Lobes {
  std::vector<double> moved;  // twice what it reflects where the reflectance holds that
  std::vector<double> lacking;
};
Lobes LobesOf(const Hierarchy& hierarchy, const Product& product) {
  const Scene& scene = hierarchy.scene();
  Lobes lobes;
  for (const uint32_t node : product.active().leaves) {
    const Surface& surface = product.tree().surface_of(node);
    const Gloss& gloss = scene.materials[scene.polygons[surface.polygon].material].gloss;
    const double share = std::max({gloss.share.x, gloss.share.y, gloss.share.z});
    lobes.moved.push_back(gloss.kept ? 2 * share : share);
    lobes.lacking.push_back(gloss.kept ? 0.0 : share);
  }
  return lobes;
}

Lanes TakenBy(const LeafSystem& leaves, size_t i) {
  if (leaves.reradiation.empty()) return Lanes{};
  const Rgb taken = leaves.reradiation[i].Taken();
  return Lanes{taken.x, taken.y, taken.z, 0};
}

// Of what arrives at a leaf, by channel, what goes by way of this effect; none of those that take
// light between leaves.
Lanes ShareOf(const std::string& effect, const LeafSystem& leaves, double specular, double lobe,
              size_t i) {
  if (effect == "mirrors") return Lanes{specular, specular, specular, 0};
  if (effect == "gloss") return Lanes{lobe, lobe, lobe, 0};
  if (effect == "sheets" && !leaves.transmittance.empty()) return leaves.transmittance[i];
  return effect == "fluorescence" ? TakenBy(leaves, i) : Lanes{};
}

// What is no lamp's own of what a leaf radiates, W/m² over the channels, with the error of it.
double ReflectedBy(const LeafSystem& leaves, size_t i, const Lanes& irradiance, double error,
                   const Rgb& emitted) {
  const Lanes own{emitted.x, emitted.y, emitted.z, 0};
  const double passed = std::max(0.0, SumOf(leaves.exitance[i] - own));
  return passed + SumOf(leaves.reflectance[i] * irradiance) +
         LargestOf(leaves.reflectance[i]) * error;
}

// By panes and the medium, W over the channels. What the medium takes of every link adds up; panes
// are crossed by few of the rays that a coarse round has.
double TakenOnTheWay(const std::string& effect, const Hierarchy& hierarchy,
                     const RoundReport& report, double error,
                     std::span<const double> reflected_w_m2) {
  if (effect == "clear-glass") return MostTakenByPanes(hierarchy, reflected_w_m2);
  if (effect != "medium") return 0;
  double medium_w = 0;
  for (const double channel : report.medium_w) medium_w += std::abs(channel);
  return (1 + error) * medium_w;
}

// Leaves that emit 1 in one channel and hand on as much as in that in which they hand on most. What
// is reradiated arrives in other channels: by the row it is reflected. `more`: what they reflect
// beside; empty: nothing.
LeafSystemOf<Single> EmittingOne(const LeafSystem& leaves, std::span<const double> specular,
                                 std::span<const double> more) {
  LeafSystemOf<Single> unit;
  unit.area_m2 = leaves.area_m2;
  unit.closure = leaves.closure;
  unit.inheritance = leaves.inheritance;
  unit.returned = leaves.returned;
  unit.specular = leaves.specular;
  for (size_t i = 0; i < leaves.size(); ++i) {
    double share = LargestOf(leaves.reflectance[i] + TakenBy(leaves, i));
    if (leaves.specular.empty()) share += specular[i];
    if (!more.empty()) share += more[i];
    unit.reflectance.push_back(Single{share});
    unit.exitance.push_back(Single{1});
  }
  for (const Lanes& t : leaves.transmittance) unit.transmittance.push_back(Single{LargestOf(t)});
  return unit;
}

// What leaves radiate that emit 1 where this arrives.
Result<std::vector<Single>> RadiosityOf(Product& product, const LeafSystemOf<Single>& unit,
                                        std::span<const Single> irradiance) {
  std::vector<Single> radiosity(unit.size(), Single{0});
  if (product.tree().sheets() != nullptr) {
    RETURN_IF_ERROR(product.Behind(irradiance, std::span<Single>(radiosity)));
    for (size_t i = 0; i < unit.size(); ++i) radiosity[i] *= unit.transmittance[i];
  }
  for (size_t i = 0; i < unit.size(); ++i) {
    radiosity[i] += Single{1} + unit.reflectance[i] * irradiance[i];
  }
  return radiosity;
}

}  // namespace

Result<double> LargestAmplification(Product& product, const LeafSystemOf<Single>& unit,
                                    double accuracy, const SolveFunction<Single>& solve,
                                    Exchange& exchange) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const std::vector<Single> dark(unit.size(), Single{0});
  ASSIGN_OR_RETURN(const auto solved, solve(unit, dark, accuracy));
  if (solved.indefinite) return kNone;
  ASSIGN_OR_RETURN(const auto radiosity, RadiosityOf(product, unit, solved.irradiance));
  Reduction largest;
  largest.maxima = {0};
  for (const Single& b : radiosity) largest.maxima[0] = std::max(largest.maxima[0], b[0]);
  ASSIGN_OR_RETURN(const Reduction most, exchange.Reduce(std::move(largest)));

  std::vector<Single> arriving(unit.size());
  LinkTransportOf<Single> transport(product, unit);
  RETURN_IF_ERROR(transport.Irradiance(radiosity, Single{most.maxima[0]}, arriving));
  ASSIGN_OR_RETURN(const auto next, RadiosityOf(product, unit, arriving));
  Reduction growth;
  growth.maxima = {0};
  for (size_t i = 0; i < unit.size(); ++i) {
    growth.maxima[0] = std::max(growth.maxima[0], next[i][0] - radiosity[i][0]);
  }
  ASSIGN_OR_RETURN(const Reduction grown, exchange.Reduce(std::move(growth)));
  const double least = 1 - grown.maxima[0];  // of b − KFb
  return least > 0 ? std::max(1.0, most.maxima[0] / least) : kNone;
}

Result<std::vector<MeasuredEffect>> MeasureNeglect(
    std::span<const std::string> effects, const Hierarchy& hierarchy, const LeafSystem& leaves,
    std::span<const Lanes> irradiance, const ErrorEstimate& errors, const RoundReport& report,
    Product& product, const SolveFunction<Single>& solve, Exchange& exchange) {
  const std::vector<double> specular = SpecularShares(hierarchy, product);
  const Lobes lobes = LobesOf(hierarchy, product);
  Reduction power;
  power.sums.resize(1 + effects.size());  // that arrives; by way of each effect
  // Of what is reflected, by surface where panes look at them.
  const bool by_surface = std::ranges::find(effects, "clear-glass") != effects.end() &&
                          hierarchy.surfaces().size() <= kMostSurfaces;
  power.maxima.resize(by_surface ? hierarchy.surfaces().size() : 1);
  for (size_t i = 0; i < leaves.size(); ++i) {
    power.sums[0].Add(leaves.area_m2[i] * SumOf(irradiance[i]));
    const uint32_t node = product.active().leaves[i];
    double& reflected = power.maxima[by_surface ? product.tree().node(node).id.surface : 0];
    reflected = std::max(reflected, ReflectedBy(leaves, i, irradiance[i], errors.leaves[i].error,
                                                product.tree().surface_of(node).exitance));
    for (size_t k = 0; k < effects.size(); ++k) {
      const Lanes share = ShareOf(effects[k], leaves, specular[i], lobes.moved[i], i);
      power.sums[1 + k].Add(leaves.area_m2[i] * (SumOf(share * irradiance[i]) +
                                                 LargestOf(share) * errors.leaves[i].error));
    }
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange.Reduce(std::move(power)));
  // Lobes add to what is handed on, where they alone are asked for.
  double amplification = 1, with_lobes = 1;
  for (const bool glossy : {false, true}) {
    if (std::ranges::none_of(effects, [&](const auto& e) { return (e == "gloss") == glossy; })) {
      continue;
    }
    const LeafSystemOf<Single> unit =
        EmittingOne(leaves, specular, glossy ? lobes.lacking : std::vector<double>());
    ASSIGN_OR_RETURN((glossy ? with_lobes : amplification),
                     LargestAmplification(product, unit, glossy ? kAccuracyWithLobes : kAccuracy,
                                          solve, exchange));
  }
  const double arriving_w = total.sums[0].Value();
  std::vector<MeasuredEffect> measured;
  for (size_t k = 0; k < effects.size(); ++k) {
    if (effects[k] == "gloss" && !std::isfinite(with_lobes)) continue;
    const double power_w = total.sums[1 + k].Value() +
                           TakenOnTheWay(effects[k], hierarchy, report, errors.total, total.maxima);
    measured.push_back({.name = effects[k],
                        .share = arriving_w > 0 ? power_w / arriving_w : 0,
                        .amplification = effects[k] == "gloss" ? with_lobes : amplification});
  }
  return measured;
}

}  // namespace isolux
