#include "client/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace isolux {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr int kBarWidth = 20;

bool OnTerminal() {
  const char* ci = std::getenv("CI");
  return ::isatty(STDERR_FILENO) == 1 && (ci == nullptr || *ci == '\0');
}

size_t TerminalColumns() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

// 1234567 as "1.23 M".
std::string Short(uint64_t count) {
  if (count < 10'000) return std::to_string(count);
  const auto value = static_cast<double>(count);
  if (value < 1e6) return fmt::format("{:.3g} k", value / 1e3);
  if (value < 1e9) return fmt::format("{:.3g} M", value / 1e6);
  return fmt::format("{:.3g} G", value / 1e9);
}

}  // namespace

double ShareDone(double first_error, double error, double accuracy) {
  if (!(first_error > accuracy) || !(error > 0)) return error > 0 && error <= accuracy ? 1 : 0;
  return std::clamp(std::log(first_error / error) / std::log(first_error / accuracy), 0.0, 1.0);
}

ProgressView::ProgressView(double accuracy) : accuracy_(accuracy), terminal_(OnTerminal()) {}

ProgressView::~ProgressView() {
  if (!line_open_) return;
  drawn_ = {};
  Draw();
  fmt::print(stderr, "\n");
}

double ProgressView::Done() const {
  return ShareDone(first_error_, round_.error_estimate, accuracy_);
}

void ProgressView::Show(const RoundSummary& round) {
  if (first_error_ == 0) first_error_ = round.error_estimate;
  round_ = round;
  if (terminal_) {
    drawn_ = {};
    Draw();
    return;
  }
  fmt::print(stderr, "round {}: error {:.2f} %, {} links, {} elements, {:.1f} s\n", round.round,
             100 * round.error_estimate, round.links, round.elements, round.seconds);
}

void ProgressView::Show(const Activity& activity) {
  const bool news = activity.phase != activity_.phase;
  activity_ = activity;
  if (terminal_) return Draw();
  // Rounds speak for themselves; what precedes and follows them does not.
  if (news && activity.phase == "waiting for workers") {
    fmt::print(stderr, "{}\n", activity.phase);
  }
}

void ProgressView::Say(const std::string& line) {
  if (line_open_) fmt::print(stderr, "\r\x1b[K");
  line_open_ = false;
  fmt::print(stderr, "{}\n", line);
}

void ProgressView::Draw() {
  const auto now = std::chrono::steady_clock::now();
  if (now - drawn_ < kRedraw) return;
  drawn_ = now;
  const int full = static_cast<int>(std::lround(Done() * kBarWidth));
  std::string line = fmt::format("[{:#<{}}{:.<{}}]", "", full, "", kBarWidth - full);
  if (round_.round > 0) {
    line += fmt::format(" round {}  error {:.2f} % of {:g} %  {} links", round_.round,
                        100 * round_.error_estimate, 100 * accuracy_, Short(round_.links));
  }
  line +=
      fmt::format("  {:.0f} s  {}", std::max(round_.seconds, activity_.seconds), activity_.phase);
  const size_t columns = TerminalColumns();
  if (line.size() >= columns) line.resize(columns - 1);
  fmt::print(stderr, "\r{}\x1b[K", line);
  line_open_ = true;
}

}  // namespace isolux
