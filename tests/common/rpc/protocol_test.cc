#include "common/rpc/protocol.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "common/util/random.h"

namespace isolux {
namespace {

std::vector<NodeId> RandomIds(Random& random, size_t count) {
  std::set<NodeId> ids;
  for (size_t i = 0; i < count; ++i) {
    if (random.Bits() % 5 == 0) {
      ids.insert({NodeId::kCluster, random.Bits() % 1000});
    } else {
      const uint64_t level = random.Bits() % 12;
      ids.insert({static_cast<uint32_t>(random.Bits() % 50),
                  (1ULL << level) | (random.Bits() & ((1ULL << level) - 1))});
    }
  }
  return {ids.begin(), ids.end()};
}

std::vector<NodeId> RandomElements(Random& random, size_t count) {
  std::vector<NodeId> ids = RandomIds(random, count);
  std::erase_if(ids, [](const NodeId& id) { return id.is_cluster(); });
  return ids;
}

GatherRequest RandomGather(Random& random) {
  GatherRequest request{RandomElements(random, 30), 0.1, {}};
  for (size_t i = 0; i < request.elements.size(); ++i) {
    request.corners.push_back(static_cast<uint8_t>(random.Bits() % 16));
  }
  return request;
}

template <typename T>
std::vector<T> RandomNumbers(Random& random, size_t count) {
  std::vector<T> values(count);
  for (T& value : values) value = static_cast<T>(static_cast<int64_t>(random.Bits()) >> 11);
  return values;
}

Assignment RandomAssignment(Random& random) {
  Assignment assignment;
  assignment.cut = RandomIds(random, 1 + random.Bits() % 40);
  assignment.worker_count = 1 + static_cast<uint32_t>(random.Bits() % 7);
  for (size_t i = 0; i < assignment.cut.size(); ++i) {
    assignment.home.push_back(static_cast<uint32_t>(random.Bits() % assignment.worker_count));
  }
  return assignment;
}

Reduction RandomReduction(Random& random) {
  Reduction reduction;
  reduction.maxima = RandomNumbers<double>(random, random.Bits() % 5);
  reduction.counts = RandomNumbers<uint64_t>(random, random.Bits() % 5);
  reduction.sums.resize(random.Bits() % 5);
  for (ExactSum& sum : reduction.sums) {
    for (int i = 0; i < 5; ++i) sum.Add((random.Unit() - 0.5) * std::ldexp(1.0, i * 30 - 60));
  }
  return reduction;
}

GatherPart RandomPart(Random& random) {
  GatherPart part{-12, RandomNumbers<int64_t>(random, 24), 5, 0.25, 0.125, {}};
  part.costs["occlusion"] = {random.Unit(), 5, 0};
  return part;
}

RoundReport RandomReport(Random& random) {
  RoundReport report;
  report.round = static_cast<uint32_t>(random.Bits());
  report.epsilon = random.Unit();
  report.error_estimate = random.Unit();
  report.emitted_w = {random.Unit(), random.Unit(), random.Unit()};
  report.crown_hash = random.Bits();
  report.links = random.Bits();
  report.cpu_s = random.Unit();
  report.error_closure = random.Unit();
  report.leaks = {random.Bits(), random.Unit()};
  report.error_rms = random.Unit();
  for (uint64_t& area : report.local_errors.area) area = random.Bits();
  report.local_errors.worst = random.Unit();
  report.local_errors.worst_leaf = {static_cast<uint32_t>(random.Bits()), random.Bits()};
  report.costs["mirrors"] = {random.Unit(), random.Bits(), 3};
  report.costs["textures"] = {random.Unit(), 0, 0};
  report.measured = {{"sheets", random.Unit(), 1 + random.Unit(), random.Unit(), true}};
  report.cut_cost_ns = RandomNumbers<double>(random, 9);
  report.cut_links = RandomNumbers<uint64_t>(random, 9);
  report.cut_elements = RandomNumbers<uint64_t>(random, 9);
  return report;
}

LinkErrors RandomErrors(Random& random) {
  LinkErrors errors;
  for (uint64_t& count : errors.histogram.count) count = random.Bits();
  errors.memory_bytes = random.Bits();
  return errors;
}

StartJob RandomStart(Random& random) {
  StartJob start;
  start.job = random.Bits();
  start.scene_hash = std::string(32, 'a');
  start.options.accuracy = random.Unit();
  start.options.epsilons = RandomNumbers<double>(random, 3);
  start.options.distribution = Distribution::kBalanced;
  start.options.balance = BalanceStrategy::kRotate;
  start.assignment = RandomAssignment(random);
  start.self = start.assignment.worker_count - 1;
  start.measured = {{"mirrors", random.Unit(), 2, {}, false}, {"medium", 0.5, 1, 3.0, true}};
  return start;
}

// What is sent, and a decoder that gives what it read in bytes again (or nothing).
struct Case {
  const char* name;
  std::string bytes;
  std::function<Result<std::string>(const std::string&)> round_trip;
};

template <typename T>
Case MakeCase(const char* name, const T& message) {
  return {name, Encode(message), [](const std::string& bytes) -> Result<std::string> {
            ASSIGN_OR_RETURN(const T read, DecodeMessage<T>(bytes));
            return Encode(read);
          }};
}

std::vector<Case> MakeCases(uint64_t seed) {
  Random random(seed);
  SubscribeRequest request;
  for (int i = 0; i < 4; ++i) request.wanted.push_back(RandomIds(random, random.Bits() % 20));
  Parcels parcels;
  parcels.parcels.push_back({3, 17, "some bytes"});
  parcels.parcels.push_back({0, 0, ""});
  return {
      MakeCase("StartJob", RandomStart(random)),
      MakeCase("NeedScene", NeedScene{std::string(32, '0')}),
      MakeCase("SceneData", SceneData{std::string(32, '0'), "not a scene"}),
      MakeCase("Started", Started{{1.0, 2.0, random.Unit()}}),
      MakeCase("Round", RoundCommand{3, 0.25, 0.02, true}),
      MakeCase("SolveGroup", SolveGroup{3, 0.02, "bytes"}),
      MakeCase("Reduce", RandomReduction(random)),
      MakeCase("Subscribe", request),
      MakeCase("SubscribeReply", SubscribeReply{RandomIds(random, 30)}),
      MakeCase("Values",
               Values{RandomNumbers<double>(random, 6), RandomNumbers<double>(random, 9)}),
      MakeCase("ValuesReply",
               ValuesReply{RandomNumbers<double>(random, 6), RandomNumbers<double>(random, 9)}),
      MakeCase("Sums", Sums{RandomNumbers<int64_t>(random, 6), RandomNumbers<int64_t>(random, 9)}),
      MakeCase("SumsReply",
               SumsReply{RandomNumbers<int64_t>(random, 6), RandomNumbers<int64_t>(random, 9)}),
      MakeCase("RoundReport", RandomReport(random)),
      MakeCase("LinkErrors", RandomErrors(random)),
      MakeCase("Replayed", Replayed{7}),
      MakeCase("Snapshot", SnapshotData{"bytes"}),
      MakeCase("Reassign", Reassign{RandomAssignment(random)}),
      MakeCase("Parcels", parcels),
      MakeCase("Absorb", Absorb{{"one", "", "three"}}),
      MakeCase("Gather", RandomGather(random)),
      MakeCase("GatherPart", RandomPart(random)),
      MakeCase("EndJob", EndJob{9}),
      MakeCase("Failed", Failed{Status(StatusCode::kInternal, "what went wrong")}),
      MakeCase("Progress", Progress{9, 2, 1.5}),
  };
}

TEST(ProtocolTest, EveryMessageComesBackAsItWas) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    for (const Case& c : MakeCases(seed)) {
      const Result<std::string> again = c.round_trip(c.bytes);
      ASSERT_TRUE(again.has_value())
          << c.name << " seed " << seed << ": " << again.error().message();
      EXPECT_EQ(*again, c.bytes) << c.name << " seed " << seed;
    }
  }
}

