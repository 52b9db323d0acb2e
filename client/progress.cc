#include "client/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/scene/forecast.h"

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

// Characters, not bytes.
void CutToColumns(size_t columns, std::string* line) {
  size_t seen = 0;
  for (size_t i = 0; i < line->size(); ++i) {
    const bool begins = (static_cast<unsigned char>((*line)[i]) & 0xc0) != 0x80;
    if (begins && seen++ == columns) return line->resize(i);
  }
}

}  // namespace

std::string ForecastText(std::span<const RoundSummary> rounds, double accuracy,
                         double seconds_ago) {
  const auto forecast = ForecastRun(rounds, accuracy);
  if (!forecast) return {};
  const double left_s = std::max(0.0, forecast->remaining_seconds.likely - seconds_ago);
  std::string text =
      fmt::format("{:.2g} % → {:g} %: about ", 100 * rounds.back().error_estimate, 100 * accuracy);
  if (left_s < 120) {
    text += fmt::format("{:.0f} s", std::max(1.0, left_s));
  } else if (left_s < 7200) {
    text += fmt::format("{:.0f} min", left_s / 60);
  } else {
    text += fmt::format("{:.1f} h", left_s / 3600);
  }
  // Its links are there.
  if (forecast->rounds == 0) return text + " to gather";
  return text + fmt::format(", {} links", Short(static_cast<uint64_t>(forecast->links.likely)));
}

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
  std::erase_if(rounds_, [&](const RoundSummary& old) { return old.round >= round.round; });
  rounds_.push_back(round);
  if (terminal_) {
    drawn_ = {};
    Draw();
    return;
  }
  const std::string forecast = ForecastText(rounds_, accuracy_, 0);
  fmt::print(stderr, "round {}: error {:.2f} %, {} links, {} elements, {:.1f} s{}{}\n", round.round,
             100 * round.error_estimate, round.links, round.elements, round.seconds,
             forecast.empty() ? "" : "; ", forecast);
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
  const double now_s = std::max(round_.seconds, activity_.seconds);
  if (round_.round > 0) {
    line +=
        fmt::format(" round {}  {}  {} links", round_.round,
                    ForecastText(rounds_, accuracy_, now_s - round_.seconds), Short(round_.links));
  }
  line += fmt::format("  {:.0f} s  {}", now_s, activity_.phase);
  CutToColumns(TerminalColumns() - 1, &line);
  fmt::print(stderr, "\r{}\x1b[K", line);
  line_open_ = true;
}

}  // namespace isolux
