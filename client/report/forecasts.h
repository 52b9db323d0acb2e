// What the rounds of a finished solve let expect, as each ended: the forecast that the schedule and
// the progress line had then, made again from the rounds.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace isolux {

// `rounds` as ReadComments gives them, in order. [{"round", "seconds": {"low", "likely", "high"},
// "links": …, "elements": …, "memory_bytes": …}] of the run to this accuracy (a share), one for
// each round after which the accuracy was not reached yet. Rounds that lack what a forecast needs
// end the list.
nlohmann::json MakeForecasts(const nlohmann::json& rounds, double accuracy);

}  // namespace isolux
