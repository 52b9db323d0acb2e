// A few threads for work that waits for the disk, so that gRPC's own never do.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace isolux {

class Executor {
 public:
  explicit Executor(int threads);
  ~Executor();  // does what is left first
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  // The callers bound the number that waits: a call has one at a time.
  void Post(std::function<void()> task);

 private:
  void Run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;  // guarded by mutex_
  bool stop_ = false;                        // guarded by mutex_
  std::vector<std::thread> threads_;
};

}  // namespace isolux
