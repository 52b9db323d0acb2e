// How a job is going, on standard error: a line that is redrawn on a terminal, plain lines
// elsewhere.
#pragma once

#include <chrono>
#include <string>

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
  RoundSummary round_;  // the last one
  Activity activity_;
};

// Share of the way from the first round's error to the accuracy asked for, by orders of magnitude.
double ShareDone(double first_error, double error, double accuracy);

}  // namespace isolux
