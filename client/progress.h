// How a job is going, on standard error: a line that is redrawn on a terminal, plain lines
// elsewhere.
#pragma once

#include <chrono>
#include <span>
#include <string>
#include <vector>

#include "common/rpc/job_info.h"
#include "common/scene/solve_options.h"

namespace isolux {

class ProgressView {
 public:
  // Draws on a terminal unless CI is set in the environment.
  explicit ProgressView(double accuracy);
  ~ProgressView();  // ends the line
  ProgressView(const ProgressView&) = delete;
  ProgressView& operator=(const ProgressView&) = delete;

  void Show(const RoundSummary& round);
  void Show(const Activity& activity);
  void Say(const std::string& line);

 private:
  void Draw();
  double Done() const;

  const double accuracy_;
  const bool terminal_;
  std::chrono::steady_clock::time_point drawn_{};
  bool line_open_ = false;
  double first_error_ = 0;
  std::vector<RoundSummary> rounds_;
  RoundSummary round_;  // the last one
  Activity activity_;
};

// What is still to come, as the rounds so far have it, some seconds after the last of them: "4.1 %
// → 2 %: about 6 s, 900 k links"; empty where nothing is known.
std::string ForecastText(std::span<const RoundSummary> rounds, double accuracy, double seconds_ago);

// Share of the way from the first round's error to the accuracy asked for, by orders of magnitude.
double ShareDone(double first_error, double error, double accuracy);

}  // namespace isolux
