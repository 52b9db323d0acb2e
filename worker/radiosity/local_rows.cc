#include "worker/radiosity/local_rows.h"

#include "common/util/check.h"

namespace isolux {

namespace {

// Part of what a link's end sends and receives.
struct Share {
  uint32_t node = 0;
  double of_coupling = 0;
  bool inherited = false;  // by a surface from its cluster
};

// An element is its own whole; a cluster is taken apart into its surfaces, as they face the slot's
// direction.
void AddShares(const Tree& tree, uint32_t node, int direction, double inverse_area,
               std::vector<Share>& shares) {
  tree.ForEachChild(node, [&](uint32_t child) {
    if (tree.is_cluster(child)) {
      if (tree.facing().part_m2(node, child, direction) > 0)
        AddShares(tree, child, direction, inverse_area, shares);
      return;
    }
    const double cosine = tree.facing().cosine(tree.node(child).id.surface, direction);
    if (cosine > 0) shares.push_back({child, tree.area_m2(child) * cosine * inverse_area, true});
  });
}

std::vector<Share> SharesOf(const Tree& tree, const Slots& slots, uint32_t slot) {
  const uint32_t node = slots.NodeOf(slot);
  if (!slots.is_cluster(slot)) return {{node, 1.0}};
  std::vector<Share> shares;
  const int direction = slots.DirectionOf(slot);
  const double area = tree.facing().area_m2(node, direction);
  if (area > 0) AddShares(tree, node, direction, 1 / area, shares);
  return shares;
}

}  // namespace

template <typename V>
LocalRowsOf<V>::LocalRowsOf(const Tree& tree, const ActiveNodes& active,
                            std::span<const Link> links, std::span<const double> inheritance) {
  std::vector<uint32_t> row_of(tree.size(), kNone);
  for (size_t k = 0; k < active.own.size(); ++k) {
    const uint32_t node = active.own[k];
    if (tree.is_cluster(node)) continue;
    Row row;
    row_of[node] = static_cast<uint32_t>(rows_.size());
    const uint32_t parent = tree.node(node).parent;
    row.parent = parent == kNoNode ? kNone : row_of[parent];
    row.area_m2 = tree.area_m2(node);
    row.inverse_area = row.area_m2 > 0 ? 1 / row.area_m2 : 0;
    row.is_leaf = active.is_leaf[k] != 0;
    row.first_leaf = static_cast<uint32_t>(row_of_leaf_.size());
    row.last_leaf = row.first_leaf + (row.is_leaf ? 1 : 0);
    if (row.is_leaf) {
      row.inheritance = inheritance[row.first_leaf];
      row_of_leaf_.push_back(row_of[node]);
    }
    rows_.push_back(row);
  }
  const size_t n = rows_.size();
  rows_.emplace_back();
  for (uint32_t k = static_cast<uint32_t>(n); k-- > 0;) {
    if (rows_[k].parent == kNone) continue;
    Row& parent = rows_[rows_[k].parent];
    parent.last_leaf = std::max(parent.last_leaf, rows_[k].last_leaf);
  }
  // Both ends of a coupling list it.
  const Slots slots(tree);
  const auto for_couplings = [&](const auto& body) {
    for (const Link& link : links) {
      const Slots::Ends ends = slots.Of(tree, link);
      const std::vector<Share> at_q = SharesOf(tree, slots, ends.q);
      for (const Share& p : SharesOf(tree, slots, ends.p)) {
        for (const Share& q : at_q) {
          const uint32_t a = row_of[p.node], b = row_of[q.node];
          CHECK(a != kNone && b != kNone);
          // Surfaces that are leaves take and give what their factor says; below others, the rows
          // do.
          const double taken = (p.inherited ? rows_[a].inheritance : 1.0) *
                               (q.inherited ? rows_[b].inheritance : 1.0);
          body(a, b, link.coupling_m2() * p.of_coupling * q.of_coupling * taken);
        }
      }
    }
  };
  for_couplings([&](uint32_t a, uint32_t b, double) {
    ++rows_[a + 1].first_coupling;
    ++rows_[b + 1].first_coupling;
  });
  for (size_t k = 0; k < n; ++k) rows_[k + 1].first_coupling += rows_[k].first_coupling;
  couplings_.resize(rows_[n].first_coupling);
  std::vector<uint32_t> next(n);
  for (size_t k = 0; k < n; ++k) next[k] = rows_[k].first_coupling;
  for_couplings([&](uint32_t a, uint32_t b, double coupling_m2) {
    couplings_[next[a]++] = {b, coupling_m2};
    couplings_[next[b]++] = {a, coupling_m2};
  });
  value_.resize(n);
  arriving_.resize(n);
  sum_.resize(n);
}

template <typename V>
void LocalRowsOf<V>::Sweep(std::span<V> values, const Update& update) {
  const size_t n = value_.size();
  std::fill(sum_.begin(), sum_.end(), V{});
  for (size_t k = n; k-- > 0;) {
    const Row& row = rows_[k];
    value_[k] = row.is_leaf ? values[row.first_leaf] : sum_[k] * row.inverse_area;
    if (row.parent != kNone) sum_[row.parent] += value_[k] * (row.area_m2 * row.inheritance);
  }
  std::fill(sum_.begin(), sum_.end(), V{});
  // A node's value is brought up to date once all below it are through.
  std::vector<uint32_t> open;
  const auto close = [&] {
    const uint32_t k = open.back();
    open.pop_back();
    if (!rows_[k].is_leaf) value_[k] = sum_[k] * rows_[k].inverse_area;
    if (rows_[k].parent != kNone) {
      sum_[rows_[k].parent] += value_[k] * (rows_[k].area_m2 * rows_[k].inheritance);
    }
  };
  for (uint32_t k = 0; k < n; ++k) {
    const Row& row = rows_[k];
    while (!open.empty() && open.back() != row.parent) close();
    V arriving = row.parent == kNone ? V{} : arriving_[row.parent] * row.inheritance;
    for (const Coupling& c : CouplingsOf(k)) {
      arriving += value_[c.other] * (c.coupling_m2 * row.inverse_area);
    }
    arriving_[k] = arriving;
    if (row.is_leaf) values[row.first_leaf] = value_[k] = update(row.first_leaf, arriving);
    open.push_back(k);
  }
  while (!open.empty()) close();
}

template <typename V>
void LocalRowsOf<V>::Shoot(size_t leaf, const V& value, const Add& add) const {
  const Row& from = rows_[row_of_leaf_[leaf]];
  for (uint32_t k = row_of_leaf_[leaf]; k != kNone; k = rows_[k].parent) {
    const double share = rows_[k].is_leaf ? 1 : from.inheritance;
    const V mean = value * (share * from.area_m2 * rows_[k].inverse_area);
    for (const Coupling& c : CouplingsOf(k)) {
      const Row& other = rows_[c.other];
      const V arriving = mean * (c.coupling_m2 * other.inverse_area);
      if (other.is_leaf) {
        add(other.first_leaf, arriving);
        continue;
      }
      for (size_t i = other.first_leaf; i < other.last_leaf; ++i) {
        add(i, arriving * rows_[row_of_leaf_[i]].inheritance);
      }
    }
  }
}

template class LocalRowsOf<Single>;
template class LocalRowsOf<Lanes>;

}  // namespace isolux
