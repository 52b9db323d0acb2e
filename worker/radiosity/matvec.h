// The product at the heart of every solver: values of leaves are pulled up the tree, cross the
// links, and what arrives is pushed down to the leaves.
//
// Sums at nodes are 64-bit integers in units of a power of two, so they do not depend on the order
// in which links, threads and workers add to them. Doubles are summed only along the tree, in its
// order.
//
// Values are of one channel (Single) or of three (Lanes): a product of one keeps, exchanges and
// multiplies one number a node, and its bits are those of a lane of the product of three.
#pragma once

#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "common/util/parallel.h"
#include "worker/radiosity/channels.h"
#include "worker/radiosity/exchange.h"
#include "worker/radiosity/link.h"
#include "worker/radiosity/placement.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/slots.h"
#include "worker/radiosity/subscribe.h"
#include "worker/radiosity/transmission.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Which links a product goes over.
enum class LinkScope {
  kAll,
  kNotLocal,  // without those whose ends are both at or below own cut nodes
};

class Product {
 public:
  // Puts the links between own nodes first.
  Product(const Tree& tree, const Placement& placement, LinkSet& links, const ActiveNodes& active,
          ThreadPool& pool, Exchange& exchange);

  size_t leaf_count() const { return active_.leaves.size(); }
  const Tree& tree() const { return tree_; }
  const ActiveNodes& active() const { return active_; }
  std::span<const Link> local_links() const { return local_; }  // between own nodes

  // Irradiance (W/m²) at own leaves from the radiosity of all leaves, of which `radiosity` are our
  // own; `bound` is, of each channel, not less than any |radiosity| at any worker, and the same at
  // all of them: it sets the channel's unit, so that channels do not depend on each other.
  // `inherited` gets, where it is not empty, what the nodes above each leaf hand down to it, before
  // its factor. The fourth of Lanes is not exchanged and must be 0.
  Status Irradiance(std::span<const Lanes> radiosity, const Lanes& bound,
                    std::span<Lanes> irradiance, LinkScope scope = LinkScope::kAll,
                    std::span<Lanes> inherited = {}) {
    return IrradianceOf<Lanes>(radiosity, bound, irradiance, scope, inherited);
  }
  Status Irradiance(std::span<const Single> radiosity, const Single& bound,
                    std::span<Single> irradiance, LinkScope scope = LinkScope::kAll,
                    std::span<Single> inherited = {}) {
    return IrradianceOf<Single>(radiosity, bound, irradiance, scope, inherited);
  }

  // What own leaves take of all that arrives at the nodes above them, and, in equal measure, give
  // to these nodes' radiosity: factors, 1 at first. See closure.h.
  Status SetInheritance(std::span<const double> of_leaves);

  // Of each own leaf, what the same piece on the other side of a sheet (ActiveNodes::behind) has of
  // these values of leaves; 0 where there is none. One exchange of values, none of sums.
  template <typename V>
  Status Behind(std::span<const V> leaf_values, std::span<V> behind);

  // From now on with what the medium leaves of each link's light; null: without it again. And
  // with what the panes of `glazed` leave.
  void SetMedium(const Medium* medium);
  void SetPanes(const RefineScene* glazed);

  // The same road with another kernel and integer results. kernel(link, ends, xp, xq, to_p, to_q)
  // gives what a link adds to its two ends, from the values at them: numbers below 2^51 in size,
  // rounded to integers, one or four a node. ends: slots. An element hands down all it received, or
  // half of it a level; a cluster hands to each surface in proportion to the cosine.
  enum class Inherit { kWhole, kHalf };
  template <typename Int, typename Function>
  Status Sums(std::span<const Single> values, std::array<Inherit, kLanesOf<Int>> inherit,
              const Function& kernel, std::span<Int> sums);

  // 1 over the area of an element, or over that of a cluster that faces the slot's direction, 1/m².
  double inverse_area(uint32_t slot) const { return inverse_area_[slot]; }

  uint32_t products() const { return products_; }
  double wait_s() const { return wait_s_; }  // wall time spent waiting for others
  uint64_t memory_bytes() const;

 private:
  // Shares of a link's coupling: of what q radiates as irradiance at p, and the reverse.
  struct Factors {
    double to_p, to_q;
  };
  // An own element that is no leaf, and its two children, whose slots follow each other.
  struct Step {
    uint32_t slot = 0, child = 0;  // the first child's
    std::array<double, 2> area_m2{};
  };
  template <typename V>
  struct Values {
    std::vector<V> of_slot;
    std::vector<V> cut_upward;  // what the cut's nodes give to those above
  };
  template <typename Int>
  struct Totals {
    std::vector<std::vector<Int>> by_thread;  // then by slot
    std::vector<Int> from_above;              // by slot: what the element's parent hands down
  };
  // Made when first asked for.
  template <typename V>
  Values<V>& values();
  template <typename Int>
  Totals<Int>& totals();

  template <typename V>
  Status IrradianceOf(std::span<const V> radiosity, const V& bound, std::span<V> irradiance,
                      LinkScope scope, std::span<V> inherited);
  // apply(first, last, sums): adds what the links first … last − 1 bring, in the order of ends_.
  // lanes: of the sums that are exchanged. What came to leaves: see ArrivedAt.
  template <typename V, typename Int, typename Apply>
  Status Transport(std::span<const V> values, const V& scale, int lanes,
                   std::array<Inherit, kLanesOf<Int>> inherit, const Apply& apply, LinkScope scope);
  template <typename V>
  void AddLinks(size_t first, size_t last, const V* value, MaskOf<V>* sum) const;
  void AddLinksByChannel(size_t first, size_t last, const Lanes* value, IntLanes* sum) const;
  const Link& LinkAt(size_t place) const;
  const std::vector<Factors>& factors();
  void MakeTransmissions(const Medium& medium);
  void FindGlazed(const RefineScene& scene);
  void AddGlazed(size_t first, size_t last, const Lanes* value, IntLanes* sum) const;

