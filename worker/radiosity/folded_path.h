// Paths by way of mirrors: straight to an image, folded in the scene.
#pragma once

#include <span>

#include "common/hierarchy/mirrors.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {

// Of a packet whose goals are points of an image (to_polygon: that of their original), the bits of
// the segments that pass all its mirrors and, where `look`, have nothing in the way of any leg.
uint32_t VisibleThrough(const RayScene& rays, const Mirrors& mirrors, const MirrorImage& image,
                        const RayPacket& packet, bool look);

// Share of a ray's light that leaves the scene, mirrors followed, when `hit` is what it meets
// first.
double EscapedShare(const RayScene& rays, const Mirrors& mirrors, Escape ray, RayHit hit,
                    const Hierarchy& hierarchy);

}  // namespace isolux
