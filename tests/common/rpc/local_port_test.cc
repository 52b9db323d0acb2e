#include "common/rpc/local_port.h"

#include <gtest/gtest.h>

#include <thread>

namespace isolux {
namespace {

constexpr double kLong_s = 60;

TEST(LocalPortTest, MessagesArriveInOrderAndAreCounted) {
  auto [left, right] = MakeLocalPorts();
  for (uint32_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(left->Send({i, 7, std::string(i, 'x')}).ok());
  }
  for (uint32_t i = 0; i < 10; ++i) {
    const Result<Message> message = right->Receive(kLong_s);
    ASSERT_TRUE(message.has_value());
    EXPECT_EQ(message->kind, i);
    EXPECT_EQ(message->epoch, 7u);
    EXPECT_EQ(message->payload.size(), i);
  }
  EXPECT_EQ(left->bytes_sent(), 45u);
  EXPECT_EQ(right->bytes_received(), 45u);
  EXPECT_EQ(left->bytes_received(), 0u);
}

TEST(LocalPortTest, NothingThereIsADeadline) {
  auto [left, right] = MakeLocalPorts();
  const Result<Message> none = right->Receive(0.0);
  ASSERT_FALSE(none.has_value());
  EXPECT_EQ(none.error().code(), StatusCode::kDeadlineExceeded);
}

TEST(LocalPortTest, WhatWasSentBeforeClosingStillArrives) {
  auto [left, right] = MakeLocalPorts();
  ASSERT_TRUE(left->Send({1, 0, "last words"}).ok());
  left->Close(Status(StatusCode::kAborted, "over"));
  const Result<Message> message = right->Receive(kLong_s);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(message->payload, "last words");
  const Result<Message> none = right->Receive(kLong_s);
  ASSERT_FALSE(none.has_value());
  EXPECT_EQ(none.error().code(), StatusCode::kUnavailable);
  EXPECT_EQ(none.error().message(), "over");
  EXPECT_EQ(right->Send({1, 0, ""}).code(), StatusCode::kUnavailable);
}

TEST(LocalPortTest, AFullQueueBlocksTheSenderUntilRead) {
  LocalPortLimits limits;
  limits.messages = 2;
  auto [left, right] = MakeLocalPorts(limits);
  std::thread sender([&port = *left] {
    for (uint32_t i = 0; i < 100; ++i) EXPECT_TRUE(port.Send({i, 0, "abc"}).ok());
  });
  for (uint32_t i = 0; i < 100; ++i) {
    const Result<Message> message = right->Receive(kLong_s);
    ASSERT_TRUE(message.has_value());
    EXPECT_EQ(message->kind, i);
  }
  sender.join();
}

TEST(LocalPortTest, ClosingFreesABlockedSender) {
  LocalPortLimits limits;
  limits.bytes = 1;
  auto [left, right] = MakeLocalPorts(limits);
  ASSERT_TRUE(left->Send({0, 0, "large"}).ok());
  std::thread sender([&port = *left] {
    EXPECT_EQ(port.Send({0, 0, "x"}).code(), StatusCode::kUnavailable);
  });
  right->Close(Status(StatusCode::kUnavailable, "leaving"));
  sender.join();
}

TEST(LocalPortTest, APeerThatIsDestroyedHasLeft) {
  auto [left, right] = MakeLocalPorts();
  left.reset();
  EXPECT_EQ(right->Receive(kLong_s).error().code(), StatusCode::kUnavailable);
}

}  // namespace
}  // namespace isolux
