// The shaft of two convex polygons: the hull of all segments between them, and what a convex
// occluder does to those segments. The verdicts are proofs: kOutside and kBlocks hold for every
// segment, up to the tolerance of OccluderSet; kPartial claims nothing. For `factors`, and for
// links whose visibility is to be certain.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "worker/visibility/occluder_set.h"

namespace isolux {

enum class Verdict : uint8_t {
  kOutside,  // crosses no segment
  kBlocks,   // crosses every segment
  kPartial,
};

// One end: a convex polygon, counter-clockwise about its normal, in front of the other's plane (or
// on it).
struct ShaftEnd {
  static constexpr int kMaxCorners = 5;  // a quad cut by a plane
  std::span<const Vec3> corners;
  Vec3 normal{0.0};
  uint32_t region = kNoRegion;  // occluders of it never block
  uint32_t plane = kNoRegion;   // likewise, where it is told
};

// The half-space n·x ≤ offset.
struct HalfSpace {
  Vec3 normal{0.0};
  double offset = 0;
};

class Shaft {
 public:
  Shaft(const ShaftEnd& p, const ShaftEnd& q, double tolerance_m);

  // False where no point of the box lies in the shaft; true may be wrong near its edges.
  bool MayTouch(const Bounds3& box) const;

  Verdict Classify(const OccluderSet& set, const Occluder& occluder) const;

  // Appends those of `candidates` that are not outside. Returns true where one of them blocks
  // everything; the list is then of no use.
  bool Filter(const OccluderSet& set, std::span<const uint32_t> candidates,
              std::vector<uint32_t>* kept) const;

 private:
  void AddSides(std::span<const Vec3> base, const Vec3& normal, std::span<const Vec3> other);
  bool BlocksAll(const OccluderSet& set, const Occluder& occluder) const;

  std::array<Vec3, size_t{2} * ShaftEnd::kMaxCorners> corners_;  // of p, then of q
  int p_count_, count_;
  std::array<HalfSpace, 2 + 2 * ShaftEnd::kMaxCorners> planes_;
  int plane_count_ = 0;
  Bounds3 bounds_;
  uint32_t p_region_, q_region_, p_plane_, q_plane_;
  double tolerance_m_;
};

}  // namespace isolux
