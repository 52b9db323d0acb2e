// The collectives of a shard over a message port: the coordinator is asked, and combines.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/rpc/protocol.h"
#include "worker/inbox.h"
#include "worker/radiosity/exchange.h"

namespace isolux {

class PortExchange final : public Exchange {
 public:
  PortExchange(MessagePort& port, Inbox& inbox, uint32_t epoch, uint32_t self, double reply_limit_s)
      : port_(port), inbox_(inbox), epoch_(epoch), self_(self), reply_limit_s_(reply_limit_s) {}

  // To be called before the first collective and whenever the assignment changes.
  void SetAssignment(const Assignment& assignment) { home_ = assignment.home; }

  Result<Reduction> Reduce(Reduction mine) override;
  Result<std::vector<NodeId>> Subscribe(const std::vector<std::vector<NodeId>>& wanted) override;
  Status SendValues(std::span<const double> own_cut, std::span<const double> exported) override;
  Result<ReceivedValues> ReceiveValues() override;
  Status SendSums(std::span<const int64_t> crown, std::span<const int64_t> proxies) override;
  Result<ReceivedSums> ReceiveSums() override;
  bool Cancelled() const override { return inbox_.Superseded(epoch_); }

 private:
  Status Send(MessageKind kind, std::string payload);
  Result<Message> Receive(MessageKind kind);

  MessagePort& port_;
  Inbox& inbox_;
  const uint32_t epoch_, self_;
  const double reply_limit_s_;
  std::vector<uint32_t> home_;   // of the cut's nodes
  std::vector<double> own_cut_;  // as last sent: it does not travel back
};

}  // namespace isolux
