// A scene solved by a job of one worker in this process, or a test that fails.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/support/local_cluster.h"

namespace isolux::testing {

inline SolveOptions ToAccuracy(double accuracy) {
  SolveOptions options;
  options.accuracy = accuracy;
  return options;
}

inline SolveResult SolveScene(const Scene& scene, const SolveOptions& options, int workers = 1) {
  EXPECT_TRUE(Validate(scene).ok()) << Validate(scene).message();
  Result<SolveResult> result = SolveInProcess(scene, options, workers, 2);
  EXPECT_TRUE(result.has_value()) << result.error().message();
  return result ? std::move(*result) : SolveResult{};
}

inline SolveResult SolveScene(const Scene& scene, double accuracy) {
  return SolveScene(scene, ToAccuracy(accuracy));
}

// `effects`: as --effects says it.
inline SolveResult SolveScene(const Scene& scene, double accuracy, const std::string& effects,
                              int workers = 1) {
  SolveOptions options = ToAccuracy(accuracy);
  options.effects = effects;
  return SolveScene(scene, options, workers);
}

// Of the power that power_of(result) adds up, the share that is missing without the effect: by the
// same thresholds.
template <typename PowerOf>
double CostOfNeglecting(const Scene& scene, const std::string& effect, const PowerOf& power_of) {
  SolveOptions options;
  options.epsilons = {1e-2, 1e-3};
  options.effects = "-" + effect;
  const double without = power_of(SolveScene(scene, options));
  options.effects = "+" + effect;
  return 1 - without / power_of(SolveScene(scene, options));
}

}  // namespace isolux::testing
