#include "server/crew.h"

#include <algorithm>
#include <utility>

namespace isolux {
namespace {

constexpr double kSliceS = 0.1;  // of waiting for one worker before looking at the next

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

Crew::Crew(std::vector<WorkerSlot> workers, uint32_t epoch, const JobLimits& limits,
           Traffic* traffic, std::function<bool()> cancelled)
    : epoch_(epoch), limits_(limits), traffic_(traffic), cancelled_(std::move(cancelled)) {
  for (WorkerSlot& slot : workers) members_.push_back({std::move(slot), true, false, Clock::now()});
}

uint32_t Crew::present_count() const {
  return static_cast<uint32_t>(std::count_if(members_.begin(), members_.end(),
                                             [](const Member& member) { return member.present; }));
}

Status Crew::Lose(uint32_t worker, Status why) {
  loss_ = Loss{worker, why};
  return {StatusCode::kUnavailable,
          fmt::format("worker {} is lost: {}", members_[worker].slot.name, why.message())};
}

Status Crew::Send(uint32_t worker, MessageKind kind, std::string payload) {
  PhaseBytes& bytes =
      traffic_->by_worker[members_[worker].slot.id][static_cast<size_t>(PhaseOf(kind))];
  bytes.out += payload.size();
  ++bytes.messages_out;
  const Status status =
      members_[worker].slot.port->Send({static_cast<uint32_t>(kind), epoch_, std::move(payload)});
  return status.ok() ? status : Lose(worker, status);
}

Status Crew::SendAll(MessageKind kind, const std::string& payload) {
  for (uint32_t w = 0; w < size(); ++w) {
    if (present(w)) RETURN_IF_ERROR(Send(w, kind, payload));
  }
  return {};
}

void Crew::Dismiss(MessageKind kind, uint64_t job) {
  for (Member& member : members_) {
    // One who is gone needs no telling.
    if (member.present) (void)member.slot.port->Send(MakeMessage(kind, epoch_, EndJob{job}));
  }
}

void Crew::Release(uint32_t worker) {
  members_[worker].present = false;
  (void)members_[worker].slot.port->Send(
      {static_cast<uint32_t>(MessageKind::kRelease), epoch_, {}});
}

Result<bool> Crew::Poll(uint32_t worker, double lease_s, const Take& take) {
  Member& member = members_[worker];
  Result<Message> received = member.slot.port->Receive(kSliceS);
  if (!received.has_value()) {
    if (received.error().code() != StatusCode::kDeadlineExceeded) {
      return tl::unexpected<Status>(Lose(worker, received.error()));
    }
    if (SecondsSince(member.heard) < lease_s) return false;
    return tl::unexpected<Status>(
        Lose(worker, MakeStatus(StatusCode::kUnavailable, "no sign of life within {} s", lease_s)));
  }
  member.heard = Clock::now();
  if (received->epoch != epoch_) {
    ++traffic_->stale_messages;
    return false;
  }
  const auto kind = static_cast<MessageKind>(received->kind);
  PhaseBytes& bytes = traffic_->by_worker[member.slot.id][static_cast<size_t>(PhaseOf(kind))];
  bytes.in += received->payload.size();
  ++bytes.messages_in;
  switch (kind) {
    case MessageKind::kProgress:
      return false;
    case MessageKind::kDrain:
      member.draining = true;
      return false;
    case MessageKind::kFailed: {
      ASSIGN_OR_RETURN(const Failed failed, DecodeMessage<Failed>(received->payload));
      // Whatever its code: it is the job that failed, the worker is there.
      const StatusCode code = failed.status.code() == StatusCode::kUnavailable
                                  ? StatusCode::kInternal
                                  : failed.status.code();
      return Error(code, "worker {}: {}", member.slot.name, failed.status.message());
    }
    default: {
      Result<bool> done = take(worker, std::move(*received));
      if (done.has_value()) return done;
      return tl::unexpected<Status>(done.error().Within("worker " + member.slot.name));
    }
  }
}

Status Crew::Collect(double lease_s, const Take& take) {
  const Clock::time_point start = Clock::now();
  std::vector<uint32_t> waiting;
  for (uint32_t w = 0; w < size(); ++w) {
    if (!present(w)) continue;
    waiting.push_back(w);
    members_[w].heard = start;  // nobody listened before
  }
  while (!waiting.empty()) {
    for (size_t i = 0; i < waiting.size();) {
      if (cancelled_ && cancelled_()) return {StatusCode::kCancelled, "the job was cancelled"};
      ASSIGN_OR_RETURN(const bool done, Poll(waiting[i], lease_s, take));
      if (done) {
        waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(i));
      } else {
        ++i;
      }
    }
    if (!waiting.empty() && SecondsSince(start) > limits_.step_limit_s) {
      return Lose(waiting.front(), MakeStatus(StatusCode::kUnavailable, "no answer within {} s",
                                              limits_.step_limit_s));
    }
  }
  return {};
}

Result<PerWorker<Message>> Crew::CollectAlike(MessageKind* kind) {
  PerWorker<Message> messages(size());
  std::optional<MessageKind> first;
  RETURN_IF_ERROR(Collect(limits_.lease_s, [&](uint32_t worker, Message message) -> Result<bool> {
    const auto this_kind = static_cast<MessageKind>(message.kind);
    if (first && *first != this_kind) {
      return Error(StatusCode::kInternal, "{} while another worker says {}", ToText(this_kind),
                   ToText(*first));
    }
    first = this_kind;
    messages[worker] = std::move(message);
    return true;
  }));
  if (!first) return Error(StatusCode::kUnavailable, "no workers");
  *kind = *first;
  return messages;
}

Result<PerWorker<Message>> Crew::CollectAll(MessageKind kind) {
  MessageKind came{};
  ASSIGN_OR_RETURN(auto messages, CollectAlike(&came));
  if (came == kind) return messages;
  return Error(StatusCode::kInternal, "workers say {} instead of {}", ToText(came), ToText(kind));
}

}  // namespace isolux
