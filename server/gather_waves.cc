#include "server/gather_waves.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

constexpr size_t kNumbersPerElement = 4 * 3;  // corners × channels

}  // namespace

Status GatherWaves::Ask(const std::vector<NodeId>& elements, const std::vector<uint8_t>& corners,
                        size_t begin) {
  if (begin >= elements.size()) return {};
  const size_t end = std::min(elements.size(), begin + batch_);
  GatherRequest request;
  request.elements.assign(elements.begin() + static_cast<std::ptrdiff_t>(begin),
                          elements.begin() + static_cast<std::ptrdiff_t>(end));
  request.corners.assign(corners.begin() + static_cast<std::ptrdiff_t>(begin),
                         corners.begin() + static_cast<std::ptrdiff_t>(end));
  request.accuracy = accuracy_;
  return crew_.SendAll(MessageKind::kGather, request);
}

Status GatherWaves::Take(size_t begin, size_t count, std::vector<double>* irradiance) {
  ASSIGN_OR_RETURN(const auto messages, crew_.CollectAll(MessageKind::kGatherPart));
  std::vector<int64_t> total(count * kNumbersPerElement, 0);
  std::optional<int> exponent;
  bool overflow = false;
  double slowest_s = 0;
  for (size_t w = 0; w < messages.size(); ++w) {
    if (!messages[w]) continue;
    ASSIGN_OR_RETURN(const GatherPart part, DecodeMessage<GatherPart>(messages[w]->payload));
    if (part.sums.size() != total.size()) {
      return MakeStatus(StatusCode::kInternal, "gather: {} sums for {} elements", part.sums.size(),
                        count);
    }
    if (exponent && *exponent != part.exponent) {
      return MakeStatus(StatusCode::kInternal, "gather: exponents {} and {}", *exponent,
                        part.exponent);
    }
    exponent = part.exponent;
    rays_ += part.rays;
    costs_.Add(part.costs);
    cpu_s_[w] += part.cpu_s;
    slowest_s = std::max(slowest_s, part.wall_s);
    for (size_t i = 0; i < total.size(); ++i) {
      overflow |= __builtin_add_overflow(total[i], part.sums[i], &total[i]);
    }
  }
  wall_s_ += slowest_s;
  if (overflow) return {StatusCode::kOutOfRange, "gather: sums do not fit 64 bits"};
  for (size_t i = 0; i < total.size(); ++i) {
    // Rays that answer for several sources may take a dark place below nothing.
    (*irradiance)[begin * kNumbersPerElement + i] =
        std::ldexp(static_cast<double>(std::max<int64_t>(total[i], 0)), -exponent.value_or(0));
  }
  return {};
}

Result<std::vector<double>> GatherWaves::Gather(const std::vector<NodeId>& elements,
                                                const std::vector<uint8_t>& corners,
                                                const std::function<void(uint64_t)>& news) {
  std::vector<double> irradiance(elements.size() * kNumbersPerElement, 0.0);
  RETURN_IF_ERROR(Ask(elements, corners, 0));
  for (size_t begin = 0; begin < elements.size(); begin += batch_) {
    RETURN_IF_ERROR(Ask(elements, corners, begin + batch_));
    const size_t count = std::min<size_t>(batch_, elements.size() - begin);
    RETURN_IF_ERROR(Take(begin, count, &irradiance));
    gathered_ += count;
    if (news) news(gathered_);
  }
  return irradiance;
}

}  // namespace isolux
