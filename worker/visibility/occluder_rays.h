// Eight segments at once against a few occluders, in single precision, where the answer is beyond
// doubt: a small part of what a packet costs in the tree of a scene.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "worker/coupling/float_lanes.h"
#include "worker/visibility/occluder_set.h"

namespace isolux {

class OccluderRays {
 public:
  explicit OccluderRays(const OccluderSet& set);

  // Which of the segments (bits of `asked`) cross none of the candidates. Nothing where one of them
  // comes within the margin of deciding otherwise: ends in an occluder's plane, crossings at its
  // border. The margin is many roundings of the coordinates in single precision.
  std::optional<uint32_t> Passing(const std::array<FloatLanes, 3>& from,
                                  const std::array<FloatLanes, 3>& to, uint32_t asked,
                                  std::span<const uint32_t> candidates, float margin_m) const;

 private:
  struct Plane {
    float x, y, z, offset;
    FloatLanes Height(const std::array<FloatLanes, 3>& at) const {
      return x * at[0] + y * at[1] + z * at[2] - offset;
    }
  };
  std::vector<Plane> planes_;    // of each occluder its own, then through its sides, inwards
  std::vector<uint32_t> first_;  // of each occluder; one more at the end
};

}  // namespace isolux
