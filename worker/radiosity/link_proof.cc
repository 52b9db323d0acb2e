#include "worker/radiosity/link_proof.h"

#include "worker/coupling/clip.h"

namespace isolux {

LinkProver::LinkProver(const Hierarchy& hierarchy)
    : occluders_(MakeOccluders(hierarchy.scene())), tree_(occluders_.set), rays_(occluders_.set) {}

Proof LinkProver::Settle(const Tree& tree, uint32_t p, uint32_t q, const CandidateList& above,
                         CandidateList* left) const {
  const double tolerance_m = occluders_.set.tolerance_m();
  const Vec3 p_normal = tree.normal(p), q_normal = tree.normal(q);
  const ConvexPolygon &p_shape = tree.polygon(p), &q_shape = tree.polygon(q);
  const ClippedPolygon p_front = ClipToFront(p_shape, q_shape.v[0], q_normal, tolerance_m);
  const ClippedPolygon q_front = ClipToFront(q_shape, p_shape.v[0], p_normal, tolerance_m);
  if (p_front.count == 0 || q_front.count == 0) return Proof::kHidden;
  const auto region = [&](uint32_t node) {
    return occluders_.region_of[tree.surface_of(node).polygon];
  };
  const Shaft shaft({p_front.corners(), p_normal, region(p)},
                    {q_front.corners(), q_normal, region(q)}, tolerance_m);
  std::vector<uint32_t> found;
  const Verdict verdict =
      above ? tree_.Settle(shaft, *above, &found) : tree_.SettleShort(shaft, kLongest, &found);
  if (verdict == Verdict::kOutside) return Proof::kVisible;
  if (verdict == Verdict::kBlocks) return Proof::kHidden;
  *left = found.size() <= kLongest ? std::make_shared<const std::vector<uint32_t>>(std::move(found))
                                   : nullptr;
  return Proof::kNone;
}

}  // namespace isolux
