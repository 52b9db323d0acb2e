// What a result states, against a finer one, where light is most uneven: a lamp that shines on the
// wall close behind it.
#include <gtest/gtest.h>

#include "client/output/comparison.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

Result<SolveResult> Solve(double accuracy) {
  SolveOptions options;
  options.accuracy = accuracy;
  return SolveInProcess(RoomWithStrip(0.002, 0.2), options, 1, 2);
}

// The lamp is a hundred times as wide as its distance: behind all but its edges the wall is lit
// evenly, and returns what even radiosity returns, however many elements the lamp has. What each
// of these does alone is uneven; an estimate that takes them one by one states four times the
// error, and asks for 120,000 links for 20 % and a million for 10 %.
TEST(EstimateTest, ManyElementsOfALampLightEvenly) {
  const auto finer = Solve(0.05);
  ASSERT_TRUE(finer.has_value()) << finer.error().message();
  for (const double accuracy : {0.2, 0.1}) {
    const auto run = Solve(accuracy);
    ASSERT_TRUE(run.has_value()) << run.error().message();
    const auto compared = Compare(run->patch, finer->patch, {});
    ASSERT_TRUE(compared.has_value()) << compared.error().message();
    const RoundSummary& last = run->summary.rounds.back();
    std::printf("asked %g: stated %.4f, off by %.4f, %lu links\n", accuracy, last.error_estimate,
                compared->l1_relative, last.links);
    EXPECT_LE(last.error_estimate, accuracy);
    EXPECT_LE(compared->l1_relative, accuracy);
    EXPECT_LE(last.error_estimate, 3 * compared->l1_relative);
    EXPECT_GE(last.error_estimate, 0.7 * compared->l1_relative);
    EXPECT_LE(last.links, 20000U);
  }
}

}  // namespace
}  // namespace isolux::testing
