#include "worker/radiosity/matvec.h"

#include <immintrin.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/util/check.h"

namespace isolux {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Product::Product(const Tree& tree, const Placement& placement, LinkSet& links,
                 const ActiveNodes& active, ThreadPool& pool, Exchange& exchange)
    : tree_(tree),
      placement_(placement),
      active_(active),
      pool_(pool),
      exchange_(exchange),
      slots_(tree) {
  const auto first_remote = std::partition(
      links.own.begin(), links.own.end(),
      [&](const Link& link) { return placement.IsMine(link.p) && placement.IsMine(link.q); });
  const auto local_count = static_cast<size_t>(first_remote - links.own.begin());
  local_ = std::span(links.own).first(local_count);
  remote_ = std::span(links.own).subspan(local_count);
  for (const Link& link : links.crown) {
    if (placement.HomeOfLink(link.p, link.q) == placement.self()) crown_.push_back(link);
  }
  const size_t count = slots_.count(tree);
  inverse_area_.resize(count);
  for (uint32_t slot = 0; slot < count; ++slot) {
    const uint32_t node = slots_.NodeOf(slot);
    const double area = slots_.is_cluster(slot)
                            ? tree.facing().area_m2(node, slots_.DirectionOf(slot))
                            : tree.area_m2(node);
    inverse_area_[slot] = area > 0 ? 1 / area : 0;
  }
  ends_.resize(links.own.size() + crown_.size());
  pool.For(ends_.size(), 8192, [&](size_t begin, size_t end, int) {
    for (size_t i = begin; i < end; ++i) {
      const Link& link = LinkAt(i);
      ends_[i] = slots_.Of(tree, link);
    }
  });
  inheritance_.assign(count, 1.0);
  ListSteps();
}

// By number: nodes follow the ones above them, clusters come first, and memory is passed through in
// its order.
void Product::ListSteps() {
  std::vector<uint8_t> is_divided(tree_.size(), 0);
  for (size_t k = 0; k < active_.own.size(); ++k) {
    if (active_.is_leaf[k] == 0) is_divided[active_.own[k]] = 1;
  }
  for (uint32_t node = 0; node < tree_.size(); ++node) {
    if (is_divided[node] == 0) continue;
    if (tree_.is_cluster(node)) {
      own_clusters_.push_back(node);
      continue;
    }
    const uint32_t child = tree_.node(node).first_child;
    steps_.push_back({slots_.OfElement(node),
                      slots_.OfElement(child),
                      {tree_.area_m2(child), tree_.area_m2(child + 1)}});
  }
}

template <typename V>
Product::Values<V>& Product::values() {
  auto& values = std::get<Values<V>>(values_);
  if (values.of_slot.empty()) {
    values.of_slot.assign(inverse_area_.size(), V{});
    values.cut_upward.resize(placement_.cut_size());
  }
  return values;
}

template <typename Int>
Product::Totals<Int>& Product::totals() {
  auto& totals = std::get<Totals<Int>>(totals_);
  if (totals.by_thread.empty()) {
    totals.by_thread.assign(static_cast<size_t>(pool_.thread_count()),
                            std::vector<Int>(inverse_area_.size(), Int{}));
    totals.from_above.resize(inverse_area_.size());
  }
  return totals;
}

template <>
void Product::AddLinks<Lanes>(size_t first, size_t last, const Lanes* value, IntLanes* sum) const {
  for (size_t i = first; i < last; ++i) {
    const Slots::Ends& e = ends_[i];
    const Lanes to_p = value[e.q] * factors_[i].to_p, to_q = value[e.p] * factors_[i].to_q;
    sum[e.p] += ToInteger(to_p);
    sum[e.q] += ToInteger(to_q);
  }
}

// Two links at a time, side by side: to_p and to_q of the one, then of the other. Pairs from both
// halves in turns: links that follow each other often end at the same slot, whose sum would have to
// wait.
template <>
void Product::AddLinks<Single>(size_t first, size_t last, const Single* value,
                               IntSingle* sum) const {
  const auto* values = reinterpret_cast<const double*>(value);
  auto* sums = reinterpret_cast<int64_t*>(sum);
  const auto add_pair = [&](size_t i) {
    const Slots::Ends &a = ends_[i], &b = ends_[i + 1];
    const Lanes x{values[a.q], values[a.p], values[b.q], values[b.p]};
    const auto factor = reinterpret_cast<Lanes>(_mm256_loadu_pd(&factors_[i].to_p));
    const auto to = reinterpret_cast<__m256i>(ToInteger<Lanes>(x * factor));
    const __m128i to_a = _mm256_castsi256_si128(to), to_b = _mm256_extracti128_si256(to, 1);
    sums[a.p] += _mm_cvtsi128_si64(to_a);
    sums[a.q] += _mm_cvtsi128_si64(_mm_unpackhi_epi64(to_a, to_a));
    sums[b.p] += _mm_cvtsi128_si64(to_b);
    sums[b.q] += _mm_cvtsi128_si64(_mm_unpackhi_epi64(to_b, to_b));
  };
  const size_t half = (last - first) / 4 * 2;
  for (size_t i = first; i < first + half; i += 2) {
    add_pair(i);
    add_pair(i + half);
  }
  for (size_t i = first + 2 * half; i < last; ++i) {
    const Slots::Ends& e = ends_[i];
    sum[e.p] += ToInteger<Single>(value[e.q] * factors_[i].to_p);
    sum[e.q] += ToInteger<Single>(value[e.p] * factors_[i].to_q);
  }
}

template <typename V>
Status Product::IrradianceOf(std::span<const V> radiosity, const V& bound, std::span<V> irradiance,
                             LinkScope scope, std::span<V> inherited) {
  // |F x| ≤ |x| < 2^50 units: the sum of a row that adds up to 1 has room to spare.
  V scale = V{} + 1.0, unit = scale;
  bool any = false;
  for (int c = 0; c < kChannelsOf<V>; ++c) {
    if (!(gain_ * bound[c] > 0)) continue;
    any = true;
    const int exponent = std::min(1000, 49 - std::ilogb(gain_ * bound[c]));
    scale[c] = std::ldexp(1.0, exponent);
    unit[c] = std::ldexp(1.0, -exponent);
  }
  if (!any) {
    // Nothing radiates, here or anywhere.
    std::fill(irradiance.begin(), irradiance.end(), V{});
    return {};
  }
  using Int = MaskOf<V>;
  factors();
  const auto apply = [&](size_t first, size_t last, Int* sum) {
    if constexpr (std::is_same_v<V, Lanes>) {
      if (absorption_ == Absorption::kByChannel) {
        AddLinksByChannel(first, last, values<V>().of_slot.data(), sum);
      } else {
        AddLinks<V>(first, last, values<V>().of_slot.data(), sum);
      }
      if (glass_ == Glass::kByChannel) AddGlazed(first, last, values<V>().of_slot.data(), sum);
      return;
    }
    AddLinks<V>(first, last, values<V>().of_slot.data(), sum);
  };
  RETURN_IF_ERROR((Transport<V, Int>(radiosity, scale, kChannelsOf<V>, {}, apply, scope)));
  for (size_t i = 0; i < leaf_count(); ++i) irradiance[i] = ToReal(ArrivedAt<Int>(i)) * unit;
  const std::vector<Int>& from_above = totals<Int>().from_above;
  for (size_t i = 0; i < inherited.size(); ++i) {
    inherited[i] = ToReal(from_above[slots_.OfElement(active_.leaves[i])]) * unit;
  }
  return {};
}

template Status Product::IrradianceOf(std::span<const Single>, const Single&, std::span<Single>,
                                      LinkScope, std::span<Single>);
template Status Product::IrradianceOf(std::span<const Lanes>, const Lanes&, std::span<Lanes>,
                                      LinkScope, std::span<Lanes>);

Status Product::SetInheritance(std::span<const double> of_leaves) {
  CHECK_EQ(of_leaves.size(), leaf_count());
  for (size_t i = 0; i < of_leaves.size(); ++i) {
    inheritance_[slots_.OfElement(active_.leaves[i])] = of_leaves[i];
  }
  // Nodes are means of leaves, each times its factor. The sharpest bound would depend on the cut,
  // and with it the unit of sums.
  Reduction reduction;
  reduction.maxima = {1};
  for (const double factor : of_leaves) {
    reduction.maxima[0] = std::max(reduction.maxima[0], factor);
  }
  ASSIGN_OR_RETURN(const Reduction total, exchange_.Reduce(std::move(reduction)));
  gain_ = total.maxima[0];
  return {};
}

// What an element gives to the radiosity of its parent.
template <typename V>
V Product::Upward(uint32_t child) const {
  const auto& values = std::get<Values<V>>(values_);
  if (placement_.InCrown(tree_.node(child).parent) && !placement_.InCrown(child)) {
    return values.cut_upward[placement_.CutOf(child)];
  }
  const uint32_t slot = slots_.OfElement(child);
  return values.of_slot[slot] * inheritance_[slot];
}

// Radiosity of a cluster as seen from one direction: the mean over the area that faces it.
template <typename V>
V Product::PullCluster(uint32_t cluster, int direction) const {
  const std::vector<V>& value = std::get<Values<V>>(values_).of_slot;
  V sum{};
  tree_.ForEachChild(cluster, [&](uint32_t child) {
    if (tree_.is_cluster(child)) {
      sum += tree_.facing().part_m2(cluster, child, direction) *
             value[slots_.OfCluster(child, direction)];
    } else {
      const double cosine = tree_.facing().cosine(tree_.node(child).id.surface, direction);
      sum += (tree_.area_m2(child) * cosine) * Upward<V>(child);
    }
  });
  return sum * inverse_area_[slots_.OfCluster(cluster, direction)];
}

template <typename V>
void Product::PullOwn(std::span<const V> leaf_values, const V& scale) {
  CHECK_EQ(leaf_values.size(), active_.leaves.size());
  std::vector<V>& value = values<V>().of_slot;
  for (size_t i = 0; i < leaf_values.size(); ++i) {
    value[slots_.OfElement(active_.leaves[i])] = leaf_values[i] * scale;
  }
  for (size_t k = steps_.size(); k-- > 0;) {
    const Step& step = steps_[k];
    const auto upward = [&](uint32_t i) {
      return value[step.child + i] * inheritance_[step.child + i] * step.area_m2[i];
    };
    value[step.slot] = (upward(0) + upward(1)) * inverse_area_[step.slot];
  }
  for (size_t k = own_clusters_.size(); k-- > 0;) Pull<V>(own_clusters_[k]);
}

// From the children that have their values.
template <typename V>
void Product::Pull(uint32_t node) {
  std::vector<V>& value = std::get<Values<V>>(values_).of_slot;
  if (tree_.is_cluster(node)) {
    for (int d = 0; d < kDirections; ++d) {
      if ((active_.directions[node] >> d & 1) == 0) continue;
      value[slots_.OfCluster(node, d)] = PullCluster<V>(node, d);
    }
    return;
  }
  V sum{};
  tree_.ForEachChild(node, [&](uint32_t child) { sum += Upward<V>(child) * tree_.area_m2(child); });
  const uint32_t slot = slots_.OfElement(node);
  value[slot] = sum * inverse_area_[slot];
}

template <typename V>
Status Product::SendOwnValues() {
  const std::vector<V>& value = values<V>().of_slot;
  std::vector<double> cut, exported;
  for (uint32_t c = 0; c < placement_.cut_size(); ++c) {
    if (placement_.assignment().home[c] != placement_.self()) continue;
    const uint32_t node = placement_.cut_node(c);
    // The values of clusters are wanted by direction: they travel as proxies.
    V upward{};
    if (!tree_.is_cluster(node)) {
      const uint32_t slot = slots_.OfElement(node);
      upward = value[slot] * inheritance_[slot];
    }
    for (int lane = 0; lane < kChannelsOf<V>; ++lane) cut.push_back(upward[lane]);
  }
  exported.reserve(active_.exported.size() * kChannelsOf<V>);
  for (const uint32_t slot : active_.exported) {
    for (int lane = 0; lane < kChannelsOf<V>; ++lane) exported.push_back(value[slot][lane]);
  }
  return exchange_.SendValues(cut, exported);
}

template <typename V>
Status Product::ReceiveOtherValues() {
  constexpr size_t kLanes = kChannelsOf<V>;
  const double start = Now();
  ASSIGN_OR_RETURN(const ReceivedValues received, exchange_.ReceiveValues());
  wait_s_ += Now() - start;
  if (received.cut.size() != placement_.cut_size() * kLanes ||
      received.proxies.size() != active_.proxies.size() * kLanes) {
    return {StatusCode::kInternal, "values of a product have the wrong length"};
  }
  std::vector<V>& value = values<V>().of_slot;
  for (size_t i = 0; i < active_.proxies.size(); ++i) {
    for (size_t lane = 0; lane < kLanes; ++lane) {
      value[active_.proxies[i]][lane] = received.proxies[i * kLanes + lane];
    }
  }
  PullCrown<V>(received.cut);
  return {};
}

template <typename V>
void Product::PullCrown(std::span<const double> cut_values) {
  constexpr size_t kLanes = kChannelsOf<V>;
  std::vector<V>& upward = values<V>().cut_upward;
  for (size_t c = 0; c < upward.size(); ++c) {
    for (size_t lane = 0; lane < kLanes; ++lane) upward[c][lane] = cut_values[c * kLanes + lane];
  }
  const auto& crown = placement_.crown();
  for (size_t k = crown.size(); k-- > 0;) Pull<V>(crown[k]);
}

template <typename Int>
void Product::Clear() {
  for (auto& thread : totals<Int>().by_thread) std::fill(thread.begin(), thread.end(), Int{});
}

template <typename Int>
void Product::CollectThreads() {
  auto& sum = totals<Int>().by_thread;
  if (sum.size() == 1) return;
  pool_.For(sum[0].size(), 8192, [&](size_t begin, size_t end, int) {
    for (size_t t = 1; t < sum.size(); ++t) {
      for (size_t i = begin; i < end; ++i) sum[0][i] += sum[t][i];
    }
  });
}

template <typename Int>
Status Product::ExchangeSums(int lanes) {
  std::vector<Int>& sum = totals<Int>().by_thread[0];
  std::vector<uint32_t> crown;  // slots
  for (const uint32_t node : placement_.crown()) {
    if (!tree_.is_cluster(node)) {
      crown.push_back(slots_.OfElement(node));
      continue;
    }
    for (int d = 0; d < kDirections; ++d) crown.push_back(slots_.OfCluster(node, d));
  }
  const auto pack = [&](const std::vector<uint32_t>& slots) {
    std::vector<int64_t> out;
    out.reserve(slots.size() * lanes);
    for (const uint32_t slot : slots) {
      for (int lane = 0; lane < lanes; ++lane) out.push_back(sum[slot][lane]);
    }
    return out;
  };
  RETURN_IF_ERROR(exchange_.SendSums(pack(crown), pack(active_.proxies)));
  const double start = Now();
  ASSIGN_OR_RETURN(const ReceivedSums received, exchange_.ReceiveSums());
  wait_s_ += Now() - start;
  const bool alone = received.exported.empty() && active_.exported.empty();
  if (received.crown.size() != crown.size() * lanes ||
      (!alone && received.exported.size() != active_.exported.size() * lanes)) {
    return {StatusCode::kInternal, "sums of a product have the wrong length"};
  }
  for (size_t i = 0; i < crown.size(); ++i) {
    for (int lane = 0; lane < lanes; ++lane) sum[crown[i]][lane] = received.crown[i * lanes + lane];
  }
  for (size_t i = 0; i < active_.exported.size(); ++i) {
    for (int lane = 0; lane < lanes; ++lane) {
      sum[active_.exported[i]][lane] += received.exported[i * lanes + lane];
    }
  }
  return {};
}

// A cluster's clusters take over what it received where they stand for the same; its surfaces take
// it in proportion to the cosine of the direction. Rounded here, once for each surface, from the
// sum over all links.
template <typename Int>
void Product::PushCluster(uint32_t cluster) {
  Totals<Int>& totals = this->totals<Int>();
  std::vector<Int>& sum = totals.by_thread[0];
  const ClusterFacing& facing = tree_.facing();
  for (int d = 0; d < kDirections; ++d) {
    const Int whole = sum[slots_.OfCluster(cluster, d)];
    int64_t any = 0;
    for (int lane = 0; lane < kLanesOf<Int>; ++lane) any |= whole[lane];
    if (any == 0) continue;
    tree_.ForEachChild(cluster, [&](uint32_t child) {
      if (tree_.is_cluster(child)) {
        if (facing.part_m2(cluster, child, d) > 0) sum[slots_.OfCluster(child, d)] += whole;
        return;
      }
      const double cosine = facing.cosine(tree_.node(child).id.surface, d);
      totals.from_above[slots_.OfElement(child)] += Truncated(cosine * ToReal(whole));
    });
  }
}

template <typename Int>
void Product::PushDown(std::array<Inherit, kLanesOf<Int>> inherit) {
  Totals<Int>& totals = this->totals<Int>();
  const std::vector<Int>& sum = totals.by_thread[0];
  std::vector<Int>& from_above = totals.from_above;
  Int half{};  // lanes of which elements hand down half
  for (int lane = 0; lane < kLanesOf<Int>; ++lane)
    half[lane] = inherit[lane] == Inherit::kHalf ? -1 : 0;
  const auto handed_down = [&](uint32_t slot) -> Int {
    const Int whole = sum[slot] + from_above[slot];
    return (half & (whole >> 1)) | (~half & whole);
  };
  // Surfaces get something of every direction of a cluster, all below them something once.
  std::fill_n(from_above.begin() + slots_.OfElement(tree_.SurfaceIndex(0)),
              tree_.hierarchy().surfaces().size(), Int{});
  for (const uint32_t node : placement_.crown()) {
    if (tree_.is_cluster(node)) {
      PushCluster<Int>(node);
      continue;
    }
    const Int down = handed_down(slots_.OfElement(node));
    tree_.ForEachChild(node, [&](uint32_t child) { from_above[slots_.OfElement(child)] = down; });
  }
  for (const uint32_t cluster : own_clusters_) PushCluster<Int>(cluster);
  for (const Step& step : steps_) {
    const Int down = handed_down(step.slot);
    from_above[step.child] = down;
    from_above[step.child + 1] = down;
  }
}

// What Sums asks for.
template Product::Values<Single>& Product::values();
template void Product::PullOwn(std::span<const Single>, const Single&);
template Status Product::SendOwnValues<Single>();
// What Behind asks for besides.
template Product::Values<Lanes>& Product::values();
template void Product::PullOwn(std::span<const Lanes>, const Lanes&);
template Status Product::SendOwnValues<Lanes>();
template Status Product::ReceiveOtherValues<Single>();
template Product::Totals<IntSingle>& Product::totals();
template Product::Totals<IntLanes>& Product::totals();
template void Product::Clear<IntSingle>();
template void Product::Clear<IntLanes>();
template void Product::CollectThreads<IntSingle>();
template void Product::CollectThreads<IntLanes>();
template Status Product::ExchangeSums<IntSingle>(int);
template Status Product::ExchangeSums<IntLanes>(int);
template void Product::PushDown<IntSingle>(std::array<Inherit, 1>);
template void Product::PushDown<IntLanes>(std::array<Inherit, 4>);

uint64_t Product::memory_bytes() const {
  const auto& singles = std::get<Values<Single>>(values_).of_slot;
  const auto& lanes = std::get<Values<Lanes>>(values_).of_slot;
  uint64_t bytes = crown_.size() * sizeof(Link) + ends_.size() * sizeof(Slots::Ends) +
                   factors_.size() * sizeof(Factors) + transmissions_.size() * sizeof(Lanes) +
                   glazed_.size() * sizeof(Glazed) + inverse_area_.size() * sizeof(double) +
                   steps_.size() * sizeof(Step) + singles.size() * sizeof(Single) +
                   lanes.size() * sizeof(Lanes);
  for (const auto& t : std::get<Totals<IntSingle>>(totals_).by_thread)
    bytes += t.size() * sizeof(IntSingle);
  for (const auto& t : std::get<Totals<IntLanes>>(totals_).by_thread)
    bytes += t.size() * sizeof(IntLanes);
  return bytes;
}

}  // namespace isolux
