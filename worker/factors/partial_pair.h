// The coupling of a pair that is neither proved visible nor proved hidden: integrated over one end
// with exact clipping of the other at each point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/visibility/clipped_factor.h"
#include "worker/visibility/occluder_tree.h"

namespace isolux {

struct PartialResult {
  double coupling_m2 = 0;
  double error_m2 = 0;   // stated; above the tolerance where the work had to end before
  uint32_t points = 0;   // that were clipped
  bool finished = true;  // false: gave up, `most_work` was not enough
  bool divided = false;  // beyond the first quarters
};

// Keeps its memory between pairs: one for each thread.
class PartialPair {
 public:
  explicit PartialPair(const OccluderTree& tree) : tree_(&tree), clipper_(tree.set()) {}

  // The ends are clipped by each other's planes. `candidates`: all occluders in their shaft.
  // `unobstructed_m2`: their coupling without occluders, known well; what is integrated is which
  // share of it is visible. `most_work`: as PointClipper counts it.
  PartialResult Integrate(const ShaftEnd& p, const ShaftEnd& q,
                          std::span<const uint32_t> candidates, double unobstructed_m2,
                          double tolerance_m2, uint64_t most_work);

 private:
  struct Element {
    ConvexPolygon shape;
    uint32_t first = 0, count = 0;  // candidates in lists_; none: settled
    double whole_m2 = 0;            // integrals over the element, unobstructed
    double visible_m2 = 0;          // and of what is seen
    double difference_m2 = 0;       // errors: as the parent's differed from its quarters'
    double unseen_m2 = 0;           // and what nothing has shown
    bool hidden = false;
  };

  void Start(const ShaftEnd& p, const ShaftEnd& q, std::span<const uint32_t> candidates);
  void Measure(Element& element);
  void SplitWorst();
  Element MakeChild(const ConvexPolygon& shape, const Element& parent);
  void AddElement(Element element, double difference_m2);
  void Count(const Element& element, double sign);
  static bool Better(const Element& a, const Element& b);
  double Share() const { return whole_m2_ > 0 ? visible_m2_ / whole_m2_ : 0; }

  const OccluderTree* tree_;
  PointClipper clipper_;
  ShaftEnd outer_, inner_;
  std::vector<Element> heap_;
  std::vector<uint32_t> lists_, found_;
  double whole_m2_ = 0, visible_m2_ = 0, difference_m2_ = 0, unseen2_m4_ = 0;  // of all elements
  double end_m2_ = 0;  // the integral over the whole end, as first measured
  uint32_t points_ = 0;
};

}  // namespace isolux
