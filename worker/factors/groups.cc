#include "worker/factors/groups.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace isolux {
namespace {

constexpr size_t kMostMembers = 8;

// Place and direction in one space: opposite directions are as far apart as the scene is long.
using Key = std::array<double, 6>;

void Divide(std::span<const Key> keys, std::span<uint32_t> members,
            std::vector<std::vector<uint32_t>>* groups) {
  if (members.size() <= kMostMembers) {
    groups->emplace_back(members.begin(), members.end());
    return;
  }
  size_t widest = 0;
  double width = -1;
  for (size_t d = 0; d < 6; ++d) {
    double low = keys[members[0]][d], high = low;
    for (const uint32_t m : members) {
      low = std::min(low, keys[m][d]);
      high = std::max(high, keys[m][d]);
    }
    if (high - low > width) {
      width = high - low;
      widest = d;
    }
  }
  std::sort(members.begin(), members.end(), [&](uint32_t a, uint32_t b) {
    return std::pair(keys[a][widest], a) < std::pair(keys[b][widest], b);
  });
  // At the middle of the range rather than of the list: walls come apart where they meet.
  const double middle = keys[members.front()][widest] + 0.5 * width;
  size_t cut = 0;
  while (cut < members.size() && keys[members[cut]][widest] <= middle) ++cut;
  if (cut == 0 || cut == members.size()) cut = members.size() / 2;
  Divide(keys, members.first(cut), groups);
  Divide(keys, members.subspan(cut), groups);
}

}  // namespace

std::vector<Group> MakeGroups(std::span<const GroupMember> members) {
  Bounds3 all;
  for (const GroupMember& member : members) all.Add(member.bounds);
  std::vector<Key> keys(members.size());
  for (size_t i = 0; i < members.size(); ++i) {
    const Vec3 centre = members[i].bounds.Centre();
    const Vec3 direction = 0.5 * all.Diagonal() * members[i].normal;
    keys[i] = {centre.x, centre.y, centre.z, direction.x, direction.y, direction.z};
  }
  std::vector<uint32_t> order(members.size());
  std::iota(order.begin(), order.end(), 0U);
  std::vector<std::vector<uint32_t>> lists;
  if (!order.empty()) Divide(keys, order, &lists);
  std::vector<Group> groups(lists.size());
  for (size_t g = 0; g < lists.size(); ++g) {
    groups[g].members = std::move(lists[g]);
    std::sort(groups[g].members.begin(), groups[g].members.end());
    for (const uint32_t m : groups[g].members) groups[g].bounds.Add(members[m].bounds);
  }
  return groups;
}

}  // namespace isolux
