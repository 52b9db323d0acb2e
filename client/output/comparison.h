// How far a solution is from a better one, or from irradiance that is known at points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/output/reference_points.h"
#include "common/scene/patch_file.h"

namespace isolux {

// e(x) = Σ_c |ΔH|, h(x) = Σ_c H of the better one, of the gathered irradiance interpolated over the
// output mesh; means over the area of all surfaces that take part.
struct Comparison {
  double l1_relative = 0;    // mean e / mean h
  double rms_relative = 0;   // √(mean e²) / mean h
  double max_relative = 0;   // largest e / mean h
  double p95_local = 0;      // 95th percentile of e / max(h, 5 % of the mean h)
  double bias_relative = 0;  // mean Σ_c ΔH / mean h, signed
  uint64_t samples = 0;
  uint64_t unmatched = 0;  // points on surfaces that one of the solutions left out as dark
};

// Adds up what is found at points that are uniform over the surfaces.
class ErrorTally {
 public:
  // `deviation`: standard error of `expected` per channel; what it adds to |ΔH| on average is taken
  // off.
  void Add(const Rgb& found, const Rgb& expected, const Rgb& deviation = Rgb(0.0));
  // The point lies on no surface of the solution: found is dark.
  void AddUnmatched() { ++unmatched_; }
  // Fails where nothing was expected anywhere: then there is nothing to be relative to.
  Result<Comparison> Finish() const;

 private:
  std::vector<double> errors_, values_;  // e and h of each point
  double bias_ = 0;
  uint64_t unmatched_ = 0;
};

struct ComparisonOptions {
  uint64_t samples = 1 << 18;
  uint64_t seed = 1;
};

// Of `a` from `b` at seeded points, one in each of equal parts of the area. Points are matched by
// file polygon, side and position. Surfaces that only one solution has count as dark in the other.
// Fails where the second has no irradiance to be relative to.
Result<Comparison> Compare(const PatchFile& a, const PatchFile& b,
                           const ComparisonOptions& options);

// Of a spectral band, as of all light; what is expected of it is its mean irradiance.
struct BandComparison {
  double l1_relative = 0, rms_relative = 0, max_relative = 0;
  bool dark = false;  // in the better one: then these are 0
};
struct BandsComparison {
  double l1_relative = 0;  // of all bands together: e and h are sums over them
  std::vector<BandComparison> bands;
};

// Whether both have the same spectral bands.
bool HaveSameBands(const PatchFile& a, const PatchFile& b);

// As Compare, at the same points, of two solutions with the same bands.
Result<BandsComparison> CompareBands(const PatchFile& a, const PatchFile& b,
                                     const ComparisonOptions& options);

// Of `file` from what is known at points, which are taken for uniform over the surfaces. A point on
// no face counts as dark.
Result<Comparison> Compare(const PatchFile& file, std::span<const ReferencePoint> points);

}  // namespace isolux
