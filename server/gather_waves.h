// Asks the workers for the irradiance at the corners of elements and adds up what they give.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/hierarchy/node_id.h"
#include "common/util/status.h"
#include "server/crew.h"

namespace isolux {

class GatherWaves {
 public:
  // `batch`: elements asked for at once; the workers have the next batch while one is added up.
  GatherWaves(Crew& crew, double accuracy, uint32_t batch)
      : crew_(crew), accuracy_(accuracy), batch_(batch), cpu_s_(crew.size(), 0.0) {}

  // W/m², at least 0: 4 corners × 3 channels an element. The elements are sorted by id; `corners`
  // are those wanted of each, by bits, or kCentre. `news` hears how many elements are done, over
  // all calls.
  Result<std::vector<double>> Gather(const std::vector<NodeId>& elements,
                                     const std::vector<uint8_t>& corners,
                                     const std::function<void(uint64_t)>& news);

  uint64_t gathered() const { return gathered_; }  // elements, over all calls
  uint64_t rays() const { return rays_; }
  const EffectCosts& costs() const { return costs_; }
  const std::vector<double>& cpu_s() const { return cpu_s_; }  // of each worker
  double wall_s() const {
    return wall_s_;
  }  // of the slowest worker of each batch, without messages

 private:
  Status Ask(const std::vector<NodeId>& elements, const std::vector<uint8_t>& corners,
             size_t begin);
  Status Take(size_t begin, size_t count, std::vector<double>* irradiance);

  Crew& crew_;
  const double accuracy_;
  const uint32_t batch_;
  uint64_t gathered_ = 0, rays_ = 0;
  std::vector<double> cpu_s_;
  EffectCosts costs_;
  double wall_s_ = 0;
};

}  // namespace isolux
