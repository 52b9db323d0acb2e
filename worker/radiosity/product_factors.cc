// What products multiply by, and products through a medium: what that leaves of each link's light
// stands beside the links, so that these stay as they are. And the values behind sheets.
#include "worker/radiosity/matvec.h"

namespace isolux {

const std::vector<Product::Factors>& Product::factors() {
  if (factors_.size() != ends_.size()) {
    factors_.resize(ends_.size());
    pool_.For(ends_.size(), 8192, [&](size_t begin, size_t end, int) {
      for (size_t i = begin; i < end; ++i) {
        const double coupling_m2 = LinkAt(i).coupling_m2() *
                                   (absorption_ == Absorption::kGrey ? transmissions_[i][0] : 1.0);
        factors_[i] = {coupling_m2 * inverse_area_[ends_[i].p],
                       coupling_m2 * inverse_area_[ends_[i].q]};
      }
    });
  }
  return factors_;
}

void Product::SetMedium(const Medium* medium) {
  const Absorption before = absorption_;
  absorption_ = medium == nullptr   ? Absorption::kNone
                : medium->is_grey() ? Absorption::kGrey
                                    : Absorption::kByChannel;
  if (medium != nullptr && transmissions_.empty()) MakeTransmissions(*medium);
  // A grey one is part of the factors.
  if ((before == Absorption::kGrey) != (absorption_ == Absorption::kGrey)) factors_.clear();
}

void Product::MakeTransmissions(const Medium& medium) {
  transmissions_.resize(ends_.size());
  pool_.For(ends_.size(), 1024, [&](size_t begin, size_t end, int) {
    for (size_t i = begin; i < end; ++i) {
      const Rgb left = TransmissionOf(medium, tree_, LinkAt(i));
      transmissions_[i] = Lanes{left.x, left.y, left.z, 1};
    }
  });
}

void Product::AddLinksByChannel(size_t first, size_t last, const Lanes* value,
                                IntLanes* sum) const {
  for (size_t i = first; i < last; ++i) {
    const Slots::Ends& e = ends_[i];
    sum[e.p] += ToInteger(value[e.q] * transmissions_[i] * factors_[i].to_p);
    sum[e.q] += ToInteger(value[e.p] * transmissions_[i] * factors_[i].to_q);
  }
}

template <typename V>
Status Product::Behind(std::span<const V> leaf_values, std::span<V> behind) {
  PullOwn<V>(leaf_values, V{} + 1.0);
  RETURN_IF_ERROR(SendOwnValues<V>());
  RETURN_IF_ERROR(ReceiveOtherValues<V>());
  const std::vector<V>& value = values<V>().of_slot;
  for (size_t i = 0; i < behind.size(); ++i) {
    const uint32_t slot = active_.behind[i];
    behind[i] = slot == kNoNode ? V{} : value[slot];
  }
  return {};
}

template Status Product::Behind(std::span<const Single>, std::span<Single>);
template Status Product::Behind(std::span<const Lanes>, std::span<Lanes>);

}  // namespace isolux
