// A job in words and in JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/rpc/job_info.h"

namespace isolux {

// The keys of --json: job state accuracy error_estimate elements links rounds rays seconds
// energy_imbalance residual workers end_reason and more; null where nothing is known yet.
nlohmann::json ToJson(const JobInfo& job);

// Several lines for people.
std::string Describe(const JobInfo& job);

// One line: "job 3 done: accuracy reached, error 1.8 %, 4 rounds, 12345 links, 3.2 s".
std::string Summarize(const JobInfo& job);

// "2026-01-31 12:00:00" in local time; "-" for 0.
std::string TimeText(int64_t unix_ms);

}  // namespace isolux