// Whatever arrives is refused or read as some valid message; nothing else happens.
TEST(ProtocolTest, DamagedMessagesNeverCrash) {
  constexpr uint64_t kSeed = 20240611;
  RecordProperty("seed", std::to_string(kSeed));
  Random random(kSeed);
  uint64_t refused = 0, read = 0;
  for (uint64_t round = 0; round < 300; ++round) {
    for (const Case& c : MakeCases(round % 7)) {
      std::string bytes = c.bytes;
      const uint64_t edits = 1 + random.Bits() % 4;
      for (uint64_t i = 0; i < edits && !bytes.empty(); ++i) {
        const size_t at = random.Bits() % bytes.size();
        switch (random.Bits() % 4) {
          case 0:
            bytes[at] = static_cast<char>(random.Bits());
            break;
          case 1:
            bytes.resize(at);
            break;
          case 2:
            bytes.insert(at, 1, static_cast<char>(random.Bits()));
            break;
          default:
            bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random.Bits() % 8)));
            break;
        }
      }
      const Result<std::string> again = c.round_trip(bytes);
      if (again.has_value()) {
        ++read;
        EXPECT_TRUE(c.round_trip(*again).has_value()) << c.name << " round " << round;
      } else {
        ++refused;
        EXPECT_FALSE(again.error().message().empty());
      }
    }
  }
  EXPECT_GT(refused, 0u);
  EXPECT_GT(read, 0u);
}

