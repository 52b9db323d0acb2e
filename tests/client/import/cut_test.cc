#include "client/import/cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/scene/plane_frame.h"
#include "common/util/random.h"

namespace isolux {
namespace {

ConvexPolygon PieceOf(const CutResult& cut, size_t i) {
  ConvexPolygon piece;
  for (const uint32_t v : cut.pieces[i]) {
    if (v != kNoVertex) piece.v[piece.count++] = cut.points[v];
  }
  return piece;
}

std::vector<CutSegment> Outline(const std::vector<Vec3>& corners) {
  std::vector<CutSegment> segments;
  for (size_t i = 0; i < corners.size(); ++i)
    segments.push_back({corners[i], corners[(i + 1) % corners.size()]});
  return segments;
}

const ConvexPolygon kSquare{4, {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(4, 4, 0), Vec3(0, 4, 0)}};
const CutLimits kLimits{256, 1e-4, 1e-3};

TEST(Cut, LeavesOutWhatLiesUnderABlock) {
  const auto segments = Outline({{1, 1, 0}, {2.5, 1, 0}, {2.5, 3, 0}, {1, 3, 0}});
  const CutResult cut = CutPolygon(kSquare, segments, kLimits);
  EXPECT_TRUE(cut.complete);
  EXPECT_EQ(cut.contacts, 4U);
  EXPECT_EQ(cut.pieces.size(), 5U);
  int covered = 0;
  for (size_t i = 0; i < cut.pieces.size(); ++i) {
    const ConvexPolygon piece = PieceOf(cut, i);
    if (glm::length(piece.Centroid() - Vec3(1.75, 2, 0)) > 1e-12) continue;
    ++covered;
    EXPECT_NEAR(piece.Area(), 3, 1e-14);
  }
  EXPECT_EQ(covered, 1);
}

TEST(Cut, ForgetsWhatRunsAlongTheBorder) {
  const std::vector<CutSegment> segments{{Vec3(0, 0, 0), Vec3(4, 0, 0)},
                                         {Vec3(3.99999, -1, 0), Vec3(3.99999, 5, 0)},
                                         {Vec3(-1, 2, 0), Vec3(0, 2, 0)},
                                         {Vec3(5, 5, 0), Vec3(6, 6, 0)}};
  const ClippedSegments clipped = ClipSegments(kSquare, segments, kLimits);
  EXPECT_TRUE(clipped.segments.empty());
  EXPECT_EQ(clipped.too_short, 0U);
  const std::vector<CutSegment> tiny{{Vec3(2, 2, 0), Vec3(2.0005, 2, 0)}};
  EXPECT_EQ(ClipSegments(kSquare, tiny, kLimits).too_short, 1U);
}

TEST(Cut, ApproachesSmallThingsInLargePolygons) {
  // A leg of 5 cm in a floor of 4 m: strips 4 m long and 5 cm wide would be poor elements.
  const auto segments = Outline({{1, 1, 0}, {1.05, 1, 0}, {1.05, 1.05, 0}, {1, 1.05, 0}});
  const CutResult cut = CutPolygon(kSquare, segments, kLimits);
  EXPECT_TRUE(cut.complete);
  EXPECT_LE(cut.pieces.size(), 24U);
  for (size_t i = 0; i < cut.pieces.size(); ++i) {
    const ConvexPolygon piece = PieceOf(cut, i);
    double longest = 0;
    for (int k = 0; k < piece.count; ++k)
      longest = std::max(longest, glm::length(piece.v[(k + 1) % piece.count] - piece.v[k]));
    EXPECT_GT(piece.Area(), 0.05 * longest * longest);
  }
}

TEST(Cut, StopsAtTheLimitAndSaysSo) {
  std::vector<CutSegment> segments;
  for (int i = 1; i < 40; ++i) {
    segments.push_back({Vec3(0.1 * i, 0, 0), Vec3(0.1 * i, 4, 0)});
    segments.push_back({Vec3(0, 0.1 * i, 0), Vec3(4, 0.1 * i, 0)});
  }
  CutLimits limits = kLimits;
  limits.pieces = 20;
  const CutResult cut = CutPolygon(kSquare, segments, limits);
  EXPECT_FALSE(cut.complete);
  EXPECT_LE(cut.pieces.size(), 20U);
  double area = 0;
  for (size_t i = 0; i < cut.pieces.size(); ++i) area += PieceOf(cut, i).Area();
  EXPECT_NEAR(area, 16, 1e-13);
}

TEST(Cut, PiecesCoverThePolygonOnceAndFollowTheSegments) {
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Random random(Mix(seed));
    const auto unit = [&] { return 2 * random.Unit() - 1; };
    const double size = std::pow(10.0, 6 * random.Unit() - 3);
    const PlaneFrame frame(size * 10 * Vec3(unit(), unit(), unit()),
                           glm::normalize(Vec3(unit(), unit(), unit())));
    // Corners on a circle, in order.
    ConvexPolygon polygon{3 + static_cast<int>(random.Bits() % 2), {}};
    for (int k = 0; k < polygon.count; ++k) {
      const double angle = 2 * M_PI * (k + 0.6 * random.Unit()) / polygon.count;
      polygon.v[k] = frame.Solid({size * std::cos(angle), size * std::sin(angle)});
    }
    std::vector<CutSegment> segments;
    for (uint64_t n = 1 + random.Bits() % 8; n > 0; --n) {
      segments.push_back({frame.Solid({size * unit(), size * unit()}),
                          frame.Solid({size * unit(), size * unit()})});
    }
    const CutLimits limits{2000, 1e-4 * size, 2e-3 * size};
    const CutResult cut =
        CutPolygon(polygon, ClipSegments(polygon, segments, limits).segments, limits);
    ASSERT_TRUE(cut.complete);
    double area = 0;
    std::vector<ConvexPolygon> pieces;
    for (size_t i = 0; i < cut.pieces.size(); ++i) {
      pieces.push_back(PieceOf(cut, i));
      EXPECT_TRUE(HasArea(pieces[i]));
      EXPECT_TRUE(IsConvex(pieces[i]));
      EXPECT_GT(glm::dot(pieces[i].AreaVector(), polygon.Normal()), 0);
      area += pieces[i].Area();
      CutLimits wider = limits;
      wider.width *= 4;
      wider.length *= 4;
      EXPECT_TRUE(ClipSegments(pieces[i], segments, wider).segments.empty());
    }
    EXPECT_NEAR(area, polygon.Area(), 1e-12 * polygon.Area());
    const auto holds = [&](const ConvexPolygon& piece, const Vec3& p, double slack) {
      for (int k = 0; k < piece.count; ++k) {
        const Vec3 along = glm::normalize(piece.v[(k + 1) % piece.count] - piece.v[k]);
        if (glm::dot(glm::cross(along, p - piece.v[k]), polygon.Normal()) < slack) return false;
      }
      return true;
    };
    for (int i = 0; i < 200; ++i) {
      const Vec3 p = frame.Solid({size * unit(), size * unit()});
      const auto count = [&](double slack) {
        return std::count_if(pieces.begin(), pieces.end(),
                             [&](const ConvexPolygon& piece) { return holds(piece, p, slack); });
      };
      EXPECT_LE(count(1e-9 * size), 1);
      EXPECT_TRUE(!holds(polygon, p, 1e-9 * size) || count(-1e-9 * size) >= 1);
    }
  }
}

}  // namespace
}  // namespace isolux
