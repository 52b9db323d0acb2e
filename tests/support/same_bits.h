// Solves whose patch files must be the same to the byte on any number of workers.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/local_cluster.h"

namespace isolux::testing {

// Options of a job of a few rounds, in which nodes change their homes.
inline SolveOptions Rotating(double accuracy, std::vector<double> epsilons_w) {
  SolveOptions options;
  options.accuracy = accuracy;
  options.epsilons = std::move(epsilons_w);
  options.cut_size = 40;
  options.balance = BalanceStrategy::kRotate;
  return options;
}

// The result of the first of these, each of another number of threads (4 less the workers), or a
// test that fails.
inline SolveResult SolveToSameBits(const Scene& scene, const SolveOptions& options,
                                   std::initializer_list<int> workers = {1, 3}) {
  EXPECT_TRUE(Validate(scene).ok()) << Validate(scene).message();
  SolveResult first;
  std::string reference;
  for (const int count : workers) {
    Result<SolveResult> result = SolveInProcess(scene, options, count, 4 - count);
    EXPECT_TRUE(result.has_value()) << result.error().message();
    if (!result) return {};
    const std::string bytes = BytesWithoutComments(result->patch);
    if (reference.empty()) {
      reference = bytes;
      first = *std::move(result);
    }
    EXPECT_TRUE(bytes == reference) << count << " workers";  // too long to be printed
  }
  return first;
}

}  // namespace isolux::testing