TEST(ProtocolTest, RefusesWhatTheReceiverCouldNotUse) {
  Random random(5);
  StartJob start = RandomStart(random);
  start.self = start.assignment.worker_count;
  EXPECT_FALSE(DecodeMessage<StartJob>(Encode(start)).has_value());
  start.self = 0;
  start.assignment.home[0] = start.assignment.worker_count;
  EXPECT_FALSE(DecodeMessage<StartJob>(Encode(start)).has_value());
  start.assignment.home[0] = 0;
  start.scene_hash = "short";
  EXPECT_FALSE(DecodeMessage<StartJob>(Encode(start)).has_value());

  EXPECT_FALSE(DecodeMessage<RoundCommand>(Encode(RoundCommand{1, 0.0, 0.1, false})).has_value());
  EXPECT_FALSE(DecodeMessage<RoundCommand>(Encode(RoundCommand{0, 1.0, 0.1, false})).has_value());

  EXPECT_FALSE(DecodeMessage<SolveGroup>(Encode(SolveGroup{64, 0.1, ""})).has_value());
  EXPECT_FALSE(DecodeMessage<SolveGroup>(Encode(SolveGroup{0, 0.0, ""})).has_value());

  const NodeId a{1, 1}, b{2, 1};
  EXPECT_TRUE(DecodeMessage<SubscribeReply>(Encode(SubscribeReply{{a, b}})).has_value());
  EXPECT_FALSE(DecodeMessage<SubscribeReply>(Encode(SubscribeReply{{b, a}})).has_value());
  EXPECT_FALSE(DecodeMessage<SubscribeReply>(Encode(SubscribeReply{{a, a}})).has_value());
  EXPECT_FALSE(DecodeMessage<SubscribeReply>(Encode(SubscribeReply{{NodeId{1, 0}}})).has_value());
  EXPECT_FALSE(
      DecodeMessage<GatherRequest>(Encode(GatherRequest{{NodeId{NodeId::kCluster, 0}}, 0.1, {}}))
          .has_value());
}

TEST(ProtocolTest, KindsHaveNames) {
  EXPECT_STREQ(ToText(MessageKind::kStartJob), "StartJob");
  EXPECT_STREQ(ToText(MessageKind::kProgress), "Progress");
  EXPECT_STREQ(ToText(static_cast<MessageKind>(9999)), "unknown message");
}

}  // namespace
}  // namespace isolux
