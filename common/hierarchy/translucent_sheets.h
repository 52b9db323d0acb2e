// Translucent sheets: polygons that pass light on diffusely from either side to the other. With ρ
// what a sheet reflects and τ what it passes, its two sides radiate
//
//   B = E + ρ H + τ H'     B' = E' + ρ H' + τ H     H, H' the irradiances of the two sides.
//
// To all that works with B = E + ρH what is passed on, τH', is exitance of the side where it comes
// out. Elements of equal path are the same piece of the two sides (Subdivide, element.h), and
// whatever divides one divides the other (worker/radiosity/sheet_leaves.h): the light of a piece
// comes out of one piece.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/effects_plan.h"

namespace isolux {

class TranslucentSheets {
 public:
  static constexpr uint32_t kNone = 0xffffffffu;

  TranslucentSheets() = default;  // none
  // Those of the scene, where the plan wants them.
  TranslucentSheets(const Hierarchy& hierarchy, const EffectsPlan& plan);

  bool empty() const { return partner_.empty(); }
  // The other side of the polygon; kNone where the surface is no side of a sheet.
  uint32_t PartnerOf(uint32_t surface) const { return empty() ? kNone : partner_[surface]; }
  // The same piece seen from the other side; `id` is an element of a sheet.
  NodeId PartnerOf(const NodeId& id) const { return {partner_[id.surface], id.path}; }
  // Share of what arrives that comes out on the other side.
  const Rgb& TransmittanceOf(uint32_t surface) const {
    static constexpr Rgb kOpaque{0.0};
    return empty() ? kOpaque : transmittance_[surface];
  }

  // By leaf of the snapshot: the irradiance (W/m²) of the same piece on the other side, and how far
  // it ranges there; 0 where there is none. Empty where there are no sheets.
  struct Behind {
    std::array<double, 3> irradiance{};
    double spread = 0;
  };
  std::vector<Behind> BehindLeaves(std::span<const LeafRecord> leaves) const;

 private:
  std::vector<uint32_t> partner_;
  std::vector<Rgb> transmittance_;
};

// Of corner k of a piece of a sheet: which of the same piece on the other side is the same point
// (FromBehind, element.h).
inline int CornerBehind(int corners, int k) { return corners == 4 ? 3 - k : (3 - k) % 3; }

}  // namespace isolux
