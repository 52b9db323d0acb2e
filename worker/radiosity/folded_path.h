// Paths by way of mirrors: straight to an image, folded in the scene.
#pragma once

#include <span>

#include "common/hierarchy/mirrors.h"
#include "common/hierarchy/panes.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {

// Of a packet whose goals are points of an image (to_polygon: that of their original), the bits of
// the segments that pass all its mirrors and, where `look`, have nothing in the way of any leg.
uint32_t VisibleThrough(const RayScene& rays, const Mirrors& mirrors, const MirrorImage& image,
                        const RayPacket& packet, bool look);

// Where a ray ends, mirrors followed, when `hit` is what it meets first.
struct RayEnd {
  double share = 1;  // of its light, that the mirrors leave; below a thousandth it is not followed
  int reflections = 0;
  RayHit hit;  // that is no mirror, or one it is not followed from
  Vec3 direction{0.0};
  Vec3 from{0.0};    // of the last leg
  double way_m = 0;  // of the legs before it
  Rgb left{1.0};     // by panes on those legs
};
// panes: null where there are none.
RayEnd EndOf(const RayScene& rays, const Mirrors& mirrors, Escape ray, RayHit hit,
             const Hierarchy& hierarchy, const Panes* panes = nullptr);

// Share of a ray's light that leaves the scene.
double EscapedShare(const RayScene& rays, const Mirrors& mirrors, const Escape& ray,
                    const RayHit& hit, const Hierarchy& hierarchy);

}  // namespace isolux
