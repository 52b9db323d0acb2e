// What a solver of B = E + ρH needs of the couplings between leaves: the irradiance that a
// radiosity causes, and, for the methods that work leaf by leaf, sweeps and shots over what is
// coupled within one worker. Solvers see nothing else of links, trees or meshes.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/scene/reradiation.h"
#include "worker/radiosity/channels.h"
#include "worker/radiosity/local_rows.h"
#include "worker/radiosity/matvec.h"

namespace isolux {

// V: of one channel (Single) or of three (Lanes).

// The leaves of one worker as the solver sees them, side by side.
template <typename V>
struct LeafSystemOf {
  std::vector<double> area_m2;
  std::vector<V> reflectance;
  std::vector<V> exitance;          // W/m²
  std::vector<V> given;             // irradiance that lights bring, W/m²; empty: there are none
  std::vector<double> closure;      // factor d of the symmetric closure D C D
  std::vector<double> inheritance;  // factor of what comes from the nodes above
  // Of its radiosity, what comes back to a leaf itself: what its row lacks after closing, 0 to 1.
  std::vector<double> returned;
  std::vector<double> specular;  // share reflected as by a mirror; empty: there are no mirrors
  std::vector<V> transmittance;  // of translucent sheets; empty: there are none
  std::vector<Reradiation> reradiation;  // empty: nothing fluoresces
  std::vector<V> passed_on;  // of the exitance, what comes through a sheet, W/m²; empty: not in it

  size_t size() const { return area_m2.size(); }
};
using LeafSystem = LeafSystemOf<Lanes>;

template <typename V>
class TransportOf {
 public:
  virtual ~TransportOf() = default;

  // Irradiance at own leaves from the radiosity of all leaves, of which `radiosity` are our own.
  // bound: of each channel, not less than any |radiosity| anywhere, and the same at all workers.
  virtual Status Irradiance(std::span<const V> radiosity, const V& bound,
                            std::span<V> irradiance) = 0;
  // The part of it that Sweep and Shoot leave out: what crosses between workers.
  virtual Status IrradianceFromOthers(std::span<const V> radiosity, const V& bound,
                                      std::span<V> irradiance) = 0;

  // Goes through own leaves in order: radiosity[i] = update(i, H) with H the irradiance that the
  // radiosities cause as they are by then, `from_others` included.
  using Update = std::function<V(size_t leaf, const V& irradiance)>;
  virtual void Sweep(std::span<V> radiosity, std::span<const V> from_others,
                     const Update& update) = 0;
  // Adds to the irradiance of own leaves what one of them causes by radiating this.
  virtual void Shoot(size_t leaf, const V& radiosity, std::span<V> irradiance) = 0;
};
using Transport = TransportOf<Lanes>;

// Over the links of a round, with the closure's factors applied on both sides, and what comes back
// to each leaf itself.
template <typename V>
class LinkTransportOf final : public TransportOf<V> {
 public:
  using typename TransportOf<V>::Update;

  // All three outlive it. `leaves.closure` and `leaves.returned` may change between solutions.
  LinkTransportOf(Product& product, const LeafSystemOf<V>& leaves)
      : product_(product), leaves_(leaves) {}

  Status Irradiance(std::span<const V> radiosity, const V& bound, std::span<V> irradiance) override;
  Status IrradianceFromOthers(std::span<const V> radiosity, const V& bound,
                              std::span<V> irradiance) override;
  void Sweep(std::span<V> radiosity, std::span<const V> from_others, const Update& update) override;
  void Shoot(size_t leaf, const V& radiosity, std::span<V> irradiance) override;

 private:
  Status Apply(LinkScope scope, std::span<const V> radiosity, const V& bound,
               std::span<V> irradiance);
  LocalRowsOf<V>& rows();

  Product& product_;
  const LeafSystemOf<V>& leaves_;
  std::vector<V> scaled_;
  std::unique_ptr<LocalRowsOf<V>> rows_;  // made when first asked for
};
using LinkTransport = LinkTransportOf<Lanes>;

}  // namespace isolux
