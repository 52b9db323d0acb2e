#include "worker/radiosity/local_rows.h"

#include "common/util/check.h"

namespace isolux {

LocalRows::LocalRows(const Tree& tree, const ActiveNodes& active, std::span<const Link> links) {
  const size_t n = active.own.size();
  std::vector<uint32_t> row_of(tree.size(), kNone);
  rows_.resize(n + 1);
  for (uint32_t k = 0; k < n; ++k) {
    const uint32_t node = active.own[k];
    Row& row = rows_[k];
    row_of[node] = k;
    const uint32_t parent = tree.node(node).parent;
    row.parent = parent == kNoNode ? kNone : row_of[parent];
    row.area_m2 = tree.area_m2(node);
    row.inverse_area = row.area_m2 > 0 ? 1 / row.area_m2 : 0;
    row.is_leaf = active.is_leaf[k] != 0;
    row.first_leaf = static_cast<uint32_t>(row_of_leaf_.size());
    row.last_leaf = row.first_leaf + (row.is_leaf ? 1 : 0);
    if (row.is_leaf) row_of_leaf_.push_back(k);
  }
  for (uint32_t k = static_cast<uint32_t>(n); k-- > 0;) {
    if (rows_[k].parent == kNone) continue;
    Row& parent = rows_[rows_[k].parent];
    parent.last_leaf = std::max(parent.last_leaf, rows_[k].last_leaf);
  }
  // Both ends of a link list it; a link of a node with itself stands twice in its row, as it counts
  // twice in a product.
  for (const Link& link : links) {
    ++rows_[row_of[link.p] + 1].first_coupling;
    ++rows_[row_of[link.q] + 1].first_coupling;
  }
  for (size_t k = 0; k < n; ++k) rows_[k + 1].first_coupling += rows_[k].first_coupling;
  couplings_.resize(rows_[n].first_coupling);
  std::vector<uint32_t> next(n);
  for (size_t k = 0; k < n; ++k) next[k] = rows_[k].first_coupling;
  for (const Link& link : links) {
    const uint32_t p = row_of[link.p], q = row_of[link.q];
    CHECK(p != kNone && q != kNone);
    couplings_[next[p]++] = {q, link.coupling_m2()};
    couplings_[next[q]++] = {p, link.coupling_m2()};
  }
  value_.resize(n);
  arriving_.resize(n);
  sum_.resize(n);
}

void LocalRows::Sweep(std::span<Lanes> values, const Update& update) {
  const size_t n = value_.size();
  std::fill(sum_.begin(), sum_.end(), Lanes{});
  for (size_t k = n; k-- > 0;) {
    const Row& row = rows_[k];
    value_[k] = row.is_leaf ? values[row.first_leaf] : sum_[k] * row.inverse_area;
    if (row.parent != kNone) sum_[row.parent] += value_[k] * row.area_m2;
  }
  std::fill(sum_.begin(), sum_.end(), Lanes{});
  // A node's value is brought up to date once all below it are through.
  std::vector<uint32_t> open;
  const auto close = [&] {
    const uint32_t k = open.back();
    open.pop_back();
    if (!rows_[k].is_leaf) value_[k] = sum_[k] * rows_[k].inverse_area;
    if (rows_[k].parent != kNone) sum_[rows_[k].parent] += value_[k] * rows_[k].area_m2;
  };
  for (uint32_t k = 0; k < n; ++k) {
    const Row& row = rows_[k];
    while (!open.empty() && open.back() != row.parent) close();
    Lanes arriving = row.parent == kNone ? Lanes{} : arriving_[row.parent];
    for (const Coupling& c : CouplingsOf(k)) {
      arriving += value_[c.other] * (c.coupling_m2 * row.inverse_area);
    }
    arriving_[k] = arriving;
    if (row.is_leaf) values[row.first_leaf] = value_[k] = update(row.first_leaf, arriving);
    open.push_back(k);
  }
  while (!open.empty()) close();
}

void LocalRows::Shoot(size_t leaf, const Lanes& value, const Add& add) const {
  const double area = rows_[row_of_leaf_[leaf]].area_m2;
  for (uint32_t k = row_of_leaf_[leaf]; k != kNone; k = rows_[k].parent) {
    const Lanes mean = value * (area * rows_[k].inverse_area);
    for (const Coupling& c : CouplingsOf(k)) {
      const Row& other = rows_[c.other];
      add(other.first_leaf, other.last_leaf, mean * (c.coupling_m2 * other.inverse_area));
    }
  }
}

}  // namespace isolux
