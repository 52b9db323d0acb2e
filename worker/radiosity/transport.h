// What a solver of B = E + ρH needs of the couplings between leaves: the irradiance that a
// radiosity causes, and, for the methods that work leaf by leaf, sweeps and shots over what is
// coupled within one worker. Solvers see nothing else of links, trees or meshes.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "worker/coupling/lanes.h"
#include "worker/radiosity/local_rows.h"
#include "worker/radiosity/matvec.h"

namespace isolux {

// The leaves of one worker as the solver sees them, side by side.
struct LeafSystem {
  std::vector<double> area_m2;
  std::vector<Lanes> reflectance;
  std::vector<Lanes> exitance;      // W/m²
  std::vector<double> closure;      // factor d of the symmetric closure D C D
  std::vector<double> inheritance;  // factor of what comes from the nodes above

  size_t size() const { return area_m2.size(); }
};

class Transport {
 public:
  virtual ~Transport() = default;

  // Irradiance at own leaves from the radiosity of all leaves, of which `radiosity` are our own.
  // bound: not less than any |radiosity| anywhere, and the same at all workers.
  virtual Status Irradiance(std::span<const Lanes> radiosity, double bound,
                            std::span<Lanes> irradiance) = 0;
  // The part of it that Sweep and Shoot leave out: what crosses between workers.
  virtual Status IrradianceFromOthers(std::span<const Lanes> radiosity, double bound,
                                      std::span<Lanes> irradiance) = 0;

  // Goes through own leaves in order: radiosity[i] = update(i, H) with H the irradiance that the
  // radiosities cause as they are by then, `from_others` included.
  using Update = std::function<Lanes(size_t leaf, const Lanes& irradiance)>;
  virtual void Sweep(std::span<Lanes> radiosity, std::span<const Lanes> from_others,
                     const Update& update) = 0;
  // Adds to the irradiance of own leaves what one of them causes by radiating this.
  virtual void Shoot(size_t leaf, const Lanes& radiosity, std::span<Lanes> irradiance) = 0;
};

// Over the links of a round, with the closure's factors applied on both sides.
class LinkTransport final : public Transport {
 public:
  // All three outlive it. `leaves.closure` may change between solutions.
  LinkTransport(Product& product, const LeafSystem& leaves) : product_(product), leaves_(leaves) {}

  Status Irradiance(std::span<const Lanes> radiosity, double bound,
                    std::span<Lanes> irradiance) override;
  Status IrradianceFromOthers(std::span<const Lanes> radiosity, double bound,
                              std::span<Lanes> irradiance) override;
  void Sweep(std::span<Lanes> radiosity, std::span<const Lanes> from_others,
             const Update& update) override;
  void Shoot(size_t leaf, const Lanes& radiosity, std::span<Lanes> irradiance) override;

 private:
  Status Apply(LinkScope scope, std::span<const Lanes> radiosity, double bound,
               std::span<Lanes> irradiance);
  LocalRows& rows();

  Product& product_;
  const LeafSystem& leaves_;
  std::vector<Lanes> scaled_;
  std::unique_ptr<LocalRows> rows_;  // made when first asked for
};

}  // namespace isolux
