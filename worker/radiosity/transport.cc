#include "worker/radiosity/transport.h"

namespace isolux {
namespace {

// By how much closure may enlarge a radiosity: the largest factor.
constexpr double kClosureHeadroom = 2.0;

}  // namespace

template <typename V>
Status LinkTransportOf<V>::Apply(LinkScope scope, std::span<const V> radiosity, const V& bound,
                                 std::span<V> irradiance) {
  scaled_.resize(radiosity.size());
  for (size_t i = 0; i < radiosity.size(); ++i) scaled_[i] = radiosity[i] * leaves_.closure[i];
  RETURN_IF_ERROR(product_.Irradiance(std::span<const V>(scaled_), kClosureHeadroom * bound,
                                      irradiance, scope));
  for (size_t i = 0; i < radiosity.size(); ++i) irradiance[i] *= leaves_.closure[i];
  return {};
}

template <typename V>
Status LinkTransportOf<V>::Irradiance(std::span<const V> radiosity, const V& bound,
                                      std::span<V> irradiance) {
  RETURN_IF_ERROR(Apply(LinkScope::kAll, radiosity, bound, irradiance));
  for (size_t i = 0; i < radiosity.size(); ++i) {
    irradiance[i] += radiosity[i] * leaves_.returned[i];
  }
  return {};
}

template <typename V>
Status LinkTransportOf<V>::IrradianceFromOthers(std::span<const V> radiosity, const V& bound,
                                                std::span<V> irradiance) {
  return Apply(LinkScope::kNotLocal, radiosity, bound, irradiance);
}

template <typename V>
LocalRowsOf<V>& LinkTransportOf<V>::rows() {
  if (rows_ == nullptr) {
    rows_ = std::make_unique<LocalRowsOf<V>>(product_.tree(), product_.active(),
                                             product_.local_links(), leaves_.inheritance);
  }
  return *rows_;
}

template <typename V>
void LinkTransportOf<V>::Sweep(std::span<V> radiosity, std::span<const V> from_others,
                               const Update& update) {
  // What the update sees of `radiosity` is without the factors.
  scaled_.resize(radiosity.size());
  for (size_t i = 0; i < radiosity.size(); ++i) scaled_[i] = radiosity[i] * leaves_.closure[i];
  rows().Sweep(std::span<V>(scaled_), [&](size_t leaf, const V& arriving) {
    const double d = leaves_.closure[leaf];
    const V returned = radiosity[leaf] * leaves_.returned[leaf];
    radiosity[leaf] = update(leaf, from_others[leaf] + d * arriving + returned);
    return radiosity[leaf] * d;
  });
}

template <typename V>
void LinkTransportOf<V>::Shoot(size_t leaf, const V& radiosity, std::span<V> irradiance) {
  rows().Shoot(leaf, radiosity * leaves_.closure[leaf], [&](size_t i, const V& arriving) {
    irradiance[i] += arriving * leaves_.closure[i];
  });
  irradiance[leaf] += radiosity * leaves_.returned[leaf];
}

template class LinkTransportOf<Single>;
template class LinkTransportOf<Lanes>;

}  // namespace isolux
