// Error of the gathered irradiance against the number of links in the unit cube whose floor emits,
// beyond what a test can wait for.
//
//   cube_convergence [LINKS]    until there are so many; 300,000 unless told
//     Prints how good the reference is, a line a round, and the errors at 100, 1,000, … links,
//     drawn between the rounds on logarithmic axes, beside what is asked for.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/support/cube_reference.h"

int main(int argc, char** argv) {
  using namespace isolux;
  const double most = argc > 1 ? std::atof(argv[1]) : 300'000;
  ThreadPool pool(0);
  const testing::CubeReference reference({.coarse = 16, .fine = 48, .steps = 8, .narrowing = true},
                                         pool);
  std::printf("means of the reference within %.1g of the exact ones\n", reference.ErrorOfMeans());
  std::fflush(stdout);
  std::vector<testing::CubeRound> rounds;
  testing::SolveCube(reference, most, [&](const testing::CubeRound& round) {
    std::printf("%8.0f links: error %.4f %%, estimate %.3f %%\n", round.links, 100 * round.error,
                100 * round.estimate);
    std::fflush(stdout);
    rounds.push_back(round);
  });
  for (double links = 100; links <= most; links *= 10) {
    for (size_t i = 1; i < rounds.size(); ++i) {
      const testing::CubeRound &a = rounds[i - 1], &b = rounds[i];
      if (!(a.links <= links && links < b.links)) continue;
      const double share = std::log(links / a.links) / std::log(b.links / a.links);
      std::printf("at %.0f links: %.3f %%, asked for %.2f %%\n", links,
                  100 * a.error * std::pow(b.error / a.error, share),
                  100 * testing::AllowedInCube(links));
    }
  }
  return 0;
}
