// What a point sees of a polygon past occluders, exactly: the polygon less the central projections
// of the occluders, as convex pieces, and Lambert's form factor of what is left. For links and
// factors that are partly visible, while their candidates are few.
#pragma once

#include <span>
#include <vector>

#include "worker/visibility/occluder_set.h"

namespace isolux {

// Keeps its memory between calls: one for each thread.
class PointClipper {
 public:
  // Keeps a pointer to the set.
  explicit PointClipper(const OccluderSet& set) : set_(&set) {}

  // Form factor in [0, 1] from x on a plane of unit normal n to what x sees of the convex polygon
  // `q`, which lies in front of that plane and has its own front towards x. Only `candidates`
  // block. `whole` is the form factor to all of q.
  double VisibleFactor(const Vec3& x, const Vec3& n, std::span<const Vec3> q,
                       std::span<const uint32_t> candidates, double whole);

  // What the calls so far have cost: pieces looked at for each occluder, some 0.05 µs each.
  uint64_t work() const { return work_; }

 private:
  struct Piece {
    uint32_t first = 0, count = 0;
  };
  struct Cut {  // the half-space normal·y ≥ offset, y relative to x
    Vec3 normal{0.0};
    double offset = 0;
    double tolerance = 0;
  };

  // Whether the occluder may hide something of q: false where all of it is beyond one side of the
  // cone from x over q.
  bool MayHide(const Vec3& x, const Occluder& occluder) const;
  void MakeCuts(const Vec3& x, const Occluder& occluder, double height);
  void Subtract(const Piece& piece);
  // Divides `piece` along a cut into what is inside and, as a finished piece, what is outside.
  Piece Divide(const Piece& piece, const Cut& cut);
  double FactorOfPieces(const Vec3& n) const;

  const OccluderSet* set_;
  std::vector<Vec3> corners_;  // of all pieces, relative to x
  std::vector<Piece> pieces_, next_;
  std::vector<Vec3> cone_;       // of q: normals of its sides, outwards
  std::vector<Cut> cuts_;        // of one occluder: what lies in all of them is hidden
  std::vector<double> heights_;  // of one piece's corners over one cut
  uint64_t work_ = 0;
};

}  // namespace isolux
