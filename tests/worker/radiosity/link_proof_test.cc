// Proofs of links against rays: what is proved visible lets every ray pass, what is proved hidden
// none, whether candidates were looked for or inherited.
#include "worker/radiosity/link_proof.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <optional>

#include "common/util/random.h"
#include "tests/support/scenes.h"
#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/ray_scene.h"
#include "worker/radiosity/visibility.h"

namespace isolux {
namespace {

class Prover : public ::testing::Test {
 protected:
  Prover()
      : scene_(testing::CornellBox(true)),
        hierarchy_(scene_),
        rays_(hierarchy_),
        tree_(hierarchy_) {}

  // Rays of 200 between two elements that pass.
  int Passing(uint32_t p, uint32_t q, Random& random) const {
    int passed = 0;
    for (int i = 0; i < 200; ++i) {
      const auto point = [&](uint32_t node) {
        const double u = random.Unit();
        return SamplePolygon(DrawnIn(tree_.polygon(node), rays_.coordinate_noise_m()), u,
                             random.Unit());
      };
      const Segment segment{point(p), point(q), tree_.surface_of(p).polygon,
                            tree_.surface_of(q).polygon};
      const Vec3 d = segment.to - segment.from;
      if (glm::dot(tree_.normal(p), d) <= 0 || glm::dot(tree_.normal(q), d) >= 0) {
        ++skipped_;
        continue;
      }
      passed += rays_.Visible(segment) ? 1 : 0;
      ++traced_;
    }
    return passed;
  }

  Scene scene_;
  Hierarchy hierarchy_;
  RayScene rays_;
  Tree tree_;
  mutable int traced_ = 0, skipped_ = 0;
};

TEST_F(Prover, IsNeverContradictedByRays) {
  constexpr uint64_t kSeed = 5;
  Random random(kSeed);
  const LinkProver prover(hierarchy_);
  const auto surfaces = static_cast<uint32_t>(hierarchy_.surfaces().size());
  int visible = 0, hidden = 0, open = 0;
  for (int round = 0; round < 600; ++round) {
    uint32_t p = tree_.SurfaceIndex(random.Bits() % surfaces);
    uint32_t q = tree_.SurfaceIndex(random.Bits() % surfaces);
    if (hierarchy_.plane_of(tree_.surface_of(p).polygon) ==
        hierarchy_.plane_of(tree_.surface_of(q).polygon)) {
      continue;
    }
    CandidateList candidates;
    // Down a random road, with the candidates of above.
    for (int level = 0; level < 8; ++level) {
      CandidateList left;
      const Proof proof = prover.Settle(tree_, p, q, candidates, &left);
      if (proof != Proof::kNone) {
        traced_ = 0;
        const int passed = Passing(p, q, random);
        EXPECT_EQ(passed, proof == Proof::kVisible ? traced_ : 0) << "seed " << kSeed;
        ++(proof == Proof::kVisible ? visible : hidden);
        break;
      }
      ++open;
      candidates = left;
      uint32_t& divided = random.Unit() < 0.5 ? p : q;
      divided = tree_.MakeChildren(divided) + static_cast<uint32_t>(random.Bits() & 1);
    }
  }
  EXPECT_GT(visible, 50);
  EXPECT_GT(hidden, 50);
  EXPECT_GT(open, 50);
}

TEST_F(Prover, InheritsOnlyShorterLists) {
  Random random(9);
  const LinkProver prover(hierarchy_);
  const auto surfaces = static_cast<uint32_t>(hierarchy_.surfaces().size());
  int compared = 0;
  for (int round = 0; round < 400; ++round) {
    uint32_t p = tree_.SurfaceIndex(random.Bits() % surfaces);
    const uint32_t q = tree_.SurfaceIndex(random.Bits() % surfaces);
    CandidateList above, inherited, fresh;
    if (p == q || prover.Settle(tree_, p, q, nullptr, &above) != Proof::kNone) continue;
    p = tree_.MakeChildren(p);
    const Proof from_list = prover.Settle(tree_, p, q, above, &inherited);
    EXPECT_EQ(from_list, prover.Settle(tree_, p, q, nullptr, &fresh));
    if (from_list != Proof::kNone) continue;
    EXPECT_EQ(*inherited, *fresh);
    ++compared;
  }
  EXPECT_GT(compared, 20);
}

TEST_F(Prover, DecidesRaysAsTheSceneDoes) {
  constexpr uint64_t kSeed = 17;
  Random random(kSeed);
  const LinkProver prover(hierarchy_);
  const auto surfaces = static_cast<uint32_t>(hierarchy_.surfaces().size());
  int packets = 0, decided = 0, visible = 0, hidden = 0;
  for (int round = 0; round < 4000; ++round) {
    const uint32_t p = tree_.SurfaceIndex(random.Bits() % surfaces);
    const uint32_t q = tree_.SurfaceIndex(random.Bits() % surfaces);
    CandidateList among;
    if (p == q || prover.Settle(tree_, p, q, nullptr, &among) != Proof::kNone || !among) continue;
    const auto [packet, weight] = RaysBetween(tree_, rays_, kStraight, p, q, random.Bits());
    if (packet.valid == 0) continue;
    ++packets;
    const auto passing = prover.rays().Passing(packet.from, packet.to, packet.valid, *among,
                                               static_cast<float>(rays_.coordinate_noise_m()));
    if (!passing) continue;
    ++decided;
    EXPECT_EQ(*passing, rays_.Visible(packet)) << "seed " << kSeed;
    visible += std::popcount(*passing);
    hidden += std::popcount(packet.valid & ~*passing);
  }
  EXPECT_GT(packets, 500);
  EXPECT_GT(decided, 0.9 * packets);
  EXPECT_GT(visible, 500);
  EXPECT_GT(hidden, 500);
}

// A unit square seen from above: what ends in its plane or crosses its border is left open.
TEST(OccluderRays, LeavesOpenWhatIsNear) {
  OccluderSet set(10);
  set.Add(std::array{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)});
  const OccluderRays rays(set);
  constexpr float kMargin = 1e-5F;
  const auto passing = [&](float x, float from_z, float to_z) {
    const std::array<FloatLanes, 3> from{SplatFloat(x), SplatFloat(0.5F), SplatFloat(from_z)};
    const std::array<FloatLanes, 3> to{SplatFloat(x), SplatFloat(0.5F), SplatFloat(to_z)};
    return rays.Passing(from, to, 0xff, std::array{0U}, kMargin);
  };
  EXPECT_EQ(passing(0.5F, 1, -1), 0U);
  EXPECT_EQ(passing(1.1F, 1, -1), 0xffU);
  EXPECT_EQ(passing(0.5F, 1, 0.5F), 0xffU);
  EXPECT_EQ(passing(1.1F, 1, 0), 0xffU);
  EXPECT_EQ(passing(0.5F, 1, 0), std::nullopt);
  EXPECT_EQ(passing(1, 1, -1), std::nullopt);
}

}  // namespace
}  // namespace isolux
