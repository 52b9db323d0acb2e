// What a surface receives from: the links of its nodes and of the clusters above them, made into
// blocks of sources. For gather.cc.
#pragma once

#include <unordered_map>
#include <vector>

#include "common/hierarchy/snapshot.h"
#include "worker/radiosity/gather.h"
#include "worker/radiosity/gather_block.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/slots.h"

namespace isolux {

class SourceFinder {
 public:
  // Over the links homed here. Keeps references to all but the placement and the links' list.
  // `between`: what made the links, with the medium and the panes.
  SourceFinder(const Tree& tree, const Placement& placement, const LinkSet& links,
               const Snapshot& snapshot, const RefineScene& between);

  // Radiosity of the leaf at or below `node` that holds this point of it, over that of the node; of
  // the sums over the channels.
  double RelativeRadiosityAt(uint32_t node, const Vec3& point) const;

  // Largest radiosity of all leaves and channels, W/m².
  double largest_radiosity() const { return largest_; }

  // What the links of a surface or element bring to points at or below it, in units of 1/scale
  // W/m²; to a surface also what comes over the links of the clusters above. The same for all
  // leaves below, so made once for them.
  void Fill(uint32_t node, const SurfaceFrame& frame, const GatherOptions& options, double scale,
            SourceBlock& block) const;

  // How closely points of this leaf look at sources in doubt.
  GatherCare CareAt(uint32_t leaf, const GatherOptions& options) const;

 private:
  // A link at one of its ends.
  struct End {
    const Link* link;
    bool at_q;
    uint32_t other() const { return at_q ? link->p : link->q; }
    // A node sees its own image once, over a link that stands for half of it.
    double share() const { return link->p == link->q ? 2 : 1; }
  };
  // What stays the same while a block is filled.
  struct Filling {
    uint32_t receiver;  // the surface or element
    double arriving;    // its irradiance, of which shares are taken, sum of channels, W/m²
    Vec3 centre{0.0}, normal{0.0};
    double scale;
    const GatherOptions& options;
    SourceBlock& block;
  };
  // A link's other end, or a part of it.
  struct Part {
    uint32_t node;
    double factor;  // about, of what is seen of it from the receiver
    int level;      // below the link's end
    double visibility, doubt;
    uint64_t seed;
    const MirrorImage* image;  // that is seen of it; null: itself
    Glazed glazed = {};        // what panes leave of it
    ConvexPolygon shape = {};  // a part of it that is alike all over; without corners: all of it
  };

  void PullRadiosity(const Snapshot& snapshot);
  void PullIrradiance(const Snapshot& snapshot);
  void ListEnds(const Placement& placement, const LinkSet& links);
  void AddEnd(const Filling& filling, uint32_t node, const End& end) const;
  void AddClusterEnd(const Filling& filling, const End& end) const;
  // What panes leave of a link's light.
  Lanes LeftByPanesOf(const Link& link) const;
  Glazed GlazedOf(const Link& link) const;
  // What the medium leaves of light from a node's middle to the receiver's.
  Lanes LeftAtCentre(const Filling& filling, uint32_t other, const MirrorImage* image) const;
  // Whether it leaves so different shares of light from parts of a source that these are to be
  // looked at one by one.
  bool VariesByMedium(const Part& part) const;
  // Whether borders of panes may cross what goes from a part to the receiver. Where no pane does,
  // the part is said not to be glazed.
  bool IsCutByPanes(const Filling& filling, Part* part) const;
  void OpenLeaf(const Filling& filling, const Part& part) const;
  void Open(const Filling& filling, const Part& part) const;
  double FactorAtCentre(const Filling& filling, uint32_t other, const MirrorImage* image) const;
  const MirrorImage* ImageAt(const End& end) const;

  const Tree& tree_;
  RefineScene between_;
  const Medium* medium_;
  const Snapshot& snapshot_;
  Slots slots_;
  double inverse_unit_m_ = 1;
  std::vector<Lanes> radiosity_;   // by slot
  std::vector<float> irradiance_;  // by node, elements only: area mean, sum of channels, W/m²
  std::vector<uint64_t> first_;    // of the ends of each node: ends_[first_[n] .. first_[n+1])
  std::vector<End> ends_;
  // What panes leave of links of clusters, which all surfaces below share.
  std::unordered_map<const Link*, Rgb> left_of_clusters_;
  double largest_ = 0;
  double least_irradiance_ = 0;  // W/m², over the channels, below which a leaf counts as dark
};

}  // namespace isolux
