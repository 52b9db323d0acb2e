#include "common/util/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace isolux {
namespace {

thread_local std::string t_context;

spdlog::level::level_enum ToSpdlog(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarn:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kOff:
      return spdlog::level::off;
  }
  return spdlog::level::info;
}

std::shared_ptr<spdlog::logger> MakeLogger(const std::string& role, LogLevel level) {
  auto logger =
      std::make_shared<spdlog::logger>(role, std::make_shared<spdlog::sinks::stderr_sink_mt>());
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %l %n: %v");
  logger->set_level(ToSpdlog(level));
  logger->flush_on(spdlog::level::debug);
  return logger;
}

// Never destroyed: threads of libraries may still log while statics are taken down.
std::shared_ptr<spdlog::logger>& Logger() {
  static auto* logger = new std::shared_ptr<spdlog::logger>(MakeLogger("isolux", LogLevel::kWarn));
  return *logger;
}

}  // namespace

Result<LogLevel> ParseLogLevel(const std::string& text) {
  if (text == "debug") return LogLevel::kDebug;
  if (text == "info") return LogLevel::kInfo;
  if (text == "warn") return LogLevel::kWarn;
  if (text == "error") return LogLevel::kError;
  if (text == "off") return LogLevel::kOff;
  return Error(StatusCode::kInvalidArgument,
               "'{}' is not a log level: use debug, info, warn, error or off", text);
}

void StartLog(const std::string& role, LogLevel level) { Logger() = MakeLogger(role, level); }

LogContext::LogContext(const std::string& context) : length_before_(t_context.size()) {
  t_context += context + ": ";
}

LogContext::~LogContext() { t_context.resize(length_before_); }

namespace internal {

bool LogEnabled(LogLevel level) { return Logger()->should_log(ToSpdlog(level)); }

void WriteLog(LogLevel level, const std::string& line) {
  std::string text = t_context + line;
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  Logger()->log(ToSpdlog(level), "{}", text);
}

}  // namespace internal
}  // namespace isolux
