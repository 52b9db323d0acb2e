// The product at the heart of every solver: values of leaves are pulled up the tree, cross the
// links, and what arrives is pushed down to the leaves.
//
// Sums at nodes are 64-bit integers in units of a power of two, so they do not depend on the order
// in which links, threads and workers add to them. Doubles are summed only along the tree, in its
// order.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/util/parallel.h"
#include "worker/coupling/lanes.h"
#include "worker/radiosity/exchange.h"
#include "worker/radiosity/link.h"
#include "worker/radiosity/placement.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/slots.h"
#include "worker/radiosity/tree.h"

namespace isolux {

using IntLanes = LaneMask;

// The nodes of a worker that take part in the products of one round.
struct ActiveNodes {
  std::vector<uint32_t> own;     // at and below own cut nodes, parents before children
  std::vector<uint32_t> leaves;  // those of `own` that end the tree
  std::vector<uint8_t> is_leaf;  // of `own`
  // Slots (slots.h).
  std::vector<uint32_t> exported;  // own ones others want, in the order of their ids
  std::vector<uint32_t> proxies;   // those wanted from others, home by home, by id
  // Of each cluster, by bits: the directions in which somebody needs its value.
  std::vector<uint16_t> directions;
};

// Tells the other workers which of their nodes the links here end at, makes those of our own that
// they name, and lists the nodes of the round. The leaves are the union of what all blocks ask for.
Result<ActiveNodes> Subscribe(Tree& tree, Placement& placement, const LinkSet& links,
                              Exchange& exchange);

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
  // own; `bound` is not less than any |radiosity| at any worker, and the same at all of them.
  // Lanes beyond `lanes` are not exchanged and must be 0. `inherited` gets, where it is not empty,
  // what the nodes above each leaf hand down to it, before its factor.
  Status Irradiance(std::span<const Lanes> radiosity, double bound, int lanes,
                    std::span<Lanes> irradiance, LinkScope scope = LinkScope::kAll,
                    std::span<Lanes> inherited = {});

  // What own leaves take of all that arrives at the nodes above them, and, in equal measure, give
  // to these nodes' radiosity: factors, 1 at first. See closure.h.
  Status SetInheritance(std::span<const double> of_leaves);

  // The same road with another kernel and integer results. kernel(link, ends, xp, xq, to_p, to_q)
  // gives what a link adds to its two ends, from the values at them: numbers below 2^51 in size,
  // rounded to integers. ends: slots. An element hands down all it received, or half of it a level;
  // a cluster hands to each surface in proportion to the cosine.
  enum class Inherit { kWhole, kHalf };
  template <typename Function>
  Status Sums(std::span<const Lanes> values, int lanes, std::array<Inherit, 4> inherit,
              const Function& kernel, std::span<IntLanes> sums, LinkScope scope = LinkScope::kAll);

  // 1 over the area of an element, or over that of a cluster that faces the slot's direction, 1/m².
  double inverse_area(uint32_t slot) const { return inverse_area_[slot]; }

  uint32_t products() const { return products_; }
  double wait_s() const { return wait_s_; }  // wall time spent waiting for others
  uint64_t memory_bytes() const;

 private:
  template <typename Function>
  void ApplyLinks(std::span<const Link> links, std::span<const Slots::Ends> ends,
                  const Function& kernel);
  void Pull(uint32_t node);
  Lanes PullCluster(uint32_t cluster, int direction) const;
  void PushCluster(uint32_t cluster);
  Lanes Upward(uint32_t child) const;
  IntLanes& Inbox(uint32_t child);
  void PullOwn(std::span<const Lanes> leaf_values);
  void PullCrown(std::span<const double> cut_values, int lanes);
  Status SendOwnValues(int lanes);
  Status ReceiveOtherValues(int lanes);
  Status ExchangeSums(int lanes);
  void PushDown(std::array<Inherit, 4> inherit, std::span<IntLanes> sums);
  void CollectThreads();

  const Tree& tree_;
  const Placement& placement_;
  const ActiveNodes& active_;
  ThreadPool& pool_;
  Exchange& exchange_;
  std::span<const Link> local_, remote_;  // links between own nodes; links that wait for values
  std::vector<Link> crown_;               // those of the crown that are counted here
  Slots slots_;
  std::vector<Slots::Ends> ends_, crown_ends_;  // slots of local_ and then remote_, of crown_
  std::vector<double> inverse_area_;            // 1/m², by slot
  std::vector<Lanes> value_;                    // by slot
  std::vector<std::vector<IntLanes>> sum_;      // by thread, then slot
  std::vector<uint32_t> leaf_of_;               // by slot: number of the own leaf, or kNoNode
  std::vector<double> inheritance_;             // by own leaf
  double gain_ = 1;  // no node's value is more than this times the largest of a leaf
  std::vector<IntLanes> from_above_;  // by own leaf
  std::vector<Lanes> cut_upward_;     // what the cut's nodes give to those above
  uint32_t products_ = 0;
  double wait_s_ = 0;
};

// v rounded to an integer, for |v| < 2^51.
inline IntLanes ToInteger(const Lanes& v) {
  constexpr double kMagic = 0x1.8p52;
  return reinterpret_cast<IntLanes>(v + kMagic) - reinterpret_cast<IntLanes>(Splat(kMagic));
}

// ---- bodies ------------------------------------------------------------------------------------

template <typename Function>
void Product::ApplyLinks(std::span<const Link> links, std::span<const Slots::Ends> ends,
                         const Function& kernel) {
  pool_.For(links.size(), 8192, [&](size_t begin, size_t end, int thread) {
    IntLanes* sum = sum_[thread].data();
    for (size_t i = begin; i < end; ++i) {
      const Slots::Ends& e = ends[i];
      Lanes to_p, to_q;
      kernel(links[i], e, value_[e.p], value_[e.q], to_p, to_q);
      sum[e.p] += ToInteger(to_p);
      sum[e.q] += ToInteger(to_q);
    }
  });
}

template <typename Function>
Status Product::Sums(std::span<const Lanes> values, int lanes, std::array<Inherit, 4> inherit,
                     const Function& kernel, std::span<IntLanes> sums, LinkScope scope) {
  ++products_;
  for (auto& thread : sum_) std::fill(thread.begin(), thread.end(), IntLanes{});
  PullOwn(values);
  RETURN_IF_ERROR(SendOwnValues(lanes));
  const std::span<const Slots::Ends> ends = ends_;
  if (scope == LinkScope::kAll) {  // while the others' values travel
    ApplyLinks(local_, ends.first(local_.size()), kernel);
  }
  RETURN_IF_ERROR(ReceiveOtherValues(lanes));
  ApplyLinks(remote_, ends.subspan(local_.size()), kernel);
  ApplyLinks(crown_, crown_ends_, kernel);
  CollectThreads();
  RETURN_IF_ERROR(ExchangeSums(4));
  PushDown(inherit, sums);
  return {};
}

}  // namespace isolux
