// How long a piece of work takes.
#pragma once

#include <chrono>

#include "common/util/parallel.h"

namespace isolux {

// Wall and CPU time of a piece of work.
class Stopwatch {
 public:
  explicit Stopwatch(const ThreadPool& pool) : pool_(pool), wall_(Wall()), cpu_(Cpu()) {}
  double wall_s() const { return Wall() - wall_; }
  double cpu_s() const { return Cpu() - cpu_; }

 private:
  static double Wall() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
  double Cpu() const { return ThreadCpuSeconds() + pool_.CpuSeconds(); }

  const ThreadPool& pool_;
  double wall_, cpu_;
};

}  // namespace isolux
