// What leaves an element arrives somewhere or leaves the scene: the row of a leaf must add up to
// its area less the share that escapes. Couplings with errors miss that, and the solution magnifies
// what they miss by 1/(1 − ρ). The closure scales C → D C D, one factor a leaf, which keeps it
// symmetric and positive ([KnightRuiz13]).
//
// What falls on a mirror arrives once more behind it: with k_s the specular share of the leaf at
// the other end, Σ C (1 − k_s) is the area less what escapes, over links through mirrors and others
// alike. So power is conserved: by symmetry Σ A (1 − k_s) H = Σ A (1 − o) B.
//
// What rows lack in the end, of which 1/(1 − ρ) times as much would be lost, comes back to the leaf
// itself, as if from surfaces as bright as it is. Then rows add up to the last bit, for any
// reflectance; lamps, which are brighter than all around them, go without.
#pragma once

#include "worker/radiosity/solver.h"

namespace isolux {

// What rays independent of the links say of the row of a leaf, over its area: 1, for certain, in a
// closed component; where light escapes as far off as its standard deviation.
struct RowMeasure {
  double sum = 1, deviation = 0;
};

struct ClosureSummary {
  uint32_t products = 0;
  // Of leaves without any factor, how far a row is from what it must be, as share; and in the end.
  double worst_before = 0, worst_after = 0;
  // Of each own leaf, how far its row is from what it must be in the end, as share: `off` where
  // that is made or lost, `misplaced` where it comes back to the leaf instead.
  std::vector<double> off, misplaced;
  // By how much each own leaf's row must change, as share of what it is without any factor: d² − 1
  // if D C D were to do it alone.
  std::vector<double> bend;
};

struct ClosureTolerance {
  double row = 1e-3;  // how far a row may be from what it must be, as share
  // Of the irradiance, what black leaves radiate at most: if all were, so much of all light at most
  // times what rows are off by is lost or made.
  double black = 0;
};

// What rows may be made to add up to.
enum class RowsMay { kRiseAndFall, kFall };

// Sets leaves.returned after it has improved leaves.inheritance and leaves.closure, starting from
// what is there, until every row that counts is what it must be to the tolerance, or twenty
// products are spent. That is, where `measured` is not certain, the mean of what the links and what
// the rays say, weighted by how far rows scatter and rays may be off: pulling each row by a share
// of its distance leaves the mean of all rows where it is, which holding rows within bounds does
// not, since they are off by more above than below. `irradiance`: at own leaves as far as it is
// known, to tell what is a lamp, and what is black.
Result<ClosureSummary> Close(Product& product, LeafSystem& leaves,
                             std::span<const Lanes> irradiance,
                             std::span<const RowMeasure> measured, RowsMay rows_may,
                             const ClosureTolerance& tolerance, Exchange& exchange);

}  // namespace isolux
