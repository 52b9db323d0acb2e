#include "worker/radiosity/closure.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

constexpr uint32_t kMostProducts = 20, kMostInheritedProducts = 12;
// Of a factor. Above the most, a link is missing; the least only guards against nonsense.
constexpr double kLeast = 1e-3, kMost = 2.0;
// Of one step: larger ones overshoot where neighbours are scaled too.
constexpr double kSmallestStep = 0.5, kLargestStep = 1.25;
// Of what is inherited. A leaf in a corner that its parent's links know nothing of may inherit next
// to nothing.
constexpr double kLeastInherited = 1.0 / 64, kMostInherited = 8;
// The factors of what is inherited need no more than this: the others do the rest.
constexpr double kInheritanceTolerance = 0.01;

class Closer {
 public:
  Closer(Product& product, LeafSystem& leaves, std::span<const RowBounds> bounds,
         Exchange& exchange)
      : product_(product),
        leaves_(leaves),
        bounds_(bounds),
        exchange_(exchange),
        radiosity_(leaves.size()),
        row_(leaves.size()),
        inherited_(leaves.size()),
        off_(leaves.size(), 0) {}

  // Rows with the factors of now, and how far the worst of all workers is from its bounds.
  Result<double> Measure() {
    RETURN_IF_ERROR(product_.SetInheritance(leaves_.inheritance));
    for (size_t i = 0; i < leaves_.size(); ++i) radiosity_[i] = Single{leaves_.closure[i]};
    RETURN_IF_ERROR(product_.Irradiance(radiosity_, kMost, row_, LinkScope::kAll, inherited_));
    ++products_;
    Reduction reduction;
    reduction.maxima = {0};
    for (size_t i = 0; i < leaves_.size(); ++i) {
      const double row = Row(i);
      if (!(row > 0)) continue;
      const double target = Target(i, row);
      off_[i] = std::abs(row - target) / std::max(target, kLeast);
      reduction.maxima[0] = std::max(reduction.maxima[0], off_[i]);
    }
    ASSIGN_OR_RETURN(const Reduction total, exchange_.Reduce(std::move(reduction)));
    return total.maxima[0];
  }

  // Leaves that can be closed by what they inherit are, others by all their links.
  void ScaleInheritance() {
    for (size_t i = 0; i < leaves_.size(); ++i) {
      if (!ScaleInherited(i)) ScaleAll(i);
    }
  }

  void ScaleAll() {
    for (size_t i = 0; i < leaves_.size(); ++i) ScaleAll(i);
  }

  uint32_t products() const { return products_; }
  const std::vector<double>& off() const { return off_; }

 private:
  // False where the factor is at one of its ends.
  bool ScaleInherited(size_t i) {
    const double row = Row(i);
    double& factor = leaves_.inheritance[i];
    const double from_above = leaves_.closure[i] * factor * inherited_[i][0];
    if (!(from_above > 0)) return false;
    // What should come from above, over what does; half of it by taking, half by giving.
    const double wanted = Target(i, row) - (row - from_above);
    const double step = std::sqrt(std::max(wanted, 0.0) / from_above);
    const double next = factor * std::clamp(step, kSmallestStep, kLargestStep);
    factor = std::clamp(next, kLeastInherited, kMostInherited);
    return factor == next;
  }

  void ScaleAll(size_t i) {
    const double row = Row(i);
    if (!(row > 0)) return;
    const double step = std::sqrt(Target(i, row) / row);
    leaves_.closure[i] = std::clamp(
        leaves_.closure[i] * std::clamp(step, kSmallestStep, kLargestStep), kLeast, kMost);
  }

  double Row(size_t i) const { return leaves_.closure[i] * row_[i][0]; }
  double Target(size_t i, double row) const {
    return std::clamp(row, bounds_[i].low, std::max(bounds_[i].low, bounds_[i].high));
  }

  Product& product_;
  LeafSystem& leaves_;
  std::span<const RowBounds> bounds_;
  Exchange& exchange_;
  std::vector<Single> radiosity_, row_, inherited_;
  std::vector<double> off_;
  uint32_t products_ = 0;
};

}  // namespace

Result<ClosureSummary> Close(Product& product, LeafSystem& leaves,
                             std::span<const RowBounds> bounds, double tolerance,
                             Exchange& exchange) {
  Closer closer(product, leaves, bounds, exchange);
  ClosureSummary summary;
  while (true) {
    ASSIGN_OR_RETURN(summary.worst_after, closer.Measure());
    summary.products = closer.products();
    if (summary.products == 1) summary.worst_before = summary.worst_after;
    if (summary.worst_after <= tolerance || summary.products >= kMostProducts) {
      summary.off = closer.off();
      return summary;
    }
    if (summary.products < kMostInheritedProducts && summary.worst_after > kInheritanceTolerance) {
      closer.ScaleInheritance();
    } else {
      closer.ScaleAll();
    }
  }
}

}  // namespace isolux
