// What a leaf receives from, made ready for evaluation at many points of it: for gather.cc.
#pragma once

#include <span>
#include <vector>

#include "common/hierarchy/snapshot.h"
#include "worker/coupling/clip.h"
#include "worker/radiosity/gather.h"
#include "worker/radiosity/slots.h"

namespace isolux {

// A source: an element in front of the leaf, or a cluster seen as from its centre.
struct Source {
  ClippedPolygon polygon;  // of an element; count 0 for a cluster
  Vec3 normal{0.0};        // of an element
  Vec3 point{0.0};         // on an element; the centre of a cluster
  double facing_m2 = 0;    // of a cluster: its area that faces the leaf
  Lanes radiosity{};       // by channel, W/m²
  double visibility = 1;   // of the link
  double doubt = 0;        // of the link
  double rays = 0;         // rays wanted at a point, over the form factor there
  // Of a source that is partly hidden and varies, where rays must find what it is that is seen: the
  // element, to look up the leaf a ray meets; kNoNode for others.
  uint32_t varying = kNoNode;
  uint32_t surface_polygon = 0;
  uint64_t seed = 0;
};

struct LeafSources {
  std::vector<Source> sources;
  IntLanes even{};  // what arrives alike all over the leaf, in units of 1/scale W/m²
};

class SourceFinder {
 public:
  SourceFinder(const Tree& tree, const Placement& placement, const LinkSet& links,
               const Snapshot& snapshot);

  // Radiosity of the leaf at or below `node` that holds this point of it, over that of the node; of
  // the sums over the channels.
  double RelativeRadiosityAt(uint32_t node, const Vec3& point) const;

  // Largest radiosity of all leaves and channels, W/m².
  double largest_radiosity() const { return largest_; }

  // Over the links homed here. scale: units a W/m².
  LeafSources Find(uint32_t leaf, const GatherOptions& options, double scale) const;

 private:
  // A link at one of its ends.
  struct End {
    const Link* link;
    bool at_q;
    uint32_t other() const { return at_q ? link->p : link->q; }
  };
  // What stays the same while the sources of one leaf are found.
  struct Receiver {
    uint32_t leaf = 0;
    Vec3 centre{0.0}, normal{0.0};
    double arriving = 0;       // irradiance that shares are taken of, sum of channels, W/m²
    double rays_per_w_m2 = 0;  // K over the leaf's doubt
  };

  void PullRadiosity(const Snapshot& snapshot);
  void ListEnds(const Placement& placement, const LinkSet& links);
  void Add(const Receiver& receiver, uint32_t node, const End& end, const GatherOptions& options,
           double scale, LeafSources& found) const;
  void Open(const Receiver& receiver, uint32_t other, double factor, const Source& from, int level,
            const GatherOptions& options, std::vector<Source>& sources) const;
  double FactorAtCentre(const Receiver& receiver, uint32_t other) const;

  const Tree& tree_;
  const Snapshot& snapshot_;
  Slots slots_;
  std::vector<Lanes> radiosity_;  // by slot
  std::vector<uint64_t> first_;   // of the ends of each node: ends_[first_[n] .. first_[n+1])
  std::vector<End> ends_;
  double largest_ = 0;
  double least_irradiance_ = 0;  // W/m², over the channels, below which a leaf counts as dark
};

// Form factor of a cluster from a point: its facing area as a disk at its centre, seen by the
// cosine; bounded however near it is.
Lanes ClusterFactors(const Vec3x4& points, const Vec3& n, const Vec3& centre, double facing_m2);

}  // namespace isolux