  template <typename V>
  void Pull(uint32_t node);
  void ListSteps();
  template <typename V>
  V PullCluster(uint32_t cluster, int direction) const;
  template <typename V>
  V Upward(uint32_t child) const;
  template <typename V>
  void PullOwn(std::span<const V> leaf_values, const V& scale);
  template <typename V>
  void PullCrown(std::span<const double> cut_values);
  template <typename V>
  Status SendOwnValues();
  template <typename V>
  Status ReceiveOtherValues();
  template <typename Int>
  void Clear();
  template <typename Int>
  void CollectThreads();
  template <typename Int>
  Status ExchangeSums(int lanes);
  template <typename Int>
  void PushCluster(uint32_t cluster);
  template <typename Int>
  void PushDown(std::array<Inherit, kLanesOf<Int>> inherit);
  // Own leaf: by its links, and of what the nodes above hand down its share.
  template <typename Int>
  Int ArrivedAt(size_t leaf) const;

  const Tree& tree_;
  const Placement& placement_;
  const ActiveNodes& active_;
  ThreadPool& pool_;
  Exchange& exchange_;
  std::span<const Link> local_, remote_;  // links between own nodes; links that wait for values
  std::vector<Link> crown_;               // those of the crown that are counted here
  Slots slots_;
  std::vector<Slots::Ends> ends_;  // slots of local_, then remote_, then crown_
  std::vector<Factors> factors_;   // beside ends_; made by the first product of irradiances
  // Of a medium, beside ends_, by channel: made when one is first set.
  std::vector<Lanes> transmissions_;
  enum class Absorption { kNone, kGrey, kByChannel } absorption_ = Absorption::kNone;
  // Links that panes stand between, in order; where some pane has a colour they are added beside
  // the others, in whose list their factors are 0.
  struct Glazed {
    size_t link;
    Lanes left;
  };
  std::vector<Glazed> glazed_;
  bool looked_for_panes_ = false;
  enum class Glass { kNone, kGrey, kByChannel } glass_ = Glass::kNone;
  std::vector<double> inverse_area_;    // 1/m², by slot
  std::vector<uint32_t> own_clusters_;  // in the tree, parents before children
  std::vector<Step> steps_;             // parents before children, in the order of slots
  std::vector<double> inheritance_;     // by slot; 1 but for own leaves
  double gain_ = 1;  // no node's value is more than this times the largest of a leaf
  std::tuple<Values<Single>, Values<Lanes>> values_;
  std::tuple<Totals<IntSingle>, Totals<IntLanes>> totals_;
  uint32_t products_ = 0;
  double wait_s_ = 0;
};

// ---- bodies ------------------------------------------------------------------------------------

inline const Link& Product::LinkAt(size_t place) const {
  if (place < local_.size()) return local_[place];
  place -= local_.size();
  return place < remote_.size() ? remote_[place] : crown_[place - remote_.size()];
}

template <typename V, typename Int, typename Apply>
Status Product::Transport(std::span<const V> values, const V& scale, int lanes,
                          std::array<Inherit, kLanesOf<Int>> inherit, const Apply& apply,
                          LinkScope scope) {
  ++products_;
  Clear<Int>();
  PullOwn<V>(values, scale);
  RETURN_IF_ERROR(SendOwnValues<V>());
  const auto over = [&](size_t first, size_t last) {
    pool_.For(last - first, 8192, [&](size_t begin, size_t end, int thread) {
      apply(first + begin, first + end, totals<Int>().by_thread[thread].data());
    });
  };
  // While the others' values travel.
  if (scope == LinkScope::kAll) over(0, local_.size());
  RETURN_IF_ERROR(ReceiveOtherValues<V>());
  over(local_.size(), ends_.size());
  CollectThreads<Int>();
  RETURN_IF_ERROR(ExchangeSums<Int>(lanes));
  PushDown<Int>(inherit);
  return {};
}

template <typename Int>
Int Product::ArrivedAt(size_t leaf) const {
  const auto& totals = std::get<Totals<Int>>(totals_);
  const uint32_t slot = slots_.OfElement(active_.leaves[leaf]);
  return totals.by_thread[0][slot] +
         Truncated(inheritance_[slot] * ToReal(totals.from_above[slot]));
}

template <typename Int, typename Function>
Status Product::Sums(std::span<const Single> values, std::array<Inherit, kLanesOf<Int>> inherit,
                     const Function& kernel, std::span<Int> sums) {
  const auto apply = [&](size_t first, size_t last, Int* sum) {
    const std::vector<Single>& value = this->values<Single>().of_slot;
    for (size_t i = first; i < last; ++i) {
      const Slots::Ends& e = ends_[i];
      RealOf<Int> to_p, to_q;
      kernel(LinkAt(i), e, value[e.p][0], value[e.q][0], to_p, to_q);
      sum[e.p] += ToInteger(to_p);
      sum[e.q] += ToInteger(to_q);
    }
  };
  RETURN_IF_ERROR(
      (Transport<Single, Int>(values, Single{1}, kLanesOf<Int>, inherit, apply, LinkScope::kAll)));
  for (size_t i = 0; i < sums.size(); ++i) sums[i] = ArrivedAt<Int>(i);
  return {};
}

}  // namespace isolux
