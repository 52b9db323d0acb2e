#include "worker/radiosity/exact_view.h"

#include "worker/coupling/clip.h"
#include "worker/coupling/point_factor.h"

namespace isolux {

void ExactView::SetLeaf(uint32_t leaf, const ConvexPolygon& shape, const Vec3& normal,
                        uint32_t polygon) {
  leaf_ = leaf;
  shape_ = shape;
  normal_ = normal;
  polygon_ = polygon;
}

Shaft ExactView::ShaftTo(std::span<const Vec3> from, const Source& source) const {
  const SceneOccluders& occluders = prover_.occluders();
  const auto end = [&](std::span<const Vec3> corners, const Vec3& normal, uint32_t polygon) {
    return ShaftEnd{corners, normal, occluders.region_of[polygon], occluders.plane_of[polygon]};
  };
  return {end(from, normal_, polygon_), end(source.corners, source.normal, source.polygon),
          occluders.set.tolerance_m()};
}

// For all points of the leaf at once.
void ExactView::Settle(const Source& source, ViewFromLeaf* view) {
  view->leaf = leaf_;
  const ClippedPolygon front =
      ClipToFront(shape_, source.corners[0], source.normal, prover_.occluders().set.tolerance_m());
  view->verdict = front.count == 0
                      ? Verdict::kBlocks
                      : prover_.tree().SettleShort(ShaftTo(front.corners(), source),
                                                   OccluderTree::kLongList, &view->obstacles);
}

std::optional<double> ExactView::ShareSeen(const Vec3& point, const Source& source,
                                           ViewFromLeaf* known) {
  if (known->leaf != leaf_) Settle(source, known);
  if (known->verdict != Verdict::kPartial) return known->verdict == Verdict::kOutside ? 1 : 0;
  if (known->obstacles.size() > OccluderTree::kLongList) return std::nullopt;
  const Verdict verdict =
      prover_.tree().Settle(ShaftTo({&point, 1}, source), known->obstacles, &found_);
  if (verdict != Verdict::kPartial) return verdict == Verdict::kOutside ? 1 : 0;
  if (found_.size() > kMostObstacles) return std::nullopt;
  const double whole =
      PointFormFactors(Vec3x4({point, point, point, point}), normal_, source.corners)[0];
  if (!(whole > 0)) return std::nullopt;
  const double share =
      clipper_.VisibleFactor(point, normal_, source.corners, found_, whole) / whole;
  return share < kLeastShare ? 0 : share;
}

}  // namespace isolux
