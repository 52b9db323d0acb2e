// What workers tell each other in a collective operation (worker/radiosity/exchange.h) and what
// they get back: plain data, for the numerics, the protocol and the coordinator's relay alike.
//
// Where a node has several lanes (channels, probes), its lanes lie side by side.
#pragma once

#include <cstdint>
#include <vector>

#include "common/util/exact_sum.h"

namespace isolux {

// What is combined over all workers: maxima by maximum, sums exactly, counts by addition. All
// workers give vectors of the same lengths.
struct Reduction {
  std::vector<double> maxima;
  std::vector<ExactSum> sums;
  std::vector<uint64_t> counts;
};

struct ReceivedValues {
  std::vector<double> cut;      // lanes × nodes of the cut, in the order of the cut
  std::vector<double> proxies;  // lanes × wanted nodes, in the order of `wanted`, home by home
};

struct ReceivedSums {
  std::vector<int64_t> crown;  // totals over all workers
  std::vector<int64_t>
      exported;  // totals over all other workers, in the order of the exported nodes
};

}  // namespace isolux
