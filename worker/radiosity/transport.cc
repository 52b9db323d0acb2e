#include "worker/radiosity/transport.h"

namespace isolux {
namespace {

constexpr int kChannels = 3;

// By how much closure may enlarge a radiosity: the largest factor.
constexpr double kClosureHeadroom = 2.0;

}  // namespace

Status LinkTransport::Apply(LinkScope scope, std::span<const Lanes> radiosity, double bound,
                            std::span<Lanes> irradiance) {
  scaled_.resize(radiosity.size());
  for (size_t i = 0; i < radiosity.size(); ++i) scaled_[i] = radiosity[i] * leaves_.closure[i];
  RETURN_IF_ERROR(
      product_.Irradiance(scaled_, kClosureHeadroom * bound, kChannels, irradiance, scope));
  for (size_t i = 0; i < radiosity.size(); ++i) irradiance[i] *= leaves_.closure[i];
  return {};
}

Status LinkTransport::Irradiance(std::span<const Lanes> radiosity, double bound,
                                 std::span<Lanes> irradiance) {
  return Apply(LinkScope::kAll, radiosity, bound, irradiance);
}

Status LinkTransport::IrradianceFromOthers(std::span<const Lanes> radiosity, double bound,
                                           std::span<Lanes> irradiance) {
  return Apply(LinkScope::kNotLocal, radiosity, bound, irradiance);
}

LocalRows& LinkTransport::rows() {
  if (rows_ == nullptr) {
    rows_ = std::make_unique<LocalRows>(product_.tree(), product_.active(), product_.local_links(),
                                        leaves_.inheritance);
  }
  return *rows_;
}

void LinkTransport::Sweep(std::span<Lanes> radiosity, std::span<const Lanes> from_others,
                          const Update& update) {
  for (size_t i = 0; i < radiosity.size(); ++i) radiosity[i] *= leaves_.closure[i];
  rows().Sweep(radiosity, [&](size_t leaf, const Lanes& arriving) {
    const double d = leaves_.closure[leaf];
    return update(leaf, from_others[leaf] + d * arriving) * d;
  });
  for (size_t i = 0; i < radiosity.size(); ++i) radiosity[i] /= leaves_.closure[i];
}

void LinkTransport::Shoot(size_t leaf, const Lanes& radiosity, std::span<Lanes> irradiance) {
  rows().Shoot(leaf, radiosity * leaves_.closure[leaf], [&](size_t i, const Lanes& arriving) {
    irradiance[i] += arriving * leaves_.closure[i];
  });
}

}  // namespace isolux
