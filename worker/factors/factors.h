// Form factors past obstacles between all sides of a scene that take part, for `isolux factors`:
// each pair to a tolerance, with a stated error, whatever the number of threads.
//
// An end is one side of one polygon of the file; where the importer divided a face, of all its
// pieces together. C_pq is stored once for both directions, so reciprocity is exact.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/scene/scene.h"
#include "common/util/parallel.h"
#include "worker/factors/pair_factor.h"

namespace isolux {

struct FactorOptions {
  double tolerance = 1e-4;  // of a coupling, over the smaller area of the two polygons
  // Told the share of the pairs that are done, now and then, from one thread.
  std::function<void(double)> progress = {};
};

struct FactorEnd {
  uint32_t polygon = 0;  // number in the file
  Side side = Side::kFront;
  double area_m2 = 0;
  // Σ_q F over all ends: 1 in a closed enclosure, 1 minus it is what leaves through openings.
  double row_sum = 0;
  double row_sum_before = 0;  // before rows above 1 were lowered
  double row_error = 0;       // sum of the stated errors of its couplings, over the area
};

struct Factor {
  uint32_t p = 0, q = 0;  // ends, p ≤ q; equal only for a face of several pieces
  double coupling_m2 = 0;
  double error_m2 = 0;
};

struct FactorTable {
  std::vector<FactorEnd> ends;              // by polygon, front before back
  std::vector<Factor> factors;              // other than 0, by p, then q
  std::array<uint64_t, kWayCount> pairs{};  // of pieces, by how they were settled
  uint64_t above_tolerance = 0;             // pairs whose stated error is above what was asked for
  uint64_t rows_lowered = 0;                // rows that were above 1
  uint64_t rows_beyond = 0;  // of those, rows that were above 1 by several times their errors
};

// More pieces than this are refused before memory is taken: 24 bytes for each pair that may see
// each other, 5 GB for the most.
inline constexpr uint64_t kMostFactorPieces = 20'000;

Result<FactorTable> ComputeFactors(const Scene& scene, const FactorOptions& options,
                                   ThreadPool& pool);

}  // namespace isolux
