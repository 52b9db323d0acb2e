// Error of the gathered irradiance against the number of links, in a unit cube whose floor emits:
// no shadows, so what is left is transport and gather alone. `cube_convergence` goes on from here.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/cube_reference.h"

namespace isolux::testing {
namespace {

const CubeReference& Reference() {
  static const CubeReference reference = [] {
    ThreadPool pool(2);
    return CubeReference({}, pool);
  }();
  return reference;
}

TEST(CubeConvergence, ReferenceHasTheExactMeans) { EXPECT_LT(Reference().ErrorOfMeans(), 1e-3); }

TEST(CubeConvergence, ErrorFallsWithTheLinks) {
  CubeRound first, last;
  SolveCube(Reference(), 20'000, [&](const CubeRound& round) {
    std::printf("%7.0f links: error %.3f %%, allowed %.3f %%, estimate %.3f %%\n", round.links,
                100 * round.error, 100 * AllowedInCube(round.links), 100 * round.estimate);
    last = round;
    if (round.links < 100) return;
    if (first.links == 0) first = round;
    EXPECT_LE(round.error, AllowedInCube(round.links)) << round.links << " links";
    EXPECT_GT(round.estimate, 0.5 * round.error) << round.links << " links";
    EXPECT_LT(round.estimate, 10 * round.error) << round.links << " links";
  });
  const double exponent = std::log(first.error / last.error) / std::log(last.links / first.links);
  std::printf("error falls like links^-%.2f\n", exponent);
  EXPECT_GT(exponent, 0.1);
}

}  // namespace
}  // namespace isolux::testing
