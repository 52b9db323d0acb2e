#include "server/weld.h"

#include <gtest/gtest.h>

#include "common/util/random.h"

namespace isolux {
namespace {

using Face = std::array<uint32_t, 4>;

TEST(Welder, JoinsWithinTheToleranceAndGroup) {
  Welder welder(1e-6, Vec3(-1), 4);
  const uint32_t a = welder.Vertex({0.5, 0, 0}, 0);
  EXPECT_EQ(welder.Vertex({0.5 + 0.9e-6, 0, 0}, 0), a);
  EXPECT_NE(welder.Vertex({0.5 + 3e-6, 0, 0}, 0), a);
  EXPECT_NE(welder.Vertex({0.5, 0, 0}, 1), a);
  EXPECT_EQ(welder.positions()[a], Vec3(0.5, 0, 0));
}

// However corners fall on the cells of the hash, it finds what trying all pairs finds.
TEST(Welder, EqualsTryingAllPairs) {
  constexpr uint64_t kSeed = 7;
  SCOPED_TRACE(::testing::Message() << "seed " << kSeed);
  constexpr double kTolerance = 1e-3;
  Random random(kSeed);
  Welder welder(kTolerance, Vec3(0), 8);  // few expected: it must grow
  std::vector<Vec3> positions;
  std::vector<uint32_t> groups;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p(0.3 * random.Unit(), 0.02 * random.Unit(), 0.01 * random.Unit());
    const auto group = static_cast<uint32_t>(random.Bits() % 2);
    size_t expected = 0;
    while (expected < positions.size() &&
           (groups[expected] != group || glm::length(positions[expected] - p) > kTolerance)) {
      ++expected;
    }
    EXPECT_EQ(welder.Vertex(p, group), expected);
    if (expected == positions.size()) {
      positions.push_back(p);
      groups.push_back(group);
    }
  }
  EXPECT_GT(positions.size(), 1024U);
}

TEST(TVertices, StandOnTheSideOfTheLargerFace) {
  // A large square, and to its right three small ones.
  Welder welder(1e-6, Vec3(0), 16);
  const auto v = [&](double x, double y) { return welder.Vertex({x, y, 0}, 0); };
  std::vector<Face> faces{{v(0, 0), v(3, 0), v(3, 3), v(0, 3)}};
  for (int i = 0; i < 3; ++i) faces.push_back({v(3, i), v(4, i), v(4, i + 1), v(3, i + 1)});
  const auto found = FindTVertices(welder, faces);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].face, 0U);
  EXPECT_EQ(found[0].side, 1U);
  EXPECT_EQ(found[0].vertex, v(3, 1));
  EXPECT_DOUBLE_EQ(found[0].along, 1.0 / 3);
  EXPECT_EQ(found[1].vertex, v(3, 2));
}

TEST(TVertices, OtherGroupsDoNotCount) {
  Welder welder(1e-6, Vec3(0), 16);
  const auto v = [&](double x, double y, uint32_t group) {
    return welder.Vertex({x, y, 0}, group);
  };
  const std::vector<Face> faces{
      {v(0, 0, 0), v(2, 0, 0), v(2, 2, 0), v(0, 2, 0)},
      {v(2, 0, 1), v(3, 0, 1), v(3, 1, 1), v(2, 1, 1)},
      {v(2, 1, 1), v(3, 1, 1), v(3, 2, 1), kNoCorner},
  };
  EXPECT_TRUE(FindTVertices(welder, faces).empty());
}

TEST(TVertices, OverlappingSidesShareEachOthersEnds) {
  Welder welder(1e-6, Vec3(0), 16);
  const auto v = [&](double x, double y) { return welder.Vertex({x, y, 0}, 0); };
  const std::vector<Face> faces{
      {v(0, 0), v(2, 0), v(2, 1), v(0, 1)},   // its upper side covers 0 … 2
      {v(1, 1), v(3, 1), v(3, 2), kNoCorner}  // its lower side covers 1 … 3
  };
  const auto found = FindTVertices(welder, faces);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].vertex, v(1, 1));
  EXPECT_EQ(found[0].side, 2U);
  EXPECT_EQ(found[1].vertex, v(2, 1));
  EXPECT_EQ(found[1].face, 1U);
}

}  // namespace
}  // namespace isolux
