// What points of a leaf see of polygons past what stands between, exactly: in the place of rays
// where a source brings so much that what few rays miss of it would show, as where light leaves a
// lamp by a narrow opening.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "worker/radiosity/link_proof.h"
#include "worker/visibility/clipped_factor.h"

namespace isolux {

// What may stand between a leaf and a source.
struct ViewFromLeaf {
  uint32_t leaf = 0xffffffffu;  // that it holds for; none yet
  Verdict verdict = Verdict::kPartial;
  std::vector<uint32_t> obstacles;  // where the verdict is partial, as far as there are few
};

// Keeps its memory between calls: one for each thread.
class ExactView {
 public:
  // More obstacles than this before a point cost more than rays.
  static constexpr size_t kMostObstacles = 8;
  // A lesser share is none: a gap that is no more than rounding, as below a leg on a floor.
  static constexpr double kLeastShare = 1e-6;

  // Keeps a reference. As for rays, what lies in the plane of an end does not stand before it.
  explicit ExactView(const LinkProver& prover)
      : prover_(prover), clipper_(prover.occluders().set) {}

  // Where the next points lie. `polygon`: of the scene.
  void SetLeaf(uint32_t leaf, const ConvexPolygon& shape, const Vec3& normal, uint32_t polygon);

  struct Source {
    std::span<const Vec3> corners;  // convex, in front of the leaf's plane
    Vec3 normal{0.0};
    uint32_t polygon = 0;
  };
  // Share of the form factor from a point of the leaf, in front of the source, that is seen, in
  // [0, 1]; nothing where too much may stand between. `known`: of this source, made where it is not
  // of this leaf.
  std::optional<double> ShareSeen(const Vec3& point, const Source& source, ViewFromLeaf* known);

 private:
  Shaft ShaftTo(std::span<const Vec3> from, const Source& source) const;
  void Settle(const Source& source, ViewFromLeaf* view);

  const LinkProver& prover_;
  uint32_t leaf_ = 0xffffffffu, polygon_ = 0;
  ConvexPolygon shape_;
  Vec3 normal_{0.0};
  PointClipper clipper_;
  std::vector<uint32_t> found_;
};

}  // namespace isolux
