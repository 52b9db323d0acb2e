// What accuracies of a scene should cost: a few coarse rounds are run, the rest is forecast from
// them.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/scene/forecast.h"
#include "common/scene/scene.h"
#include "common/util/status.h"

namespace CLI {
class App;
}

namespace isolux {

struct CostOptions {
  std::string server;  // HOST:PORT; empty: a coordinator and workers of one's own
  int workers = 1;     // of one's own
};

struct CostTable {
  uint32_t workers = 0, rounds = 0;  // that the forecast is made from
  double reached = 0;                // error estimate of the last of these rounds
  std::vector<Forecast> forecasts;   // by accuracy, 20 % to 0.5 %
};

// Runs rounds for some seconds, then cancels the job.
Result<CostTable> MeasureCost(const Scene& scene, const std::string& name,
                              const CostOptions& options);
using CostFunction =
    std::function<Result<CostTable>(const Scene&, const std::string& name, const CostOptions&)>;

std::string ToText(const CostTable& table);
nlohmann::json ToJson(const CostTable& table);

}  // namespace isolux
