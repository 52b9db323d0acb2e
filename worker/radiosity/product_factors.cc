// What products multiply by, and products through a medium or panes of glass: what these leave of
// each link's light stands beside the links, so that these stay as they are. And the values behind
// sheets.
#include <algorithm>

#include "worker/radiosity/glazed_links.h"
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
    if (glass_ == Glass::kNone) return factors_;
    for (const Glazed& glazed : glazed_) {
      const double left = glass_ == Glass::kGrey ? glazed.left[0] : 0.0;
      factors_[glazed.link].to_p *= left;
      factors_[glazed.link].to_q *= left;
    }
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

void Product::SetPanes(const RefineScene* glazed) {
  const Glass before = glass_;
  const bool none = glazed == nullptr || glazed->panes == nullptr;
  glass_ = none ? Glass::kNone : glazed->panes->is_grey() ? Glass::kGrey : Glass::kByChannel;
  if (!none && !looked_for_panes_) FindGlazed(*glazed);
  if (before != glass_) factors_.clear();
}

void Product::FindGlazed(const RefineScene& scene) {
  looked_for_panes_ = true;
  constexpr size_t kTogether = 1024;
  std::vector<std::vector<Glazed>> found((ends_.size() + kTogether - 1) / kTogether);
  pool_.For(found.size(), 1, [&](size_t begin, size_t end, int) {
    for (size_t part = begin; part < end; ++part) {
      const size_t last = std::min(ends_.size(), (part + 1) * kTogether);
      for (size_t i = part * kTogether; i < last; ++i) {
        const Rgb left = LeftByPanes(scene, tree_, LinkAt(i));
        if (left != Rgb(1.0)) found[part].push_back({i, Lanes{left.x, left.y, left.z, 1}});
      }
    }
  });
  for (const std::vector<Glazed>& part : found) {
    glazed_.insert(glazed_.end(), part.begin(), part.end());
  }
}

void Product::AddLinksByChannel(size_t first, size_t last, const Lanes* value,
                                IntLanes* sum) const {
  for (size_t i = first; i < last; ++i) {
    const Slots::Ends& e = ends_[i];
    sum[e.p] += ToInteger(value[e.q] * transmissions_[i] * factors_[i].to_p);
    sum[e.q] += ToInteger(value[e.p] * transmissions_[i] * factors_[i].to_q);
  }
}

void Product::AddGlazed(size_t first, size_t last, const Lanes* value, IntLanes* sum) const {
  auto glazed = std::lower_bound(glazed_.begin(), glazed_.end(), first,
                                 [](const Glazed& g, size_t link) { return g.link < link; });
  for (; glazed != glazed_.end() && glazed->link < last; ++glazed) {
    const size_t i = glazed->link;
    const Slots::Ends& e = ends_[i];
    double coupling_m2 = LinkAt(i).coupling_m2();
    if (absorption_ == Absorption::kGrey) coupling_m2 *= transmissions_[i][0];
    Lanes left = glazed->left;
    if (absorption_ == Absorption::kByChannel) left *= transmissions_[i];
    sum[e.p] += ToInteger(value[e.q] * left * (coupling_m2 * inverse_area_[e.p]));
    sum[e.q] += ToInteger(value[e.p] * left * (coupling_m2 * inverse_area_[e.q]));
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
