#include "common/hierarchy/shard_data.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

// Mean of |x| over the deviation of a normal x.
constexpr double kMeanOfAbsolute = 0.7978845608028654;

size_t BinOf(double x, int lowest, size_t bins) {
  if (!(x > 0)) return 0;
  if (!std::isfinite(x)) return bins - 1;
  return static_cast<size_t>(
      std::clamp(EighthOctave(x) - 8 * lowest, 0, static_cast<int>(bins) - 1));
}

}  // namespace

int EighthOctave(double x) {
  static constexpr std::array<double, 7> kRoots = {
      1.0905077326652577, 1.189207115002721, 1.2968395546510096, 1.4142135623730951,
      1.5422108254079407, 1.681792830507429, 1.8340080864093424};  // 2^(k/8)
  const int octave = std::ilogb(x);
  const double over = std::ldexp(x, -octave);
  return 8 * octave +
         static_cast<int>(std::upper_bound(kRoots.begin(), kRoots.end(), over) - kRoots.begin());
}

void ErrorHistogram::Add(double error_w) { ++count[BinOf(error_w, kLowest, count.size())]; }

void ErrorHistogram::Add(const ErrorHistogram& other) {
  for (size_t i = 0; i < count.size(); ++i) count[i] += other.count[i];
}

void LocalErrors::Add(const NodeId& leaf, double error, double area_share) {
  area[BinOf(error, kLowest, area.size())] +=
      static_cast<uint64_t>(std::llround(area_share * kWholeArea));
  if (error > worst || (error == worst && leaf < worst_leaf)) {
    worst = error;
    worst_leaf = leaf;
  }
}

void LocalErrors::Add(const LocalErrors& other) {
  for (size_t i = 0; i < area.size(); ++i) area[i] += other.area[i];
  if (other.worst > worst || (other.worst == worst && other.worst_leaf < worst_leaf)) {
    worst = other.worst;
    worst_leaf = other.worst_leaf;
  }
}

double LocalErrors::Quantile(double share) const {
  double whole = 0;
  for (const uint64_t part : area) whole += static_cast<double>(part);
  // Of the area: where the error is above t. The lowest bin is taken to have none.
  const auto above = [&](double t) {
    double sum = 0;
    for (size_t i = 1; i < area.size(); ++i) {
      if (area[i] == 0) continue;
      const double mean = std::exp2(kLowest + (static_cast<double>(i) + 0.5) / kPerOctave);
      sum += static_cast<double>(area[i]) * std::erfc(t * kMeanOfAbsolute / (mean * M_SQRT2));
    }
    return sum;
  };
  const double wanted = (1 - share) * whole;
  if (!(above(0) > wanted)) return 0;
  double low = std::exp2(kLowest - 8), high = std::exp2(kLowest + 40);
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    (above(middle) > wanted ? low : high) = middle;
  }
  return high;
}

}  // namespace isolux
