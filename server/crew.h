// The workers of one epoch of a job, as the coordinator talks to them: sends, waits for all,
// notices who is lost. One thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/rpc/protocol.h"
#include "server/job.h"
#include "server/relay.h"
#include "server/traffic.h"

namespace isolux {

class Crew {
 public:
  // `traffic` outlives the crew. `cancelled` (may be empty) is asked while waiting.
  Crew(std::vector<WorkerSlot> workers, uint32_t epoch, const JobLimits& limits, Traffic* traffic,
       std::function<bool()> cancelled);

  uint32_t epoch() const { return epoch_; }
  // Numbers of workers in the assignment: [0, size()), of which some may have been released.
  uint32_t size() const { return static_cast<uint32_t>(members_.size()); }
  const WorkerSlot& slot(uint32_t worker) const { return members_[worker].slot; }
  bool present(uint32_t worker) const { return members_[worker].present; }
  bool draining(uint32_t worker) const { return members_[worker].draining; }
  uint32_t present_count() const;

  // The worker this epoch has lost, and why.
  struct Loss {
    uint32_t worker = 0;
    Status why;
  };
  const std::optional<Loss>& loss() const { return loss_; }

  Status Send(uint32_t worker, MessageKind kind, std::string payload);
  Status SendAll(MessageKind kind, const std::string& payload);
  template <typename T>
  Status SendAll(MessageKind kind, const T& content) {
    return SendAll(kind, Encode(content));
  }
  // As far as it goes: for the last words of a job.
  void Dismiss(MessageKind kind, uint64_t job);
  // The worker holds nothing any more and may leave.
  void Release(uint32_t worker);

  // Gives messages to `take` until it has returned true once for every present worker. Progress and
  // Drain are taken care of. An error of a worker, of `take`, a loss (kUnavailable, see loss()) or
  // cancellation (kCancelled) ends it.
  using Take = std::function<Result<bool>(uint32_t worker, Message message)>;
  Status Collect(double lease_s, const Take& take);

  // One message of each present worker, all of this kind.
  Result<PerWorker<Message>> CollectAll(MessageKind kind);
  // One message of each present worker, all of one kind, whichever.
  Result<PerWorker<Message>> CollectAlike(MessageKind* kind);

 private:
  using Clock = std::chrono::steady_clock;
  struct Member {
    WorkerSlot slot;
    bool present = true;
    bool draining = false;
    Clock::time_point heard;
  };

  Status Lose(uint32_t worker, Status why);
  // One receive from a worker: true when `take` is done with it.
  Result<bool> Poll(uint32_t worker, double lease_s, const Take& take);

  std::vector<Member> members_;
  const uint32_t epoch_;
  const JobLimits limits_;
  Traffic* const traffic_;
  const std::function<bool()> cancelled_;
  std::optional<Loss> loss_;
};

}  // namespace isolux
