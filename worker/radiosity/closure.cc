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

double SumOf(const Lanes& v) { return v[0] + v[1] + v[2]; }

// How rows of many leaves differ from what rays say of them.
struct RowScatter {
  double mean = 0;  // of all leaves, what rays say less what rows are, as far as it is certain
  double seen = 0;  // the same, certain or not
  double deviation2 = 0;  // of single rows, without what rays scatter

  // A row alone is drawn towards its rays by as much as they are better than it. How much must not
  // depend on what the row is, and the mean of all rows, which is far better than any row, must
  // stay where it is: what many rows lack of the rays counts only beyond two deviations of the
  // latter.
  double Target(double row, double rays, double rays_deviation) const {
    const double trust = deviation2 / (deviation2 + rays_deviation * rays_deviation);
    return std::max(0.0, row + trust * (rays - row - seen) + mean);
  }
};

// Sums over leaves: of A, A (rays − row), A ((rays − row)² − σ²), A² σ².
constexpr size_t kMoments = 4;
RowScatter ScatterOf(std::span<const ExactSum> sums) {
  RowScatter scatter;
  const double area = sums[0].Value();
  if (!(area > 0)) return scatter;
  scatter.seen = sums[1].Value() / area;
  const double seen2 = scatter.seen * scatter.seen;
  scatter.deviation2 = std::max(0.0, sums[2].Value() / area - seen2);
  const double chance2 = 4 * sums[3].Value() / (area * area);
  if (seen2 > chance2) scatter.mean = scatter.seen * (1 - chance2 / seen2);
  return scatter;
}

class Closer {
 public:
  Closer(Product& product, LeafSystem& leaves, std::span<const RowMeasure> measured,
         Exchange& exchange)
      : product_(product),
        leaves_(leaves),
        measured_(measured),
        exchange_(exchange),
        radiosity_(leaves.size()),
        row_(leaves.size()),
        inherited_(leaves.size()),
        target_(leaves.size(), 0),
        off_(leaves.size(), 0),
        misplaced_(leaves.size(), 0),
        black_(leaves.size(), 0) {}

  // Which leaves radiate less than this share of what arrives.
  Status FindBlack(std::span<const Lanes> irradiance, double share) {
    std::vector<Lanes> behind(leaves_.size(), Lanes{});
    const bool sheets = product_.tree().sheets() != nullptr;
    if (sheets) RETURN_IF_ERROR(product_.Behind(irradiance, std::span<Lanes>(behind)));
    for (size_t i = 0; i < leaves_.size(); ++i) {
      const Lanes& h = irradiance[i];
      Lanes radiosity = leaves_.exitance[i] + leaves_.reflectance[i] * h;
      if (sheets) radiosity += leaves_.transmittance[i] * behind[i];
      double sum = SumOf(radiosity);
      if (!leaves_.reradiation.empty()) sum += Sum(leaves_.reradiation[i].Of({h[0], h[1], h[2]}));
      black_[i] = sum < share * SumOf(h) ? 1 : 0;
    }
    return {};
  }

  // Rows with the factors of now.
  Status MakeRows() {
    RETURN_IF_ERROR(product_.SetInheritance(leaves_.inheritance));
    for (size_t i = 0; i < leaves_.size(); ++i) radiosity_[i] = Single{leaves_.closure[i]};
    for (size_t i = 0; i < leaves_.specular.size(); ++i) {
      radiosity_[i] = radiosity_[i] * (1 - leaves_.specular[i]);
    }
    ++products_;
    return product_.Irradiance(radiosity_, Single{kMost}, row_, LinkScope::kAll, inherited_);
  }

  // What rows must become, from what they are.
  Status SetTargets(RowsMay rows_may) {
    Reduction reduction;
    reduction.sums.resize(2 * kMoments);
    for (size_t i = 0; i < leaves_.size(); ++i) {
      const RowMeasure& rays = measured_[i];
      if (!(Row(i) > 0) || rays.deviation == 0 || black_[i] != 0) continue;
      const double area = leaves_.area_m2[i], off = rays.sum - Row(i);
      ExactSum* sums = &reduction.sums[IsLamp(i) ? kMoments : 0];
      sums[0].Add(area);
      sums[1].Add(area * off);
      sums[2].Add(area * (off * off - rays.deviation * rays.deviation));
      sums[3].Add(area * area * rays.deviation * rays.deviation);
    }
    ASSIGN_OR_RETURN(const Reduction total, exchange_.Reduce(std::move(reduction)));
    const std::array<RowScatter, 2> scatter = {ScatterOf(std::span(total.sums).first(kMoments)),
                                               ScatterOf(std::span(total.sums).last(kMoments))};
    for (size_t i = 0; i < leaves_.size(); ++i) {
      const RowMeasure& rays = measured_[i];
      target_[i] = rays.deviation > 0
                       ? scatter[IsLamp(i) ? 1 : 0].Target(Row(i), rays.sum, rays.deviation)
                       : rays.sum;
      if (rows_may == RowsMay::kFall) target_[i] = std::min(target_[i], Row(i));
    }
    return {};
  }

