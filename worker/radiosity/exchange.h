// How a shard meets the others: a few collective operations, each called by every worker in the
// same order. The numerics are written once against this interface; with NullExchange they are a
// one-process solver.
//
// Values travel out (from the home of a node to those who keep a proxy of it), integer sums travel
// back. A value is sent once per node, worker and exchange; geometry never.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/collectives.h"
#include "common/hierarchy/node_id.h"
#include "common/util/status.h"

namespace isolux {

class Exchange {
 public:
  virtual ~Exchange() = default;

  virtual Result<Reduction> Reduce(Reduction mine) = 0;

  // Once a round. wanted[w]: ids, sorted, of the nodes homed at worker w whose values are needed
  // here (empty for oneself). Returns the ids of own nodes that others want, sorted, each once: the
  // exported nodes. Clusters above the cut are never wanted: their values follow from the cut's.
  virtual Result<std::vector<NodeId>> Subscribe(const std::vector<std::vector<NodeId>>& wanted) = 0;

  // Once per product, in this order. Sends return at once; local work goes on in between.
  virtual Status SendValues(std::span<const double> own_cut, std::span<const double> exported) = 0;
  virtual Result<ReceivedValues> ReceiveValues() = 0;
  virtual Status SendSums(std::span<const int64_t> crown, std::span<const int64_t> proxies) = 0;
  virtual Result<ReceivedSums> ReceiveSums() = 0;

  // True when the job was cancelled meanwhile; asked between pieces of long work.
  virtual bool Cancelled() const { return false; }
};

// One worker, nobody else.
class NullExchange final : public Exchange {
 public:
  Result<Reduction> Reduce(Reduction mine) override { return mine; }
  Result<std::vector<NodeId>> Subscribe(const std::vector<std::vector<NodeId>>&) override {
    return std::vector<NodeId>{};
  }
  Status SendValues(std::span<const double> own_cut, std::span<const double>) override {
    cut_.assign(own_cut.begin(), own_cut.end());
    return {};
  }
  Result<ReceivedValues> ReceiveValues() override { return ReceivedValues{cut_, {}}; }
  Status SendSums(std::span<const int64_t> crown, std::span<const int64_t>) override {
    crown_.assign(crown.begin(), crown.end());
    return {};
  }
  Result<ReceivedSums> ReceiveSums() override { return ReceivedSums{crown_, {}}; }

 private:
  std::vector<double> cut_;
  std::vector<int64_t> crown_;
};

}  // namespace isolux
