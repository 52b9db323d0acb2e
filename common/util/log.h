// What programs tell their operator: lines on standard error, each with the time, the level, the
// program's role and the context of the thread ("job 7", "worker 3").
//
// info: the life of a job and one row a round; warn: what an operator should look at; debug: per
// call. Kernels never log; they count.
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>

#include "common/util/status.h"

namespace isolux {

enum class LogLevel { kDebug, kInfo, kWarn, kError, kOff };

Result<LogLevel> ParseLogLevel(const std::string& text);  // debug|info|warn|error|off

// Once, at the start of a program; before it, warnings and errors alone are written.
void StartLog(const std::string& role, LogLevel level);

// Puts `context` before every line of this thread as long as it lives. Contexts nest.
class LogContext {
 public:
  explicit LogContext(const std::string& context);
  ~LogContext();
  LogContext(const LogContext&) = delete;
  LogContext& operator=(const LogContext&) = delete;

 private:
  size_t length_before_;
};

namespace internal {
bool LogEnabled(LogLevel level);
void WriteLog(LogLevel level, const std::string& line);  // control characters are replaced
template <typename... Args>
void LogLine(LogLevel level, fmt::format_string<Args...> format, Args&&... args) {
  if (LogEnabled(level)) WriteLog(level, fmt::format(format, std::forward<Args>(args)...));
}
}  // namespace internal

template <typename... Args>
void LogDebug(fmt::format_string<Args...> format, Args&&... args) {
  internal::LogLine(LogLevel::kDebug, format, std::forward<Args>(args)...);
}
template <typename... Args>
void LogInfo(fmt::format_string<Args...> format, Args&&... args) {
  internal::LogLine(LogLevel::kInfo, format, std::forward<Args>(args)...);
}
template <typename... Args>
void LogWarn(fmt::format_string<Args...> format, Args&&... args) {
  internal::LogLine(LogLevel::kWarn, format, std::forward<Args>(args)...);
}
template <typename... Args>
void LogError(fmt::format_string<Args...> format, Args&&... args) {
  internal::LogLine(LogLevel::kError, format, std::forward<Args>(args)...);
}

}  // namespace isolux
