// What lets lights through and what does not: the rays of LightField.
#include <algorithm>
#include <bit>

#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/light_field.h"

namespace isolux {

bool LightField::IsShutOut(const Source& source, uint32_t surface) const {
  return shadows_ && source.image == nullptr && scout_.closed[surface] != 0 &&
         !std::ranges::binary_search(source.lights_up, scout_.component[surface]);
}

uint32_t LightField::Reaches(const Source& source, const RayPacket& packet) const {
  if (packet.valid == 0) return 0;
  if (source.image != nullptr) {
    return VisibleThrough(rays_, mirrors_, *source.image, packet, shadows_);
  }
  return shadows_ ? rays_.Visible(packet) : packet.valid;
}

// Of rays to lights from `first` on: those to lights straight together, others one by one.
uint32_t LightField::FreeOf(size_t first, const RayPacket& packet) const {
  RayPacket part = packet;
  uint32_t free = 0, straight = 0;
  for (uint32_t left = packet.valid; left != 0; left &= left - 1) {
    const auto i = static_cast<size_t>(std::countr_zero(left));
    const Source& source = lights_[first + i];
    if (source.image == nullptr) {
      straight |= 1U << i;
      continue;
    }
    part.valid = 1U << i;
    free |= Reaches(source, part);
  }
  part.valid = straight;
  if (straight != 0) free |= shadows_ ? rays_.Visible(part) : straight;
  return free;
}

}  // namespace isolux
