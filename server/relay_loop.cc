#include "server/relay_loop.h"

#include <utility>

namespace isolux {
namespace {

constexpr uint64_t kMostCollectives = 1'000'000;  // in a round; a solve takes some hundreds

template <typename T>
Result<PerWorker<T>> DecodeAll(const PerWorker<Message>& messages) {
  PerWorker<T> contents(messages.size());
  for (size_t w = 0; w < messages.size(); ++w) {
    if (!messages[w]) continue;
    ASSIGN_OR_RETURN(contents[w], DecodeMessage<T>(messages[w]->payload));
  }
  return contents;
}

class Loop {
 public:
  Loop(Crew& crew, const Assignment& assignment) : crew_(crew), assignment_(assignment) {
    subscriptions_.exported.resize(crew.size());
    subscriptions_.index.assign(crew.size(), std::vector<std::vector<uint32_t>>(crew.size()));
  }

  Status Answer(MessageKind kind, const PerWorker<Message>& messages, CollectiveNews* news) {
    switch (kind) {
      case MessageKind::kReduce:
        return AnswerReduce(messages);
      case MessageKind::kSubscribe:
        news->subscribed = true;
        return AnswerSubscribe(messages);
      case MessageKind::kValues:
        ++news->products;
        return AnswerValues(messages);
      case MessageKind::kSums:
        return AnswerSums(messages);
      default:
        return MakeStatus(StatusCode::kInternal, "{} in the midst of a round", ToText(kind));
    }
  }

 private:
  Status AnswerReduce(const PerWorker<Message>& messages) {
    ASSIGN_OR_RETURN(const auto parts, DecodeAll<Reduction>(messages));
    ASSIGN_OR_RETURN(const Reduction total, Combine(parts));
    return crew_.SendAll(MessageKind::kReduceReply, total);
  }

  Status AnswerSubscribe(const PerWorker<Message>& messages) {
    ASSIGN_OR_RETURN(const auto requests, DecodeAll<SubscribeRequest>(messages));
    ASSIGN_OR_RETURN(subscriptions_, Subscribe(requests, crew_.size()));
    for (uint32_t w = 0; w < crew_.size(); ++w) {
      if (!crew_.present(w)) continue;
      RETURN_IF_ERROR(crew_.Send(w, MessageKind::kSubscribeReply,
                                 Encode(SubscribeReply{subscriptions_.exported[w]})));
    }
    return {};
  }

  Status AnswerValues(const PerWorker<Message>& messages) {
    ASSIGN_OR_RETURN(const auto values, DecodeAll<Values>(messages));
    ASSIGN_OR_RETURN(const auto replies, FanOut(values, subscriptions_, assignment_));
    return SendEach(MessageKind::kValuesReply, replies);
  }

  Status AnswerSums(const PerWorker<Message>& messages) {
    ASSIGN_OR_RETURN(const auto sums, DecodeAll<Sums>(messages));
    ASSIGN_OR_RETURN(const auto replies, AddUp(sums, subscriptions_));
    return SendEach(MessageKind::kSumsReply, replies);
  }

  template <typename T>
  Status SendEach(MessageKind kind, const std::vector<T>& replies) {
    for (uint32_t w = 0; w < crew_.size(); ++w) {
      if (crew_.present(w)) RETURN_IF_ERROR(crew_.Send(w, kind, Encode(replies[w])));
    }
    return {};
  }

  Crew& crew_;
  const Assignment& assignment_;
  Subscriptions subscriptions_;
};

}  // namespace

Result<PerWorker<Message>> RelayUntil(Crew& crew, const Assignment& assignment, MessageKind last,
                                      const std::function<void(const CollectiveNews&)>& news) {
  Loop loop(crew, assignment);
  CollectiveNews so_far;
  for (uint64_t i = 0; i < kMostCollectives; ++i) {
    MessageKind kind{};
    ASSIGN_OR_RETURN(auto messages, crew.CollectAlike(&kind));
    if (kind == last) return messages;
    RETURN_IF_ERROR(loop.Answer(kind, messages, &so_far));
    if (news) news(so_far);
  }
  return Error(StatusCode::kInternal, "a round of more than {} collectives", kMostCollectives);
}

}  // namespace isolux
