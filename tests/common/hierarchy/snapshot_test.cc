// Snapshots as bytes, with and without what groups of bands hand on.
#include "common/hierarchy/snapshot.h"

#include <gtest/gtest.h>

#include "common/util/random.h"

namespace isolux {
namespace {

Snapshot TwoLeaves() {
  Snapshot snapshot;
  snapshot.round = 3;
  snapshot.epsilon = 0.25;
  snapshot.leaves = {{{0, 1}, {1, 2, 3}, .5F, .25F, 1.5F, 1, 0, .125F}, {{1, 1}, {4, 5, 6}}};
  return snapshot;
}

TEST(SnapshotBytes, ComeBack) {
  Snapshot snapshot = TwoLeaves();
  const std::string plain = Encode(snapshot);
  EXPECT_EQ(DecodeSnapshot(plain).value(), snapshot);
  snapshot.handed_on = {{Rgb(1, 2, 3), .5}, {Rgb(4, 5, 6), .75}};
  const std::string bytes = Encode(snapshot);
  EXPECT_EQ(bytes.substr(0, plain.size()), plain);
  EXPECT_EQ(DecodeSnapshot(bytes).value(), snapshot);
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(DecodeSnapshot(bytes.substr(0, size)).has_value(), size == plain.size()) << size;
  }
  EXPECT_FALSE(DecodeSnapshot(bytes + '\0').has_value());
}

TEST(SnapshotBytes, DamagedGiveAnErrorOrASnapshot) {
  constexpr uint64_t kSeed = 20261130;
  SCOPED_TRACE(::testing::Message() << "seed " << kSeed);
  Snapshot snapshot = TwoLeaves();
  snapshot.handed_on.resize(2);
  const std::string good = Encode(snapshot);
  Random random(kSeed);
  int refused = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::string bytes = good;
    const size_t at = random.Bits() % bytes.size();
    if (random.Bits() % 4 == 0) {
      bytes.resize(at);
    } else {
      bytes[at] = static_cast<char>(random.Bits());
    }
    const auto found = DecodeSnapshot(bytes);
    refused += found.has_value() ? 0 : 1;
    if (found.has_value() && !found->handed_on.empty()) {
      EXPECT_EQ(found->handed_on.size(), found->leaves.size());
    }
  }
  EXPECT_GT(refused, 4'000);
}

}  // namespace
}  // namespace isolux
