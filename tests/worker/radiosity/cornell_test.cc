// The Cornell box against an independent dense solution.
#include <gtest/gtest.h>

#include <cmath>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "tests/support/output_gather.h"
#include "tests/support/reference.h"
#include "tests/support/scenes.h"
#include "worker/shard.h"

namespace isolux {
namespace {

constexpr int kPoints = 400;

class CornellBox : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scene_ = new std::shared_ptr<const Scene>(std::make_shared<Scene>(testing::CornellBox(false)));
    ThreadPool pool(2);
    const testing::DenseReference reference(**scene_, 900, 16, pool);
    const Hierarchy hierarchy(**scene_);
    // Points uniform over the surfaces, as tiny elements.
    Random random(5);
    std::vector<double> area_up_to;
    for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
      area_up_to.push_back((s > 0 ? area_up_to.back() : 0) + hierarchy.surface_area_m2(s));
    }
    for (int i = 0; i < kPoints; ++i) {
      const auto it =
          std::lower_bound(area_up_to.begin(), area_up_to.end(), random.Unit() * area_up_to.back());
      points_.push_back(
          {static_cast<uint32_t>(it - area_up_to.begin()), (1ULL << 40) | random.Bits() >> 24});
    }
    std::sort(points_.begin(), points_.end());
    expected_.resize(kPoints);
    pool.For(kPoints, 8, [&](size_t begin, size_t end, int) {
      for (size_t i = begin; i < end; ++i) {
        const ConvexPolygon element =
            ElementGeometry(hierarchy.geometry(points_[i].surface), points_[i].path);
        expected_[i] = reference.IrradianceAt(points_[i].surface, element.Centroid(), 32, i);
      }
    });
  }
  static void TearDownTestSuite() {
    delete scene_;
    scene_ = nullptr;
  }

  // Solves to an accuracy and compares; returns mean |ΔH| / mean H over points and channels.
  double ErrorAt(double accuracy, RoundReport* last) {
    ThreadPool pool(2);
    Shard shard(*scene_, &pool);
    SolveOptions options;
    options.accuracy = accuracy;
    EXPECT_TRUE(shard.Start(options, {{{NodeId::kCluster, 0}}, {0}, 1}, 0).ok());
    NullExchange exchange;
    double epsilon = 1e-2 * Sum(shard.EmittedPower());
    Snapshot snapshot;
    do {
      *last = shard.RunRound(epsilon, accuracy, exchange).value();
      snapshot = shard.TakeSnapshot();
      EXPECT_TRUE(shard.InstallSnapshot(snapshot).ok());
      epsilon /= 4;
    } while (last->error_estimate > accuracy && last->round < 12);
    const GatherPart part =
        testing::GatherOutput(shard, Hierarchy(**scene_), snapshot, points_, {}, accuracy).value();
    double difference = 0, sum = 0;
    for (int i = 0; i < kPoints; ++i) {
      for (int c = 0; c < 3; ++c) {
        const double h = std::ldexp(static_cast<double>(part.sums[12 * i + c]), -part.exponent);
        difference += std::abs(h - expected_[i][c]);
        sum += expected_[i][c];
      }
    }
    return difference / sum;
  }

  static std::shared_ptr<const Scene>* scene_;
  static std::vector<NodeId> points_;
  static std::vector<Rgb> expected_;
};
std::shared_ptr<const Scene>* CornellBox::scene_ = nullptr;
std::vector<NodeId> CornellBox::points_;
std::vector<Rgb> CornellBox::expected_;

TEST_F(CornellBox, AgreesWithADenseSolutionWithinTheAccuracyAsked) {
  for (const double accuracy : {0.1, 0.05}) {
    RoundReport report;
    const double error = ErrorAt(accuracy, &report);
    std::printf("accuracy %.3f: error %.4f, estimate %.4f, imbalance %.4f, %lu links\n", accuracy,
                error, report.error_estimate, report.energy_imbalance,
                static_cast<unsigned long>(report.links));
    EXPECT_LT(error, 1.5 * accuracy);
    EXPECT_LE(report.error_estimate, accuracy);
    EXPECT_LT(report.energy_imbalance, accuracy);
  }
}

}  // namespace
}  // namespace isolux
