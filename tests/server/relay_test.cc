#include "server/relay.h"

#include <gtest/gtest.h>

#include "common/util/random.h"

namespace isolux {
namespace {

NodeId Surface(uint32_t s) { return {s, 1}; }

// Three workers; 0 has surfaces 0–3, 1 has 4–7, 2 has 8–11.
Assignment ThreeWorkers() {
  Assignment assignment;
  assignment.worker_count = 3;
  for (uint32_t s = 0; s < 12; ++s) {
    assignment.cut.push_back(Surface(s));
    assignment.home.push_back(s / 4);
  }
  return assignment;
}

PerWorker<SubscribeRequest> SomeRequests() {
  PerWorker<SubscribeRequest> requests(3);
  requests[0] = SubscribeRequest{{{}, {Surface(4), Surface(6)}, {}}};
  requests[1] = SubscribeRequest{{{Surface(1)}, {}, {Surface(8), Surface(9), Surface(11)}}};
  requests[2] = SubscribeRequest{{{Surface(1), Surface(2)}, {Surface(6), Surface(7)}, {}}};
  return requests;
}

TEST(RelayTest, ReductionsCombine) {
  PerWorker<Reduction> parts(3);
  for (const size_t w : {0u, 2u}) {  // 1 has been released
    Reduction part;
    part.maxima = {w == 0 ? 3.0 : -1.0, w == 0 ? 0.5 : 0.75};
    part.sums.resize(1);
    part.sums[0].Add(w == 0 ? 1e300 : 1.0);
    if (w == 2) part.sums[0].Add(-1e300);
    part.counts = {w + 1};
    parts[w] = part;
  }
  const Result<Reduction> total = Combine(parts);
  ASSERT_TRUE(total.has_value());
  EXPECT_EQ(total->maxima, (std::vector<double>{3.0, 0.75}));
  EXPECT_EQ(total->sums[0].Value(), 1.0);
  EXPECT_EQ(total->counts[0], 4u);
}

TEST(RelayTest, ReductionsOfDifferentShapesAreAnError) {
  PerWorker<Reduction> parts(2);
  parts[0] = Reduction{{1.0}, {}, {}};
  parts[1] = Reduction{{}, {}, {}};
  EXPECT_EQ(Combine(parts).error().code(), StatusCode::kInternal);
  parts[0] = Reduction{{}, {}, {UINT64_MAX}};
  parts[1] = Reduction{{}, {}, {1}};
  EXPECT_EQ(Combine(parts).error().code(), StatusCode::kOutOfRange);
}

TEST(RelayTest, ExportsAreTheUnionOfWhatOthersWant) {
  const Result<Subscriptions> subscriptions = Subscribe(SomeRequests(), 3);
  ASSERT_TRUE(subscriptions.has_value());
  EXPECT_EQ(subscriptions->exported[0], (std::vector<NodeId>{Surface(1), Surface(2)}));
  EXPECT_EQ(subscriptions->exported[1], (std::vector<NodeId>{Surface(4), Surface(6), Surface(7)}));
  EXPECT_EQ(subscriptions->exported[2], (std::vector<NodeId>{Surface(8), Surface(9), Surface(11)}));
  EXPECT_EQ(subscriptions->index[0][1], (std::vector<uint32_t>{0, 1}));
  EXPECT_EQ(subscriptions->index[2][1], (std::vector<uint32_t>{1, 2}));
  EXPECT_EQ(subscriptions->index[2][0], (std::vector<uint32_t>{0, 1}));
}

TEST(RelayTest, NobodySubscribesAtItselfOrAtWhoIsGone) {
  PerWorker<SubscribeRequest> requests(2);
  requests[0] = SubscribeRequest{{{Surface(0)}, {}}};
  requests[1] = SubscribeRequest{{{}, {}}};
  EXPECT_FALSE(Subscribe(requests, 2).has_value());
  requests[0] = SubscribeRequest{{{}, {Surface(4)}}};
  requests[1] = std::nullopt;
  EXPECT_FALSE(Subscribe(requests, 2).has_value());
  requests[0] = SubscribeRequest{{{}}};
  EXPECT_FALSE(Subscribe(requests, 2).has_value());
}

TEST(RelayTest, ValuesGoToThoseWhoWantThem) {
  const Assignment assignment = ThreeWorkers();
  const Result<Subscriptions> subscriptions = Subscribe(SomeRequests(), 3);
  ASSERT_TRUE(subscriptions.has_value());
  // Two lanes: the value of surface s is (s, s + 0.5); exported ones the same plus 100.
  PerWorker<Values> values(3);
  for (uint32_t w = 0; w < 3; ++w) {
    values[w].emplace();
    for (uint32_t s = 4 * w; s < 4 * w + 4; ++s) {
      values[w]->own_cut.insert(values[w]->own_cut.end(), {s + 0.0, s + 0.5});
    }
    for (const NodeId& id : subscriptions->exported[w]) {
      values[w]->exported.insert(values[w]->exported.end(),
                                 {id.surface + 100.0, id.surface + 100.5});
    }
  }
  const auto replies = FanOut(values, *subscriptions, assignment);
  ASSERT_TRUE(replies.has_value()) << replies.error().message();
  EXPECT_EQ((*replies)[0].proxies, (std::vector<double>{104, 104.5, 106, 106.5}));
  EXPECT_EQ((*replies)[2].proxies,
            (std::vector<double>{101, 101.5, 102, 102.5, 106, 106.5, 107, 107.5}));
  EXPECT_EQ((*replies)[1].other_cut, (std::vector<double>{0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 8, 8.5, 9,
                                                          9.5, 10, 10.5, 11, 11.5}));
  values[1]->exported.pop_back();
  EXPECT_FALSE(FanOut(values, *subscriptions, assignment).has_value());
}

TEST(RelayTest, SumsComeBackToTheirHomes) {
  const Result<Subscriptions> subscriptions = Subscribe(SomeRequests(), 3);
  ASSERT_TRUE(subscriptions.has_value());
  PerWorker<Sums> sums(3);
  sums[0] = Sums{{1, 10}, {4, 6}};                // for surfaces 4, 6
  sums[1] = Sums{{2, 20}, {1, 8, 9, 11}};         // 1; 8, 9, 11
  sums[2] = Sums{{3, 30}, {100, 200, 600, 700}};  // 1, 2; 6, 7
  auto replies = AddUp(sums, *subscriptions);
  ASSERT_TRUE(replies.has_value()) << replies.error().message();
  for (const SumsReply& reply : *replies) EXPECT_EQ(reply.crown, (std::vector<int64_t>{6, 60}));
  EXPECT_EQ((*replies)[0].exported, (std::vector<int64_t>{101, 200}));
  EXPECT_EQ((*replies)[1].exported, (std::vector<int64_t>{4, 606, 700}));
  EXPECT_EQ((*replies)[2].exported, (std::vector<int64_t>{8, 9, 11}));

  sums[2]->proxies[2] = INT64_MAX;
  replies = AddUp(sums, *subscriptions);
  ASSERT_FALSE(replies.has_value());
  EXPECT_EQ(replies.error().code(), StatusCode::kOutOfRange);
  sums[2]->proxies[2] = 0;
  sums[2]->crown[0] = INT64_MAX;
  EXPECT_FALSE(AddUp(sums, *subscriptions).has_value());
  sums[2]->crown.pop_back();
  EXPECT_EQ(AddUp(sums, *subscriptions).error().code(), StatusCode::kInternal);
}

// Against the obvious way: look every value up by its id.
TEST(RelayTest, RandomSubscriptionsAgreeWithLookingUpByIds) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const auto workers = static_cast<uint32_t>(1 + random.Bits() % 5);
    Assignment assignment;
    assignment.worker_count = workers;
    for (uint32_t s = 0; s < 30; ++s) {
      assignment.cut.push_back(Surface(s));
      assignment.home.push_back(static_cast<uint32_t>(random.Bits() % workers));
    }
    PerWorker<SubscribeRequest> requests(workers);
    for (uint32_t w = 0; w < workers; ++w) {
      requests[w] = SubscribeRequest{std::vector<std::vector<NodeId>>(workers)};
      for (uint32_t s = 0; s < 30; ++s) {
        const uint32_t home = assignment.home[s];
        if (home != w && random.Bits() % 2 == 0) requests[w]->wanted[home].push_back(Surface(s));
      }
    }
    const auto subscriptions = Subscribe(requests, workers);
    ASSERT_TRUE(subscriptions.has_value());
    PerWorker<Values> values(workers);
    PerWorker<Sums> sums(workers);
    std::vector<int64_t> expected_sum(30, 0);
    for (uint32_t w = 0; w < workers; ++w) {
      values[w].emplace();
      sums[w] = Sums{{}, {}};
      for (uint32_t s = 0; s < 30; ++s) {
        if (assignment.home[s] == w) values[w]->own_cut.push_back(s);
      }
      for (const NodeId& id : subscriptions->exported[w]) {
        values[w]->exported.push_back(id.surface);
      }
      for (const auto& list : requests[w]->wanted) {
        for (const NodeId& id : list) {
          const auto term = static_cast<int64_t>(random.Bits() >> 8);
          sums[w]->proxies.push_back(term);
          expected_sum[id.surface] += term;
        }
      }
    }
    const auto fanned = FanOut(values, *subscriptions, assignment);
    const auto added = AddUp(sums, *subscriptions);
    ASSERT_TRUE(fanned.has_value() && added.has_value()) << "seed " << seed;
    for (uint32_t w = 0; w < workers; ++w) {
      std::vector<double> expected;
      for (const auto& list : requests[w]->wanted) {
        for (const NodeId& id : list) expected.push_back(id.surface);
      }
      EXPECT_EQ((*fanned)[w].proxies, expected) << "seed " << seed;
      std::vector<int64_t> expected_exports;
      for (const NodeId& id : subscriptions->exported[w]) {
        expected_exports.push_back(expected_sum[id.surface]);
      }
      EXPECT_EQ((*added)[w].exported, expected_exports) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace isolux
