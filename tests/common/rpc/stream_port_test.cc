// Two ports joined by a stream that exists in this process only: a thread for each direction, as
// slow and as broken as the test wants it.
#include "common/rpc/stream_port.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <variant>
#include <vector>

namespace isolux {
namespace {

// One side. What it writes is handed to the other side's port once that has a read under way.
class FakeWire final : public StreamWire {
 public:
  void Connect(StreamPort* port, FakeWire* other) {
    port_ = port;
    other_ = other;
    thread_ = std::thread([this] { Run(); });
  }
  ~FakeWire() override { Stop(); }
  void Stop() {
    {
      std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  void StartWrite(FrameData frame) override { Begin(std::move(frame)); }
  void StartControl() override { Begin(std::nullopt); }
  void StartRead() override {
    {
      std::lock_guard lock(mutex_);
      ++reads_;
    }
    other_->changed_.notify_all();
  }
  void Abort() override {
    broken = true;
    other_->broken = true;
    Wake();
  }
  void Finish(const Status&) override {
    ++finishes;
    Wake();
  }

  std::atomic<bool> broken{false};
  std::atomic<bool> stalled{false};
  std::atomic<int> finishes{0}, controls_received{0};

  bool TakeRead() {
    std::lock_guard lock(mutex_);
    if (reads_ == 0) return false;
    --reads_;
    return true;
  }
  void Wake() {
    changed_.notify_all();
    other_->changed_.notify_all();
  }

 private:
  void Begin(std::optional<FrameData> frame) {
    {
      std::lock_guard lock(mutex_);
      ASSERT_FALSE(writing_) << "two writes at a time";
      ASSERT_EQ(finishes, 0) << "a write after the end";
      writing_ = true;
      frame_ = std::move(frame);
    }
    changed_.notify_all();
  }

  void Run() {
    bool read_ended = false;
    std::unique_lock lock(mutex_);
    while (!stop_) {
      changed_.wait_for(lock, std::chrono::milliseconds(1));
      if (writing_ && broken) {
        writing_ = false;
        lock.unlock();
        port_->OnWriteDone(false);
        lock.lock();
      } else if (writing_ && !stalled) {
        lock.unlock();
        const bool taken = other_->TakeRead();
        if (taken && frame_) other_->port_->OnFrame(*frame_);
        if (taken && !frame_) {
          ++other_->controls_received;
          other_->port_->OnControl();
        }
        lock.lock();
        if (taken) {
          writing_ = false;
          lock.unlock();
          port_->OnWriteDone(true);
          lock.lock();
        }
      }
      if (!read_ended && reads_ > 0 && (broken || other_->finishes > 0)) {
        read_ended = true;
        lock.unlock();
        port_->OnReadEnd(MakeStatus(StatusCode::kUnavailable, "the end"));
        lock.lock();
      }
    }
  }

  StreamPort* port_ = nullptr;
  FakeWire* other_ = nullptr;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<FrameData> frame_;
  bool writing_ = false, stop_ = false;
  int reads_ = 0;
  std::thread thread_;
};

struct Pair {
  explicit Pair(StreamPort::Limits limits = {}) : a(&wire_a, "a", limits), b(&wire_b, "b", limits) {
    wire_a.Connect(&a, &wire_b);
    wire_b.Connect(&b, &wire_a);
    a.Start();
    b.Start();
  }
  ~Pair() {
    a.Abort(MakeStatus(StatusCode::kUnavailable, "over"));
    wire_a.Stop();
    wire_b.Stop();
  }
  FakeWire wire_a, wire_b;
  StreamPort a, b;
};

constexpr double kLong = 60;

TEST(StreamPortTest, MessagesArriveWholeAndInOrder) {
  Pair pair;
  std::thread sender([&] {
    for (uint32_t i = 0; i < 40; ++i) {
      EXPECT_TRUE(
          pair.a.Send({i, 1, std::string(i * 30000, static_cast<char>('a' + i % 26))}).ok());
    }
  });
  for (uint32_t i = 0; i < 40; ++i) {
    auto message = pair.b.Receive(kLong);
    ASSERT_TRUE(message.has_value()) << message.error().message();
    EXPECT_EQ(message->kind, i);
    EXPECT_EQ(message->payload, std::string(i * 30000, static_cast<char>('a' + i % 26)));
  }
  sender.join();
  EXPECT_EQ(pair.a.bytes_sent(), pair.b.bytes_received());
}

TEST(StreamPortTest, NothingInTimeIsSaid) {
  Pair pair;
  auto message = pair.b.Receive(0.001);
  ASSERT_FALSE(message.has_value());
  EXPECT_EQ(message.error().code(), StatusCode::kDeadlineExceeded);
}

TEST(StreamPortTest, SendWaitsWhileTheOutboxIsFullAndGoesOnWhenThereIsRoom) {
  StreamPort::Limits limits;
  limits.outbox_bytes = 1000;
  Pair pair(limits);
  pair.wire_a.stalled = true;
  std::atomic<int> sent{0};
  std::thread sender([&] {
    for (int i = 0; i < 4; ++i) {
      EXPECT_TRUE(pair.a.Send({1, 1, std::string(1000, 'x')}).ok());
      ++sent;
    }
  });
  // One is under way, one waits; the third has no room.
  while (sent < 2) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_LE(sent, 3);
  pair.wire_a.stalled = false;
  pair.wire_a.Wake();
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(pair.b.Receive(kLong).has_value());
  sender.join();
}

TEST(StreamPortTest, AFullInboxStopsReadingUntilMessagesAreTaken) {
  StreamPort::Limits limits;
  limits.inbox_bytes = 1000;
  limits.outbox_bytes = 1000;
  Pair pair(limits);
  std::atomic<int> sent{0};
  std::thread sender([&] {
    for (int i = 0; i < 50; ++i) {
      EXPECT_TRUE(pair.a.Send({1, 1, std::string(600, 'x')}).ok());
      ++sent;
    }
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LT(sent, 10) << "the sender is slowed down";
  EXPECT_EQ(pair.b.SilenceSeconds(), 0) << "not the peer's fault";
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(pair.b.Receive(kLong).has_value());
  sender.join();
}

TEST(StreamPortTest, CloseDeliversWhatWasSentBefore) {
  Pair pair;
  for (uint32_t i = 0; i < 5; ++i) {
    ASSERT_TRUE(pair.a.Send({i, 1, std::string(600000, 'x')}).ok());
  }
  pair.a.Close(Status());
  EXPECT_FALSE(pair.a.Send({9, 1, ""}).ok());
  for (uint32_t i = 0; i < 5; ++i) {
    auto message = pair.b.Receive(kLong);
    ASSERT_TRUE(message.has_value()) << message.error().message();
    EXPECT_EQ(message->kind, i);
  }
  auto end = pair.b.Receive(kLong);
  ASSERT_FALSE(end.has_value());
  EXPECT_EQ(end.error().code(), StatusCode::kUnavailable);
  while (pair.wire_a.finishes == 0 || pair.wire_b.finishes == 0) std::this_thread::yield();
  EXPECT_EQ(pair.wire_a.finishes, 1);
  EXPECT_EQ(pair.wire_b.finishes, 1);
}

TEST(StreamPortTest, ABrokenStreamWakesSenderAndReceiver) {
  StreamPort::Limits limits;
  limits.outbox_bytes = 10;
  Pair pair(limits);
  pair.wire_a.stalled = true;
  std::thread sender([&] {
    Status status;
    while (status.ok()) status = pair.a.Send({1, 1, std::string(100, 'x')});
    EXPECT_EQ(status.code(), StatusCode::kUnavailable);
  });
  std::thread receiver([&] {
    auto message = pair.a.Receive(kLong);
    EXPECT_FALSE(message.has_value());
    EXPECT_EQ(message.error().code(), StatusCode::kUnavailable);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  pair.b.Abort(MakeStatus(StatusCode::kUnavailable, "pulled the plug"));
  sender.join();
  receiver.join();
  EXPECT_TRUE(pair.a.gone());
}

TEST(StreamPortTest, ControlOvertakesWhatWaits) {
  Pair pair;
  pair.wire_a.stalled = true;
  ASSERT_TRUE(pair.a.Send({1, 1, std::string(5 * kFrameBytes, 'x')}).ok());
  pair.a.SendControl();
  pair.wire_a.stalled = false;
  auto message = pair.b.Receive(kLong);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(pair.wire_b.controls_received, 1) << "before the end of the message";
}

TEST(StreamPortTest, AMessageBeyondTheLimitIsRefusedBeforeItTravels) {
  StreamPort::Limits limits;
  limits.max_message_bytes = 100;
  Pair pair(limits);
  EXPECT_EQ(pair.a.Send({1, 1, std::string(101, 'x')}).code(), StatusCode::kResourceExhausted);
  EXPECT_TRUE(pair.a.Send({1, 1, std::string(100, 'x')}).ok());
}

}  // namespace
}  // namespace isolux
