// How wrong the gathered irradiance is, and why: for each link the error it leaves at either end
// once irradiance is gathered point by point (the variation over the receiver is then gone), summed
// as independent over the links of a leaf and of all above it, plus what these errors do to the
// ambient light of the scene. Where rows are closed for certain, what one leaf gets too much others
// lack: ambient light changes only as far as the one reflects more than the others.
#pragma once

#include <vector>

#include "worker/radiosity/closure.h"
#include "worker/radiosity/light_field.h"
#include "worker/radiosity/solver.h"

namespace isolux {

// Errors of one leaf's links are less than independent, and some terms are bounds. With this factor
// estimate/true lies in 0.7 … 3 for nine of ten runs of random rooms (docs/accuracy.md says how it
// is measured). It is up to 4 where small lamps stand close to a ceiling or a table at fine
// accuracies.
inline constexpr double kLinkErrorCalibration = 0.55;

// The error of a link by these radiosities at its ends, W/m², that of its visibility as far as it
// is in doubt; its total is the one without doubt.
LinkError DoubtedError(const Tree& tree, const Link& link, double radiosity_p, double radiosity_q);

struct LeafError {
  double spread = 0;  // range of irradiance over the leaf, W/m², summed over channels
  double error = 0;   // expected absolute error of irradiance, W/m², summed over channels
  double doubt = 0;  // Σ over links of what they bring times their doubt, W/m², over the channels
};

struct ErrorEstimate {
  std::vector<LeafError> leaves;  // own
  // Σ A |ΔH| / Σ A H over all leaves of all workers, and its parts.
  double total = 0, spread = 0, visibility = 0, coupling = 0, solver = 0;
  double change = 0;  // Σ A |H − H of the round before| / Σ A H, over the old leaves
  double drift = 0;   // |Σ A (H − H of the round before)| / Σ A H
};

// What the round before had found, to see how much has changed: a solution that still moves is not
// yet known. Empty where there was no round of the same light.
struct Previous {
  std::span<const Lanes> irradiance;  // of the old leaf at or above each own leaf
  std::span<const uint32_t> leaf;     // its number; own leaves below one old leaf follow each other
  bool is_ambient = false;            // no solution yet: this is the first round
  double coarser = 1;                 // its threshold over that of this round
};

// How far the mean irradiance still is from its limit, over how far it has moved since a round
// whose threshold was so many times as large, where errors go with the power 0.3 of the threshold:
// at most 2, for after a small step that is mostly chance.
double DriftToCome(double coarser);

// Three products. `irradiance`: H of own leaves; `given`: what of it lights bring, empty where
// there are none; `rows`: what the rows of own leaves were closed to, empty where they were not.
Result<ErrorEstimate> EstimateError(Product& product, const Tree& tree, const LeafSystem& leaves,
                                    std::span<const Lanes> irradiance,
                                    std::span<const RowMeasure> rows,
                                    std::span<const GivenIrradiance> given,
                                    const Previous& previous, const SolverResult& solved,
                                    Exchange& exchange);

}  // namespace isolux
