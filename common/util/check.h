// Broken invariants of our own: print both operands and stop. Never for outside input.
#pragma once

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <string>

namespace isolux::internal {
[[noreturn]] void CheckFailed(const char* file, int line, const std::string& what);
}  // namespace isolux::internal

#define CHECK(condition)                                               \
  do {                                                                 \
    if (!(condition)) [[unlikely]]                                     \
      ::isolux::internal::CheckFailed(__FILE__, __LINE__, #condition); \
  } while (false)

#define ISOLUX_CHECK_OP(op, a, b)                                                    \
  do {                                                                               \
    const auto& isolux_a = (a);                                                      \
    const auto& isolux_b = (b);                                                      \
    if (!(isolux_a op isolux_b)) [[unlikely]]                                        \
      ::isolux::internal::CheckFailed(                                               \
          __FILE__, __LINE__,                                                        \
          fmt::format("{} " #op " {} ({} against {})", #a, #b, isolux_a, isolux_b)); \
  } while (false)

#define CHECK_EQ(a, b) ISOLUX_CHECK_OP(==, a, b)
#define CHECK_NE(a, b) ISOLUX_CHECK_OP(!=, a, b)
#define CHECK_LT(a, b) ISOLUX_CHECK_OP(<, a, b)
#define CHECK_LE(a, b) ISOLUX_CHECK_OP(<=, a, b)
#define CHECK_GT(a, b) ISOLUX_CHECK_OP(>, a, b)
#define CHECK_GE(a, b) ISOLUX_CHECK_OP(>=, a, b)
