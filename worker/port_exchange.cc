#include "worker/port_exchange.h"

#include <algorithm>
#include <utility>

namespace isolux {

Status PortExchange::Send(MessageKind kind, std::string payload) {
  return port_.Send({static_cast<uint32_t>(kind), epoch_, std::move(payload)});
}

Result<Message> PortExchange::Receive(MessageKind kind) {
  ASSIGN_OR_RETURN(Message message, inbox_.NextOf(epoch_, reply_limit_s_));
  if (message.kind == static_cast<uint32_t>(kind)) return message;
  return Error(StatusCode::kInternal, "{} while waiting for {}",
               ToText(static_cast<MessageKind>(message.kind)), ToText(kind));
}

Result<Reduction> PortExchange::Reduce(Reduction mine) {
  RETURN_IF_ERROR(Send(MessageKind::kReduce, Encode(mine)));
  ASSIGN_OR_RETURN(const Message reply, Receive(MessageKind::kReduceReply));
  ASSIGN_OR_RETURN(Reduction total, DecodeMessage<Reduction>(reply.payload));
  if (total.maxima.size() != mine.maxima.size() || total.sums.size() != mine.sums.size() ||
      total.counts.size() != mine.counts.size()) {
    return Error(StatusCode::kInternal, "ReduceReply of another length than Reduce");
  }
  return total;
}

Result<std::vector<NodeId>> PortExchange::Subscribe(
    const std::vector<std::vector<NodeId>>& wanted) {
  RETURN_IF_ERROR(Send(MessageKind::kSubscribe, Encode(SubscribeRequest{wanted})));
  ASSIGN_OR_RETURN(const Message reply, Receive(MessageKind::kSubscribeReply));
  ASSIGN_OR_RETURN(SubscribeReply content, DecodeMessage<SubscribeReply>(reply.payload));
  return std::move(content.exported);
}

Status PortExchange::SendValues(std::span<const double> own_cut, std::span<const double> exported) {
  own_cut_.assign(own_cut.begin(), own_cut.end());
  return Send(MessageKind::kValues, EncodeValues(own_cut, exported));
}

Result<ReceivedValues> PortExchange::ReceiveValues() {
  ASSIGN_OR_RETURN(const Message reply, Receive(MessageKind::kValuesReply));
  ASSIGN_OR_RETURN(ValuesReply content, DecodeMessage<ValuesReply>(reply.payload));
  const auto own = static_cast<size_t>(std::count(home_.begin(), home_.end(), self_));
  const size_t others = home_.size() - own;
  const size_t lanes = own > 0 ? own_cut_.size() / own : content.other_cut.size() / others;
  if (own_cut_.size() != own * lanes || content.other_cut.size() != others * lanes) {
    return Error(StatusCode::kInternal, "ValuesReply: {} numbers for {} nodes of the cut",
                 content.other_cut.size(), others);
  }
  ReceivedValues received;
  received.proxies = std::move(content.proxies);
  received.cut.reserve(home_.size() * lanes);
  const double* mine = own_cut_.data();
  const double* other = content.other_cut.data();
  for (const uint32_t home : home_) {
    const double*& from = home == self_ ? mine : other;
    received.cut.insert(received.cut.end(), from, from + lanes);
    from += lanes;
  }
  return received;
}

Status PortExchange::SendSums(std::span<const int64_t> crown, std::span<const int64_t> proxies) {
  return Send(MessageKind::kSums, EncodeSums(crown, proxies));
}

Result<ReceivedSums> PortExchange::ReceiveSums() {
  ASSIGN_OR_RETURN(const Message reply, Receive(MessageKind::kSumsReply));
  ASSIGN_OR_RETURN(SumsReply content, DecodeMessage<SumsReply>(reply.payload));
  return ReceivedSums{std::move(content.crown), std::move(content.exported)};
}

}  // namespace isolux
