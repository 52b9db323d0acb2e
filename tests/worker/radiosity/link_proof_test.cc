// Proofs of links against rays: what is proved visible lets every ray pass, what is proved hidden
// none, whether candidates were looked for or inherited.
#include "worker/radiosity/link_proof.h"

#include <gtest/gtest.h>

#include "common/util/random.h"
#include "tests/support/scenes.h"
#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/ray_scene.h"

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

}  // namespace
}  // namespace isolux
