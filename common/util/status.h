// Errors as values. What can fail from outside causes (files, flags, peers, time) returns a Status
// or a Result<T>; broken invariants are CHECKs (check.h). Nothing here throws.
#pragma once

#include <fmt/format.h>

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace isolux {

// Equal in number to grpc::StatusCode, so that crossing the wire is a cast.
enum class StatusCode {
  kOk = 0,
  kCancelled = 1,
  kUnknown = 2,
  kInvalidArgument = 3,
  kDeadlineExceeded = 4,
  kNotFound = 5,
  kAlreadyExists = 6,
  kPermissionDenied = 7,
  kResourceExhausted = 8,
  kFailedPrecondition = 9,
  kAborted = 10,
  kOutOfRange = 11,
  kUnimplemented = 12,
  kInternal = 13,
  kUnavailable = 14,
  kDataLoss = 15,
};

class [[nodiscard]] Status {
 public:
  Status() = default;  // success
  Status(StatusCode code, std::string message) : code_(code), message_(std::move(message)) {}

  bool ok() const { return code_ == StatusCode::kOk; }
  StatusCode code() const { return code_; }
  const std::string& message() const { return message_; }

  // The same error with what was being attempted put in front: "job 7: worker 3: ...".
  Status Within(const std::string& context) const {
    return ok() ? *this : Status(code_, context + ": " + message_);
  }

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string message_;
};

template <typename T>
using Result = tl::expected<T, Status>;

// Error(StatusCode::kNotFound, "{}: no such file", path) converts to Status and to any Result<T>.
template <typename... Args>
tl::unexpected<Status> Error(StatusCode code, fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Status>(Status(code, fmt::format(format, std::forward<Args>(args)...)));
}
template <typename... Args>
Status MakeStatus(StatusCode code, fmt::format_string<Args...> format, Args&&... args) {
  return Status(code, fmt::format(format, std::forward<Args>(args)...));
}

namespace internal {
inline Status ToStatus(const Status& s) { return s; }
template <typename T>
Status ToStatus(const Result<T>& r) {
  return r.has_value() ? Status() : r.error();
}
// What a failed step returns: it converts to Status as well as to Result<T>.
struct Failure {
  Status status;
  operator Status() const { return status; }  // NOLINT(google-explicit-constructor)
  template <typename T>
  operator Result<T>() const {  // NOLINT(google-explicit-constructor)
    return tl::unexpected<Status>(status);
  }
};
}  // namespace internal

}  // namespace isolux

#define ISOLUX_CONCAT_INNER(a, b) a##b
#define ISOLUX_CONCAT(a, b) ISOLUX_CONCAT_INNER(a, b)

// Leaves the function with the error of `expr` (a Status or Result) unless it succeeded.
#define RETURN_IF_ERROR(expr)                                                         \
  do {                                                                                \
    if (auto isolux_status = ::isolux::internal::ToStatus(expr); !isolux_status.ok()) \
      return ::isolux::internal::Failure{std::move(isolux_status)};                   \
  } while (false)

// ASSIGN_OR_RETURN(auto x, F()): x is the value, or the function returns the error.
#define ASSIGN_OR_RETURN(lhs, expr) \
  ASSIGN_OR_RETURN_IMPL(ISOLUX_CONCAT(isolux_result_, __LINE__), lhs, expr)
#define ASSIGN_OR_RETURN_IMPL(result, lhs, expr)                                          \
  auto result = (expr);                                                                   \
  if (!result.has_value()) return ::isolux::internal::Failure{std::move(result.error())}; \
  lhs = std::move(*result)
