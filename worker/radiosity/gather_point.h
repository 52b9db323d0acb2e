// Irradiance at one point: the form factors of all its sources, rays to those in doubt, and the
// sum. For gather.cc; one for each thread.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "worker/radiosity/exact_view.h"
#include "worker/radiosity/gather_block.h"
#include "worker/radiosity/gather_sources.h"
#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {

// Where irradiance is wanted.
struct GatherPlace {
  Vec3 position{0.0};
  uint64_t seed = 0;
  int64_t* sums = nullptr;  // three, one a channel
};

// What eight sources bring, rounded to integers and summed: the sum of the integers does not depend
// on which sources stand together.
int64_t SumOfRounded(FloatLanes arriving);

class PointGather {
 public:
  // mirrors: null where there are none. `between`: what made the links, with the medium and panes.
  PointGather(const RayScene& rays, const SourceFinder& sources, const Mirrors* mirrors,
              const RefineScene& between)
      : rays_(rays),
        sources_(sources),
        mirrors_(mirrors),
        medium_(between.medium),
        panes_(between.panes) {
    if (between.prover != nullptr) view_.emplace(*between.prover);
  }

  // The leaf that the next places lie on. `scale`: of sums, as in the blocks.
  void SetLeaf(const Tree& tree, uint32_t leaf, const GatherCare& care, double scale) {
    rays_per_doubt_ = static_cast<float>(care.rays_per_doubt_w_m2);
    rays_per_w_m2_ = static_cast<float>(1 / care.ray_from_w_m2);
    exact_from_w_m2_ = static_cast<float>(care.exact_from_w_m2);
    tolerance_ = care.tolerance_w_m2 * scale;
    normal_ = tree.normal(leaf);
    own_polygon_ = tree.surface_of(leaf).polygon;
    if (view_) view_->SetLeaf(leaf, tree.polygon(leaf), normal_, own_polygon_);
  }

  // Adds to place.sums what all sources bring, in units of 1/scale W/m².
  void Evaluate(const GatherPlace& place, std::span<SourceBlock* const> blocks);

  uint64_t traced() const { return traced_; }
  uint64_t traced_by_mirrors() const { return traced_by_mirrors_; }  // of them

 private:
  // A source at the point that rays go to.
  struct Look {
    RayTarget* target;
    const SourceOctet* octet;
    int lane;
    float wanted;  // rays
    float factor;
    float stands_for;     // sources like it, of which this one gets rays by chance
    bool exactly;         // is to be seen so; rays where it cannot be
    int rays = 0;         // sent so far
    double u = 0, v = 0;  // where the next one goes
    double passed = 0, squares = 0, total = 0;  // weights of the rays
    Rgb passed_panes{0.0};                      // of those that pass, with what panes leave of them
  };
  // A ray of a packet.
  struct Pick {
    uint32_t look;
    double weight;  // of the kernel
  };

  void AddBlock(SourceBlock& block, PlanePoint at, uint32_t place_seed, int64_t* sums);
  // gather_medium.cc: the same through the medium or panes, and what the medium leaves of light
  // from sources, or over a distance in the block's unit.
  void AddBlockThrough(const GatherPlace& place, SourceBlock& block);
  // gather_glass.cc: what panes leave of light from sources; whether they stand before any.
  bool LeftByPanes(const GatherPlace& place, SourceBlock& block, size_t octet, FloatLanes factor,
                   std::array<FloatLanes, 3>* left) const;
  Rgb LeftByPanesOf(const GatherPlace& place, const RayTarget& target) const;
  Rgb LeftByPanesTo(const Vec3& from, const Vec3& to, const MirrorImage* image) const {
    return image == nullptr ? panes_->Along(from, to) : panes_->Along(from, to, *image);
  }
  std::array<FloatLanes, 3> LeftOf(const SourceOctet& octet, PlanePoint at) const;
  std::array<FloatLanes, 3> Left(FloatLanes distance) const;
  void ListLooks(SourceBlock& block, size_t octet, FloatLanes factor, UInt32Lanes place_seed);
  bool SeeExactly(const GatherPlace& place, Look& look);
  float Brings(const Look& look) const;  // unhidden, in units of sums, over the channels
  float CarefulRays(const Look& look) const;
  int MoreRays(const Look& look) const;  // that follow the first where these disagree
  void Aim(const GatherPlace& place, uint32_t look, int rays);
  FloatLanes Kernel(const GatherPlace& place, const FloatPoints& to, const Vec3& normal) const;
  uint32_t Visible() const;
  void Trace();
  void Correct(const GatherPlace& place) const;

  const RayScene& rays_;
  const SourceFinder& sources_;
  const Mirrors* mirrors_;
  const Medium* medium_;
  const Panes* panes_;
  std::optional<ExactView> view_;
  float rays_per_doubt_ = 0, rays_per_w_m2_ = 0, exact_from_w_m2_ = 0;  // GatherCare
  double tolerance_ = 0;                                                // of sums
  std::array<float, 3> extinction_{};  // over the unit of the block that is added
  // Beside looks_, what is left of their light: by the medium, and by panes on the whole; empty
  // without either.
  struct LeftOfLook {
    std::array<float, 3> by_medium{1, 1, 1}, by_panes{1, 1, 1};
  };
  std::vector<LeftOfLook> left_of_looks_;
  Vec3 normal_{0.0};
  uint32_t own_polygon_ = 0;
  std::vector<Look> looks_;
  RayPacket packet_;
  std::array<Pick, RayScene::kPacket> picks_;
  int count_ = 0;
  uint32_t mirrored_ = 0;  // of the packet, by bits: those by way of mirrors
  uint64_t traced_ = 0, traced_by_mirrors_ = 0;
};

}  // namespace isolux
