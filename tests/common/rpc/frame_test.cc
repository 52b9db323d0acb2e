#include "common/rpc/frame.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace isolux {
namespace {

std::string Bytes(size_t size, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::string bytes(size, '\0');
  for (char& c : bytes) c = static_cast<char>(random());
  return bytes;
}

TEST(FrameTest, MessagesOfAllSizesComeThrough) {
  FrameCutter cutter;
  FrameJoiner joiner;
  const std::vector<size_t> sizes = {0,
                                     1,
                                     kFrameBytes - 1,
                                     kFrameBytes,
                                     kFrameBytes + 1,
                                     2 * kFrameBytes,
                                     7 * kFrameBytes + 12345};
  uint64_t total = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    cutter.Add({static_cast<uint32_t>(i), 9, Bytes(sizes[i], i)});
    total += sizes[i];
  }
  EXPECT_EQ(cutter.waiting_bytes(), total);
  size_t received = 0;
  while (std::optional<FrameData> frame = cutter.Next()) {
    EXPECT_LE(frame->data.size(), kFrameBytes);
    auto message = joiner.Add(std::move(*frame));
    ASSERT_TRUE(message.has_value()) << message.error().message();
    if (!message->has_value()) continue;
    EXPECT_EQ((*message)->kind, received);
    EXPECT_EQ((*message)->epoch, 9u);
    EXPECT_EQ((*message)->payload, Bytes(sizes[received], received));
    ++received;
  }
  EXPECT_EQ(received, sizes.size());
  EXPECT_TRUE(cutter.empty());
  EXPECT_EQ(cutter.waiting_bytes(), 0u);
}

FrameData Frame(uint64_t sequence, const std::string& data, uint64_t total, bool last) {
  return {.epoch = 1,
          .sequence = sequence,
          .kind = 3,
          .last = last,
          .data = data,
          .message_bytes = total};
}

TEST(FrameTest, DamageIsNoticed) {
  const auto code = [](std::vector<FrameData> frames, uint64_t limit = kMaxMessageBytes) {
    FrameJoiner joiner(limit);
    for (FrameData& frame : frames) {
      auto result = joiner.Add(std::move(frame));
      if (!result) return result.error().code();
    }
    return StatusCode::kOk;
  };
  EXPECT_EQ(code({Frame(1, "ab", 2, true)}), StatusCode::kOk);
  EXPECT_EQ(code({Frame(2, "ab", 2, true)}), StatusCode::kDataLoss) << "a gap";
  EXPECT_EQ(code({Frame(1, "ab", 2, true), Frame(1, "ab", 2, true)}), StatusCode::kDataLoss)
      << "twice";
  EXPECT_EQ(code({Frame(1, "ab", 3, true)}), StatusCode::kDataLoss) << "too short";
  EXPECT_EQ(code({Frame(1, "ab", 1, true)}), StatusCode::kDataLoss) << "too long";
  EXPECT_EQ(code({Frame(1, "ab", 4, false), Frame(2, "cd", 0, false)}), StatusCode::kDataLoss)
      << "complete, but not the last";
  EXPECT_EQ(code({Frame(1, "ab", 4, false), Frame(2, "", 0, false)}), StatusCode::kDataLoss)
      << "empty frames could go on for ever";
  EXPECT_EQ(code({Frame(1, "ab", 4, false), Frame(2, "cd", 4, true)}), StatusCode::kDataLoss)
      << "announced twice";
  FrameData other = Frame(2, "cd", 0, true);
  other.kind = 4;
  EXPECT_EQ(code({Frame(1, "ab", 4, false), other}), StatusCode::kDataLoss) << "interleaved";
  EXPECT_EQ(code({Frame(1, "ab", 101, false)}, 100), StatusCode::kResourceExhausted);
  EXPECT_EQ(code({Frame(1, std::string(kFrameBytes + 1, 'x'), kFrameBytes + 1, true)}),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(code({Frame(1, "ab", 1ULL << 63, false)}), StatusCode::kResourceExhausted);
}

// Whatever comes: no crash, no more memory than was announced, and never a message that was not
// sent.
TEST(FrameTest, RandomFramesNeverMakeAMessageOutOfRange) {
  for (uint64_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    FrameJoiner joiner(1000);
    uint64_t sequence = 0;
    for (int i = 0; i < 20; ++i) {
      FrameData frame;
      frame.sequence = random() % 8 == 0 ? random() : ++sequence;
      frame.epoch = static_cast<uint32_t>(random() % 2);
      frame.kind = static_cast<uint32_t>(random() % 2);
      frame.last = random() % 2 == 0;
      frame.data.assign(random() % 600, 'x');
      frame.message_bytes = random() % 4 == 0 ? random() : random() % 3 * 300;
      auto result = joiner.Add(std::move(frame));
      if (!result) break;
      if (result->has_value()) {
        EXPECT_LE((*result)->payload.size(), 1000u);
      }
    }
  }
}

}  // namespace
}  // namespace isolux
