#include "worker/visibility/occluder_rays.h"

namespace isolux {

OccluderRays::OccluderRays(const OccluderSet& set) {
  const auto add = [&](const Vec3& normal, const Vec3& point) {
    planes_.push_back({static_cast<float>(normal.x), static_cast<float>(normal.y),
                       static_cast<float>(normal.z), static_cast<float>(glm::dot(normal, point))});
  };
  first_.reserve(size_t{set.size()} + 1);
  for (uint32_t i = 0; i < set.size(); ++i) {
    first_.push_back(static_cast<uint32_t>(planes_.size()));
    add(set[i].normal, set[i].point);
    const auto corners = set.corners(set[i]), inwards = set.inwards(set[i]);
    for (size_t k = 0; k < corners.size(); ++k) add(inwards[k], corners[k]);
  }
  first_.push_back(static_cast<uint32_t>(planes_.size()));
}

std::optional<uint32_t> OccluderRays::Passing(const std::array<FloatLanes, 3>& from,
                                              const std::array<FloatLanes, 3>& to, uint32_t asked,
                                              std::span<const uint32_t> candidates,
                                              float margin_m) const {
  uint32_t hidden = 0, doubtful = 0;
  for (const uint32_t candidate : candidates) {
    const FloatLanes a = planes_[first_[candidate]].Height(from);
    const FloatLanes b = planes_[first_[candidate]].Height(to);
    const FloatLanes size_a = Absolute(a), size_b = Absolute(b);
    const Int32Lanes off = (size_a > margin_m) & (size_b > margin_m);
    const Int32Lanes across = off & ((a > 0.0F) ^ (b > 0.0F));
    Int32Lanes inside = across, outside = off & ~across;
    for (uint32_t k = first_[candidate] + 1; k < first_[candidate + 1]; ++k) {
      const FloatLanes c = planes_[k].Height(from), d = planes_[k].Height(to);
      // How far inside the crossing is, times size_a + size_b.
      const FloatLanes crossing = size_b * c + size_a * d;
      const FloatLanes unsure = margin_m * (size_a + size_b + Absolute(c) + Absolute(d));
      inside &= crossing > unsure;
      outside |= (across & (crossing < -unsure)) | (Maximum(c, d) < -margin_m);
    }
    hidden |= static_cast<uint32_t>(Bits(inside));
    doubtful |= ~static_cast<uint32_t>(Bits(inside | outside));
  }
  if ((asked & doubtful & ~hidden) != 0) return std::nullopt;
  return asked & ~hidden;
}

}  // namespace isolux
