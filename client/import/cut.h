// Cutting one polygon along segments in it, into triangles and convex quads.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

// A segment in a polygon's plane along which it is to be divided.
struct CutSegment {
  Vec3 from, to;
  bool penetrates = false;  // another polygon passes through here; else its edge touches
};

struct CutLimits {
  uint32_t pieces = 256;
  // Lengths in metres. What is narrower than `width` along the border is not cut off; what is
  // shorter than `length` is not cut along.
  double width = 0, length = 0;
};

struct CutResult {
  std::vector<Vec3> points;                     // the polygon's corners, then those of cuts
  std::vector<std::array<uint32_t, 4>> pieces;  // as Polygon::vertices; oriented as the polygon
  uint32_t contacts = 0, penetrations = 0;      // segments that pieces are now divided along
  bool complete = true;                         // false where the number of pieces stopped it
};

struct ClippedSegments {
  std::vector<CutSegment> segments;
  uint32_t too_short = 0;  // left out for their length
};

// What of the segments lies inside the polygon, without those that run along its border.
ClippedSegments ClipSegments(const ConvexPolygon& polygon, std::span<const CutSegment> segments,
                             const CutLimits& limits);

// Cuts along each segment (from ClipSegments) and on to the border of the piece it lies in, so that
// the pieces stay convex. Cuts that run along segments for most of their length come first, then
// those that make rounder pieces; a piece much larger than what is to be cut out of it is first
// divided across its longest side. The pieces cover the polygon exactly and depend on the arguments
// alone.
CutResult CutPolygon(const ConvexPolygon& polygon, std::span<const CutSegment> segments,
                     const CutLimits& limits);

}  // namespace isolux