  // How far the worst row of all workers is from its target.
  Result<double> FarthestOff() {
    Reduction reduction;
    reduction.maxima = {0};
    for (size_t i = 0; i < leaves_.size(); ++i) {
      const double row = Row(i);
      if (!(row > 0) || black_[i] != 0) continue;
      off_[i] = std::abs(row - target_[i]) / std::max(target_[i], kLeast);
      reduction.maxima[0] = std::max(reduction.maxima[0], off_[i]);
    }
    ASSIGN_OR_RETURN(const Reduction total, exchange_.Reduce(std::move(reduction)));
    return total.maxima[0];
  }

  // Leaves that can be closed by what they inherit are, others by all their links.
  void ScaleInheritance() {
    for (size_t i = 0; i < leaves_.size(); ++i) {
      if (black_[i] == 0 && !ScaleInherited(i)) ScaleAll(i);
    }
  }

  // What rows must change by, as shares of what they are; 0 of leaves without any link.
  std::vector<double> Bends() const {
    std::vector<double> bends(leaves_.size(), 0);
    for (size_t i = 0; i < bends.size(); ++i)
      if (Row(i) > 0) bends[i] = target_[i] / Row(i) - 1;
    return bends;
  }

  void ScaleAll() {
    for (size_t i = 0; i < leaves_.size(); ++i) {
      if (black_[i] == 0) ScaleAll(i);
    }
  }

  // Rows that are longer than they must be no longer are; others lose by it.
  void BringDown() {
    for (size_t i = 0; i < leaves_.size(); ++i) {
      if (black_[i] == 0 && Row(i) > target_[i]) leaves_.closure[i] *= target_[i] / Row(i);
    }
  }

  // What rows lack comes back, except where leaves are rather lamps.
  void Return(std::span<const Lanes> irradiance) {
    for (size_t i = 0; i < leaves_.size(); ++i) {
      const double passes_on = leaves_.specular.empty() ? 1.0 : 1 - leaves_.specular[i];
      const bool lamp = SumOf(leaves_.exitance[i]) > SumOf(leaves_.reflectance[i] * irradiance[i]);
      leaves_.returned[i] = 0;
      if (lamp || black_[i] != 0 || !(passes_on > 0)) continue;
      leaves_.returned[i] = std::max(0.0, target_[i] - Row(i)) / passes_on;
      std::swap(off_[i], misplaced_[i]);
    }
  }

  uint32_t products() const { return products_; }
  const std::vector<double>& off() const { return off_; }
  const std::vector<double>& misplaced() const { return misplaced_; }

 private:
  // False where the factor is at one of its ends.
  bool ScaleInherited(size_t i) {
    const double row = Row(i);
    double& factor = leaves_.inheritance[i];
    const double from_above = Inherited(i);
    if (!(from_above > 0)) return false;
    // What should come from above, over what does; half of it by taking, half by giving.
    const double wanted = target_[i] - (row - from_above);
    const double step = std::sqrt(std::max(wanted, 0.0) / from_above);
    const double next = factor * std::clamp(step, kSmallestStep, kLargestStep);
    factor = std::clamp(next, kLeastInherited, kMostInherited);
    return factor == next;
  }

  void ScaleAll(size_t i) {
    const double row = Row(i);
    if (!(row > 0)) return;
    const double step = std::sqrt(target_[i] / row);
    leaves_.closure[i] = std::clamp(
        leaves_.closure[i] * std::clamp(step, kSmallestStep, kLargestStep), kLeast, kMost);
  }

  bool IsLamp(size_t i) const { return SumOf(leaves_.exitance[i]) > 0; }

  double Inherited(size_t i) const {
    return leaves_.closure[i] * leaves_.inheritance[i] * inherited_[i][0];
  }
  double Row(size_t i) const { return leaves_.closure[i] * row_[i][0]; }

  Product& product_;
  LeafSystem& leaves_;
  std::span<const RowMeasure> measured_;
  Exchange& exchange_;
  std::vector<Single> radiosity_, row_, inherited_;
  std::vector<double> target_, off_, misplaced_;
  std::vector<char> black_;
  uint32_t products_ = 0;
};

}  // namespace

Result<ClosureSummary> Close(Product& product, LeafSystem& leaves,
                             std::span<const Lanes> irradiance,
                             std::span<const RowMeasure> measured, RowsMay rows_may,
                             const ClosureTolerance& tolerance, Exchange& exchange) {
  Closer closer(product, leaves, measured, exchange);
  RETURN_IF_ERROR(closer.FindBlack(irradiance, tolerance.black));
  ClosureSummary summary;
  while (true) {
    RETURN_IF_ERROR(closer.MakeRows());
    summary.products = closer.products();
    const bool first = summary.products == 1;
    if (first) RETURN_IF_ERROR(closer.SetTargets(rows_may));
    ASSIGN_OR_RETURN(summary.worst_after, closer.FarthestOff());
    if (first) {
      summary.worst_before = summary.worst_after;
      summary.bend = closer.Bends();
    }
    if (summary.worst_after <= tolerance.row || summary.products >= kMostProducts) {
      break;
    }
    if (summary.products < kMostInheritedProducts && summary.worst_after > kInheritanceTolerance) {
      closer.ScaleInheritance();
    } else {
      closer.ScaleAll();
    }
  }
  closer.BringDown();
  RETURN_IF_ERROR(closer.MakeRows());
  ASSIGN_OR_RETURN(summary.worst_after, closer.FarthestOff());
  summary.products = closer.products();
  closer.Return(irradiance);
  summary.off = closer.off();
  summary.misplaced = closer.misplaced();
  return summary;
}

}  // namespace isolux
