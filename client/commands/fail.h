// How a command that works on files alone ends when it cannot.
#pragma once

#include <fmt/format.h>

#include <string_view>

#include "common/util/status.h"

namespace isolux {

// Says why, and returns the exit code: 2 where what was given is to blame, 1 otherwise.
inline int Fail(std::string_view command, const Status& status) {
  fmt::print(stderr, "isolux {}: {}\n", command, status.message());
  const bool of_input = status.code() == StatusCode::kInvalidArgument ||
                        status.code() == StatusCode::kNotFound ||
                        status.code() == StatusCode::kResourceExhausted;
  return of_input ? 2 : 1;
}

}  // namespace isolux
