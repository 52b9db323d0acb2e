#include "worker/factors/factors.h"

#include <gtest/gtest.h>

#include "tests/support/factor_scenes.h"
#include "tests/support/polygons.h"
#include "tests/support/shapes.h"
#include "tests/worker/factors/exact_occluded.h"
#include "worker/factors/sampled_pair.h"

namespace isolux {
namespace {

using testing::AxisRectangle;
using testing::CornersOf;

FactorTable Compute(const Scene& scene, double tolerance, int threads = 2) {
  ThreadPool pool(threads);
  return ComputeFactors(scene, {.tolerance = tolerance}, pool).value();
}

testing::PanelledRoom SmallRoom() {
  testing::PanelledRoom room;
  room.panels = {6, 5, 4};
  room.low = {2, 2};
  room.high = {4, 3};
  return room;
}

TEST(FactorsTest, RowsOfAClosedRoomAddUpToOne) {
  const FactorTable table = Compute(testing::MakePanelledRoom(SmallRoom()), 1e-4);
  EXPECT_GT(table.pairs[static_cast<size_t>(Way::kHidden)], 100U);
  EXPECT_GT(table.pairs[static_cast<size_t>(Way::kClipped)], 100U);
  EXPECT_EQ(table.above_tolerance, 0U);
  double worst = 0, squares = 0;
  for (const FactorEnd& end : table.ends) {
    EXPECT_NEAR(end.row_sum_before, 1, 1e-3) << "polygon " << end.polygon;
    EXPECT_NEAR(end.row_sum_before, 1, end.row_error) << "polygon " << end.polygon;
    EXPECT_LE(end.row_sum, 1);
    EXPECT_NEAR(end.row_sum, 1, 1e-3);
    worst = std::max(worst, std::abs(end.row_sum_before - 1));
    squares += (end.row_sum_before - 1) * (end.row_sum_before - 1);
  }
  std::printf("%zu polygons, |row sum - 1| at most %.1e, root mean square %.1e\n",
              table.ends.size(), worst,
              std::sqrt(squares / static_cast<double>(table.ends.size())));
}

// Of two bodies one in the other, F from inner to outer is 1, back the ratio of the areas, and what
// is left the outer one sees of itself past the inner one.
TEST(FactorsTest, ConcentricSpheres) {
  std::vector<ConvexPolygon> polygons = testing::Sphere(1, 1, true);
  const size_t inner = polygons.size();
  for (const ConvexPolygon& part : testing::Sphere(2, 1, false)) polygons.push_back(part);
  const double ratio =
      testing::AreaOf(testing::Sphere(1, 1, true)) / testing::AreaOf(testing::Sphere(2, 1, true));
  const FactorTable table = Compute(testing::MakeScene(polygons), 1e-3);
  EXPECT_EQ(table.above_tolerance, 0U);
  double between = 0, within = 0, outer_area = 0, inner_area = 0;
  for (const Factor& factor : table.factors) {
    const bool p_inner = table.ends[factor.p].polygon < inner;
    const bool q_inner = table.ends[factor.q].polygon < inner;
    EXPECT_FALSE(p_inner && q_inner);
    (p_inner != q_inner ? between : within) += (p_inner != q_inner ? 1 : 2) * factor.coupling_m2;
  }
  for (const FactorEnd& end : table.ends) {
    (end.polygon < inner ? inner_area : outer_area) += end.area_m2;
    EXPECT_NEAR(end.row_sum_before, 1, end.row_error) << "polygon " << end.polygon;
    EXPECT_NEAR(end.row_sum_before, 1, 2e-3) << "polygon " << end.polygon;
  }
  EXPECT_NEAR(between / inner_area, 1, 1e-4);
  EXPECT_NEAR(between / outer_area, ratio, 1e-4);
  EXPECT_NEAR(within / outer_area, 1 - ratio, 1e-3);
}

TEST(FactorsTest, FinerTolerancesComeNearer) {
  const Scene scene = testing::MakePanelledRoom(SmallRoom());
  for (const double tolerance : {1e-2, 1e-3, 1e-5}) {
    double worst = 0;
    for (const FactorEnd& end : Compute(scene, tolerance).ends) {
      worst = std::max(worst, std::abs(end.row_sum_before - 1));
    }
    std::printf("tolerance %.0e: |row sum - 1| at most %.1e\n", tolerance, worst);
    EXPECT_LE(worst, 10 * tolerance);
  }
}

TEST(FactorsTest, TheSameBitsForAnyNumberOfThreads) {
  const Scene scene = testing::MakePanelledRoom(SmallRoom());
  const FactorTable one = Compute(scene, 1e-3, 1), three = Compute(scene, 1e-3, 3);
  ASSERT_EQ(one.factors.size(), three.factors.size());
  for (size_t i = 0; i < one.factors.size(); ++i) {
    ASSERT_EQ(one.factors[i].p, three.factors[i].p);
    ASSERT_EQ(one.factors[i].q, three.factors[i].q);
    ASSERT_EQ(one.factors[i].coupling_m2, three.factors[i].coupling_m2);
    ASSERT_EQ(one.factors[i].error_m2, three.factors[i].error_m2);
  }
}

// Exact to the tolerance as a scene: two squares and what stands between, fronts that face them.
TEST(FactorsTest, ExactCasesAsScenes) {
  for (const testing::OccludedCase& c : testing::OccludedCases()) {
    std::vector<ConvexPolygon> polygons{c.p, c.q};
    polygons.insert(polygons.end(), c.occluders.begin(), c.occluders.end());
    const FactorTable table = Compute(testing::MakeScene(polygons), 1e-5);
    double f = 0;
    for (const Factor& factor : table.factors) {
      if (factor.p == 0 && factor.q == 1) f = factor.coupling_m2;
    }
    EXPECT_NEAR(f, c.coupling_m2, 1e-5) << c.name;
  }
}

// A face that the importer divided is one row, and sees its own pieces where it is hollow.
TEST(FactorsTest, PiecesOfAFaceAreAddedUp) {
  const ConvexPolygon floor = AxisRectangle(2, 0, 0, 1, 0, 1, true);
  const ConvexPolygon wall = AxisRectangle(0, 0, 0, 1, 0, 1, true);
  const ConvexPolygon ceiling = AxisRectangle(2, 1, 0, 1, 0, 1, false);
  const FactorTable apart = Compute(testing::MakeScene({floor, wall, ceiling}), 1e-6);
  Scene folded = testing::MakeScene({floor, wall, ceiling});
  folded.polygons[1].file_polygon = 0;
  folded.polygons[2].file_polygon = 1;
  folded.file_polygon_count = 2;
  const FactorTable joined = Compute(folded, 1e-6);
  ASSERT_EQ(joined.ends.size(), 2U);
  EXPECT_DOUBLE_EQ(joined.ends[0].area_m2, 2);
  ASSERT_EQ(joined.factors.size(), 2U);
  ASSERT_EQ(apart.factors.size(), 3U);
  EXPECT_EQ(joined.factors[0].q, 0U);
  EXPECT_NEAR(joined.factors[0].coupling_m2, 2 * apart.factors[0].coupling_m2, 1e-6);
  EXPECT_NEAR(joined.factors[1].coupling_m2,
              apart.factors[1].coupling_m2 + apart.factors[2].coupling_m2, 1e-6);
}

TEST(FactorsTest, BothSidesAreRowsOfTheirOwn) {
  Scene scene = testing::MakeScene({AxisRectangle(2, 0, 0, 1, 0, 1, true),
                                    AxisRectangle(2, 1, 0, 1, 0, 1, true),
                                    AxisRectangle(2, 2, 0, 1, 0, 1, false)});
  scene.polygons[1].sides = kFrontTakesPart | kBackTakesPart;
  const FactorTable table = Compute(scene, 1e-6);
  ASSERT_EQ(table.ends.size(), 4U);
  EXPECT_EQ(table.ends[2].side, Side::kBack);
  ASSERT_EQ(table.factors.size(), 2U);
  EXPECT_EQ(table.factors[0].q, 2U);  // floor to the back of the sheet, and no further
  EXPECT_EQ(table.factors[1].p, 1U);
  EXPECT_EQ(table.factors[1].q, 3U);
  EXPECT_NEAR(table.factors[0].coupling_m2, 0.1998248956983873848, 1e-6);
}

// Two polygons in one place take the same light twice: the row is brought back to 1, and said.
TEST(FactorsTest, RowsAboveOneAreLoweredAndReported) {
  std::vector<ConvexPolygon> polygons{AxisRectangle(2, 0, 0, 1, 0, 1, true),
                                      AxisRectangle(2, 0.01, 0, 1, 0, 1, false),
                                      AxisRectangle(2, 0.01, 0, 0.5, 0, 1, false)};
  const FactorTable table = Compute(testing::MakeScene(polygons), 1e-4);
  EXPECT_GT(table.ends[0].row_sum_before, 1.4);
  EXPECT_LE(table.ends[0].row_sum, 1);
  EXPECT_NEAR(table.ends[0].row_sum, 1, 1e-9);
  EXPECT_EQ(table.rows_lowered, 1U);
  EXPECT_EQ(table.rows_beyond, 1U);
}

TEST(SampledPairTest, StatesItsError) {
  double ratio = 0;
  int count = 0, beyond = 0;
  for (const testing::OccludedCase& c : testing::OccludedCases()) {
    if (c.coupling_m2 == 0 || c.name.starts_with("cover")) continue;
    OccluderSet set(3);
    for (const ConvexPolygon& o : c.occluders) set.Add(CornersOf(o));
    const OccluderTree tree(set);
    const ShaftEnd p{CornersOf(c.p), c.p.Normal()}, q{CornersOf(c.q), c.q.Normal()};
    for (const double tolerance : {0.1, 0.02}) {
      for (uint64_t seed = 1; seed <= 25; ++seed) {
        const VisibleShare share =
            SampleVisibleShare(p, q, tree, c.unobstructed_m2, tolerance, seed);
        const double error = std::abs(share.value - c.coupling_m2 / c.unobstructed_m2);
        EXPECT_LE(share.error, tolerance) << c.name;
        EXPECT_LE(error, 4.0 / 3.0 * share.error) << c.name << ", seed " << seed;
        beyond += error > share.error ? 1 : 0;
        ratio += error / (share.error / 3);
        ++count;
      }
    }
  }
  ratio /= count;
  std::printf("%d of %d beyond what was stated; mean error %.2f standard errors\n", beyond, count,
              ratio);
  EXPECT_LE(beyond, count / 20);
  EXPECT_GT(ratio, 0.8 / 2);  // of a normal error the mean size is 0.8 standard errors
  EXPECT_LT(ratio, 0.8 * 2);
}

// Each dimension takes each of 2^k equal intervals once in 2^k points, scrambled or not.
TEST(SampledPairTest, SobolPointsAreStratified) {
  for (const uint32_t seed : {0U, 1U, 12345U}) {
    for (int d = 0; d < 4; ++d) {
      std::vector<int> hits(256, 0);
      for (uint32_t i = 0; i < 256; ++i) {
        const double x = ScrambledSobol(i, d, seed);
        ASSERT_GE(x, 0);
        ASSERT_LT(x, 1);
        ++hits[static_cast<size_t>(x * 256)];
      }
      EXPECT_EQ(*std::max_element(hits.begin(), hits.end()), 1) << "dimension " << d;
    }
  }
}

}  // namespace
}  // namespace isolux
