// The links between own nodes, leaf by leaf: what Gauss–Seidel sweeps and shots run over. Plain
// doubles on one thread, in the order of the tree: bits depend on which leaves share a worker.
// Clusters' links are taken apart into their surfaces'.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "worker/radiosity/channels.h"
#include "worker/radiosity/matvec.h"

namespace isolux {

template <typename V>
class LocalRowsOf {
 public:
  // inheritance: of own leaves, as LeafSystem has it.
  LocalRowsOf(const Tree& tree, const ActiveNodes& active, std::span<const Link> links,
              std::span<const double> inheritance);

  // Goes through the leaves in order: value[i] = update(i, arriving), where `arriving` is what the
  // links bring to the leaf from the values as they are by then. A node's links are read once, when
  // its first leaf is reached: none of them ends at or below the node, so what they bring is the
  // same for all its leaves, and a sweep costs as much as a product.
  using Update = std::function<V(size_t leaf, const V& arriving)>;
  void Sweep(std::span<V> values, const Update& update);

  // Calls add(leaf, arriving), for all leaves that see it, once or more: what arrives when one leaf
  // alone has a value.
  using Add = std::function<void(size_t leaf, const V& arriving)>;
  void Shoot(size_t leaf, const V& value, const Add& add) const;

 private:
  static constexpr uint32_t kNone = 0xffffffffu;

  struct Row {
    uint32_t parent = kNone;                 // place among the rows; kNone: a surface or cut node
    uint32_t first_leaf = 0, last_leaf = 0;  // of those at or below, end exclusive
    uint32_t first_coupling = 0;             // to the first of the next row
    double area_m2 = 0, inverse_area = 0;    // m², 1/m²
    double inheritance = 1;                  // of a leaf: LeafSystem::inheritance
    bool is_leaf = false;
  };
  struct Coupling {
    uint32_t other = 0;  // place among the rows
    double coupling_m2 = 0;
  };

  std::span<const Coupling> CouplingsOf(uint32_t row) const {
    return std::span(couplings_)
        .subspan(rows_[row].first_coupling,
                 rows_[row + 1].first_coupling - rows_[row].first_coupling);
  }

  std::vector<Row> rows_;  // parents before children, and one more to end the last
  std::vector<Coupling> couplings_;
  std::vector<uint32_t> row_of_leaf_;
  std::vector<V> value_, arriving_, sum_;  // by row
};
using LocalRows = LocalRowsOf<Lanes>;

}  // namespace isolux
