#include "worker/radiosity/absorbers.h"

#include "worker/radiosity/energy.h"
#include "worker/radiosity/transport.h"

namespace isolux {

std::optional<Medium> AbsorbingMedium(const Scene& scene, const EffectsPlan& plan) {
  if (!plan.medium || !scene.medium.exists()) return {};
  Medium medium = scene.medium;
  if (plan.channels == 1) medium.extinction_per_m = Rgb(GreyOf(medium.extinction_per_m));
  return medium;
}

std::optional<Panes> AbsorbingPanes(const Scene& scene, const EffectsPlan& plan, double extent_m) {
  if (!plan.glass || !scene.glazing.exists()) return {};
  return Panes(scene.glazing, extent_m, plan.channels == 1);
}

Status CheckSolver(SolverMethod solver, bool medium, bool panes) {
  if (solver != SolverMethod::kGaussSeidel && solver != SolverMethod::kSouthwell) return {};
  if (medium) {
    return {StatusCode::kInvalidArgument,
            "solver: gauss-seidel and southwell know of no absorbing medium; take cg, or leave the "
            "medium out by --effects=-medium"};
  }
  if (panes) {
    return {StatusCode::kInvalidArgument,
            "solver: gauss-seidel and southwell know of no panes of glass; take cg, or leave them "
            "out by --effects=-clear-glass"};
  }
  return {};
}

Status AddAbsorbedPower(const RefineScene& between, const LeafSystem& leaves,
                        std::span<const Lanes> irradiance, bool bounces, Product& product,
                        Exchange& exchange, RoundReport& report) {
  const auto without_panes = [&](const Medium* medium) -> Result<std::array<double, 3>> {
    product.SetMedium(medium);
    product.SetPanes(nullptr);
    LinkTransport transport(product, leaves);
    return AbsorbedPower(leaves, irradiance, bounces, transport, exchange);
  };
  if (between.panes != nullptr) {
    ASSIGN_OR_RETURN(report.glass_w, without_panes(between.medium));
  }
  if (between.medium != nullptr) {
    ASSIGN_OR_RETURN(report.medium_w, without_panes(nullptr));
    for (int c = 0; c < 3; ++c) report.medium_w[c] -= report.glass_w[c];
  }
  return {};
}

}  // namespace isolux
