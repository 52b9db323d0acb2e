// What travels between the coordinator and its workers in a solve: every value once a node, worker
// and exchange, and nothing about geometry once the scene is there. Counted in the messages
// themselves, byte by byte.
#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <set>

#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

constexpr size_t kFraming = 24;  // bytes of a message beside its numbers

struct Seen {
  bool up = false;  // from the worker
  Message message;
};

// Passes everything on and keeps a copy. Only the coordinator's one thread looks.
class SpyPort final : public MessagePort {
 public:
  SpyPort(std::shared_ptr<MessagePort> port, std::vector<Seen>* seen)
      : port_(std::move(port)), seen_(seen) {}
  Status Send(Message message) override {
    seen_->push_back({false, message});
    return port_->Send(std::move(message));
  }
  Result<Message> Receive(double timeout_s) override {
    Result<Message> message = port_->Receive(timeout_s);
    if (message.has_value()) seen_->push_back({true, *message});
    return message;
  }
  void Close(const Status& reason) override { port_->Close(reason); }
  uint64_t bytes_sent() const override { return port_->bytes_sent(); }
  uint64_t bytes_received() const override { return port_->bytes_received(); }

 private:
  std::shared_ptr<MessagePort> port_;
  std::vector<Seen>* seen_;
};

SolveOptions ThreeRounds() {
  SolveOptions options;
  options.accuracy = 0.1;
  options.epsilons = {0.2, 0.02, 0.003};
  options.balance = BalanceStrategy::kNone;
  options.cut_size = 24;
  return options;
}

struct Recording {
  std::vector<std::vector<Seen>> of_worker;
  Assignment assignment;
};

Recording Record(int workers) {
  Recording recording;
  recording.of_worker.resize(static_cast<size_t>(workers));
  LocalCluster cluster(workers, 1);
  JobCallbacks callbacks;
  callbacks.workers = [&] {
    std::vector<WorkerSlot> slots = cluster.slots();
    for (size_t w = 0; w < slots.size(); ++w) {
      slots[w].port = std::make_shared<SpyPort>(slots[w].port, &recording.of_worker[w]);
    }
    return slots;
  };
  const auto result = RunJob(cluster, MakeJobInput(CornellBox(false), ThreeRounds()), callbacks);
  EXPECT_TRUE(result.has_value()) << result.error().message();
  for (const Seen& seen : recording.of_worker[0]) {
    if (seen.message.kind != static_cast<uint32_t>(MessageKind::kStartJob)) continue;
    const auto start = DecodeMessage<StartJob>(seen.message.payload);
    if (start.has_value()) recording.assignment = start->assignment;
  }
  return recording;
}

bool Is(const Seen& seen, MessageKind kind) {
  return seen.message.kind == static_cast<uint32_t>(kind);
}

size_t CountIds(const SubscribeRequest& request) {
  size_t count = 0;
  for (const auto& list : request.wanted) count += list.size();
  return count;
}

TEST(ClusterTrafficTest, AValueTravelsOncePerNodeWorkerAndExchange) {
  constexpr uint32_t kWorkers = 3;
  const Recording recording = Record(kWorkers);
  ASSERT_EQ(recording.assignment.worker_count, kWorkers);
  uint64_t exchanges = 0, proxies = 0;
  for (uint32_t w = 0; w < kWorkers; ++w) {
    const auto own = static_cast<size_t>(
        std::count(recording.assignment.home.begin(), recording.assignment.home.end(), w));
    const size_t others = recording.assignment.cut.size() - own;
    size_t wanted = 0, exported = 0, subscriptions = 0;
    for (const Seen& seen : recording.of_worker[w]) {
      const std::string& payload = seen.message.payload;
      if (Is(seen, MessageKind::kSubscribe)) {
        wanted = CountIds(*DecodeMessage<SubscribeRequest>(payload));
        ++subscriptions;
      } else if (Is(seen, MessageKind::kSubscribeReply)) {
        const auto reply = DecodeMessage<SubscribeReply>(payload);
        exported = reply->exported.size();  // each id once: the decoder insists
      } else if (Is(seen, MessageKind::kValues)) {
        const auto values = DecodeMessage<Values>(payload);
        ASSERT_EQ(values->own_cut.size() % own, 0u);
        const size_t lanes = values->own_cut.size() / own;
        EXPECT_LE(lanes, 4u);
        EXPECT_EQ(values->exported.size(), lanes * exported);
        EXPECT_LE(payload.size(), 8 * lanes * (own + exported) + kFraming);
        ++exchanges;
        proxies += wanted;
      } else if (Is(seen, MessageKind::kValuesReply)) {
        const auto values = DecodeMessage<ValuesReply>(payload);
        const size_t lanes = values->other_cut.size() / others;
        EXPECT_EQ(values->proxies.size(), lanes * wanted);
        EXPECT_LE(payload.size(), 8 * lanes * (others + wanted) + kFraming);
      } else if (Is(seen, MessageKind::kSums)) {
        const auto sums = DecodeMessage<Sums>(payload);
        EXPECT_EQ(wanted == 0 ? 0 : sums->proxies.size() % wanted, 0u);
        EXPECT_LE(payload.size(), 8 * (sums->crown.size() + sums->proxies.size()) + kFraming);
      } else if (Is(seen, MessageKind::kSumsReply)) {
        const auto sums = DecodeMessage<SumsReply>(payload);
        EXPECT_EQ(exported == 0 ? 0 : sums->exported.size() % exported, 0u);
        EXPECT_LE(payload.size(), 8 * (sums->crown.size() + sums->exported.size()) + kFraming);
      }
    }
    EXPECT_EQ(subscriptions, 3u) << "once a round";
  }
  EXPECT_GT(exchanges, 0u);
  EXPECT_GT(proxies, 0u);
}

// Every message is of a kind whose contents are counted here or in the test above: numbers of
// nodes, their ids, links. The scene comes once, and no other message has room for geometry.
TEST(ClusterTrafficTest, GeometryNeverTravels) {
  const Recording recording = Record(2);
  for (const auto& messages : recording.of_worker) {
    std::map<MessageKind, int> count;
    for (const Seen& seen : messages) {
      const auto kind = static_cast<MessageKind>(seen.message.kind);
      ++count[kind];
      const size_t size = seen.message.payload.size();
      if (kind == MessageKind::kSnapshotPart || kind == MessageKind::kInstallSnapshot) {
        const auto data = DecodeMessage<SnapshotData>(seen.message.payload);
        const auto snapshot = DecodeSnapshot(data->snapshot);
        // An id, H, spread, error, two closures, escape, doubt.
        EXPECT_LE(size, snapshot->leaves.size() * (12 + 24 + 24) + 2 * kFraming);
      } else if (kind == MessageKind::kGather) {
        const auto request = DecodeMessage<GatherRequest>(seen.message.payload);
        EXPECT_LE(size, request->elements.size() * 13 + 2 * kFraming);
      } else if (kind == MessageKind::kGatherPart) {
        const auto part = DecodeMessage<GatherPart>(seen.message.payload);
        EXPECT_LE(size, part->sums.size() * 8 + 2 * kFraming);
      } else if (kind == MessageKind::kSubscribe) {
        const auto request = DecodeMessage<SubscribeRequest>(seen.message.payload);
        EXPECT_LE(size, CountIds(*request) * 12 + 2 * kFraming);
      }
    }
    EXPECT_EQ(count[MessageKind::kSceneData], 1);
    EXPECT_EQ(count[MessageKind::kParcels], 0);
    EXPECT_EQ(count[MessageKind::kRound], 3);
  }
}

}  // namespace
}  // namespace isolux::testing
