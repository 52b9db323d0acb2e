// Groups of neighbouring polygons that look the same way: what may stand between two groups is
// found once for all their pairs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/vec.h"

namespace isolux {

struct GroupMember {
  Bounds3 bounds;
  Vec3 normal{0.0};
};

struct Group {
  std::vector<uint32_t> members;  // in order
  Bounds3 bounds;
};

// Each member is in one group.
std::vector<Group> MakeGroups(std::span<const GroupMember> members);

}  // namespace isolux
