// What a patch file says of its own solve, as JSON for the report: docs/report.md lists the keys.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "common/scene/patch_file.h"

namespace isolux {

// {"summary": {KEY: value}, "rounds": [{"round": N, KEY: value}], "traffic": [{"phase", KEY:
// value}], "worker_traffic": [{"worker", "phase", KEY: value}], "effects": [{"name", "decision",
// "present", "bound", "evidence"}], "repairs": [{"count", "what"}]}. Keys that are not known here
// are kept too. What reads as a number is one, and what reads as several a list.
nlohmann::json ReadComments(const PatchFile& file);

}  // namespace isolux
